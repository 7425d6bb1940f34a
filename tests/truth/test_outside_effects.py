"""The laws that no library knows, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from tests.truth import Run, Track, simulate_run
from tests.truth import outside_effects as outside
from tests.truth.closed_form import ATV, relative
from tests.truth.model import Drive

STEP = 5e-4
TIME = STEP * np.arange(-8000, 20001)
K, C = np.full(4, 1e4), np.full(4, 500.0)


def a_drive() -> Drive:
    path = np.column_stack([40.0 + 5.0 * TIME, 40.0 + 5.0 * TIME])
    tyre = np.full(4, 4e4)
    return Drive(ATV, TIME, path, 5.0, np.random.default_rng(2), K, C, tyre, np.zeros(4))


def driven(effect, compression: np.ndarray) -> np.ndarray:
    """What the effect adds at the front left while all corners move alike."""
    effect.start(a_drive())
    rate = np.gradient(compression, STEP)
    one = np.ones(4)
    hook = effect.tyre if effect.has_law("tyre") else effect.suspension
    added = [hook(np.zeros(4), x * one, v * one) for x, v in zip(compression, rate, strict=True)]
    return np.array(added)[:, 0]


def test_hysteresis_ends_at_its_force_and_begins_with_its_stiffness() -> None:
    slow = np.linspace(0.0, 0.2, 20000)
    bouc_wen = driven(outside.BoucWenSpring(80.0, 0.01), slow)
    assert bouc_wen[-1] == pytest.approx(80.0, rel=1e-3)
    assert bouc_wen[10] / slow[10] == pytest.approx(80.0 / 0.01, rel=0.02)
    tyre = driven(outside.TyreHysteresis(0.05, 0.5), slow)
    load = 9.81 * (ATV["body.mass_kg"] * (1.42 - 0.80) / 1.42 / 2.0 + 15.0)
    assert tyre[-1] == pytest.approx(0.05 * load)
    assert tyre[10] / slow[10] == pytest.approx(0.5 * 4e4)


def test_oil_through_an_orifice_through_ports_and_oil_that_warms_up() -> None:
    ramp = np.arange(len(TIME)) * STEP * 0.5  # 0.5 m/s
    orifice = driven(outside.OrificeDamping(0.6, 2.0), ramp)
    np.testing.assert_allclose(orifice, 0.6 * 500.0 / 2.0 * 0.25)
    bypass = driven(outside.BypassDamping(0.5, 0.02), ramp)
    np.testing.assert_allclose(bypass[80], 0.5 * 500.0 * 0.5)  # 20 mm from rest at 0.5 m/s
    fade = driven(outside.DamperFade(0.4), ramp)
    np.testing.assert_allclose(fade[:8000], 0.0)  # before the record begins
    assert fade[-1] == pytest.approx(-0.4 * 500.0 * 0.5)


def test_an_oval_wheel_pushes_twice_a_turn() -> None:
    drive = a_drive()
    outside.OutOfRoundness(1e-3, 2.0).start(drive)
    spectrum = np.abs(np.fft.rfft(drive.forces["A2"]))
    turns_hz = 5.0 / ATV["wheel.front.radius_m"] / (2.0 * np.pi)
    peak_hz = np.argmax(spectrum) / (len(TIME) * STEP)
    assert peak_hz == pytest.approx(2.0 * turns_hz, abs=0.1)
    assert drive.forces["A2"].max() == pytest.approx(40.0, rel=1e-3)


def test_a_quadratic_sensor() -> None:
    samples = np.full((5, 8), 2.0)
    found = outside.SensorNonlinearity("B3", 0.1).sense(samples)
    np.testing.assert_allclose(found[:, 2], 2.4)
    np.testing.assert_allclose(np.delete(found, 2, axis=1), 2.0)


@pytest.mark.parametrize(
    ("stiff", "soft"),
    [
        (outside.FrameBending(10.0, 0.05, 1e7), outside.FrameBending(10.0, 0.05, 200.0)),
        (
            outside.UnlatchedPayload(10.0, 200.0, 0.1, -0.5, 0.3),
            outside.UnlatchedPayload(10.0, 6.0, 0.1, -0.5, 0.3),
        ),
    ],
)
def test_a_frame_and_straps_too_stiff_to_move_leave_the_baseline(stiff, soft) -> None:
    track = Track("washboard", {"amplitude_mm": 5.0, "pitch_mm": 600.0})
    run = Run(track, 4.0, 40.0, np.arange(200) / 100.0)
    baseline = simulate_run(ATV, run)[1]
    assert relative(simulate_run(ATV, run, [stiff])[1], baseline) < 2e-3
    assert relative(simulate_run(ATV, run, [soft])[1], baseline) > 0.01
