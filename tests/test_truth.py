"""The independent simulator itself: closed forms, conservation, and the shared campaigns."""

from __future__ import annotations

import ast
import tomllib
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigvals

from tests.truth import (
    CHANNELS,
    PRESETS,
    Run,
    Track,
    in_band,
    integrate,
    make_campaign,
    make_effects,
    read_truth,
    simulate_run,
)
from tests.truth.closed_form import ATV, Push, matrices, relative
from tests.truth.model import Car
from tests.truth.tracks import wheel_path

ROOT = Path(__file__).resolve().parents[1]

HERRINGBONE = Track("herringbone", {"amplitude_mm": 20.0, "pitch_mm": 800.0, "angle_deg": 20.0})
TIME = np.arange(200) / 100.0
FRICTION: dict[str, float | str] = {"coulomb_front_N": 75.0, "coulomb_rear_N": 55.0}


# --- the car ------------------------------------------------------------------------------------


@settings(max_examples=10)
@given(preset=st.sampled_from(sorted(PRESETS)), shift=st.floats(-0.2, 0.2))
def test_undamped_frequencies_are_those_of_the_eigenproblem(preset: str, shift: float) -> None:
    vehicle = dict(PRESETS[preset].vehicle)
    vehicle["geometry.cg_to_front_axle_m"] += shift
    model = Car(vehicle).compile()
    data = mujoco.MjData(model)
    stiffness = np.zeros((model.nv, model.nv))
    inverse_mass = np.zeros_like(stiffness)
    for column in range(model.nv):
        data.qpos[:], data.qvel[:], data.qfrc_applied[:] = 0.0, 0.0, 0.0
        data.qfrc_applied[column] = 1e-6
        mujoco.mj_forward(model, data)
        inverse_mass[:, column] = data.qacc / 1e-6
        data.qpos[column], data.qfrc_applied[:] = 1e-6, 0.0
        mujoco.mj_forward(model, data)
        stiffness[:, column] = -data.qfrc_passive / 1e-6
    mass, _, by_hand = matrices(vehicle)
    expected = np.sort(np.sqrt(eigvals(by_hand, mass).real))
    found = np.sort(np.sqrt(np.linalg.eigvals(inverse_mass @ stiffness).real))
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_steady_response_to_a_road_is_that_of_the_matrix_frf() -> None:
    """On a shallow washboard the envelope is the profile, so the road is one sine per wheel."""
    pitch, speed, amplitude = 3.0, 7.5, 0.001
    frequency, omega = speed / pitch, 2.0 * np.pi * speed / pitch
    track = Track("herringbone", {"amplitude_mm": 1.0, "pitch_mm": 3000.0, "angle_deg": 20.0})
    run = Run(track, speed, 60.0, np.arange(400) / 100.0, averaging_s=0.0)  # 10 whole periods
    _, acceleration = simulate_run(ATV, run)
    mass, damping, stiffness = matrices(ATV)
    a, w = ATV["geometry.cg_to_front_axle_m"], ATV["geometry.track_width_m"] / 2.0
    b = ATV["geometry.wheelbase_m"] - a
    ahead = np.array([0.0, 0.0, -a - b, -a - b])
    side = np.array([w, -w, w, -w])
    phase = 2.0 * np.pi / pitch * (60.0 + ahead - side * np.tan(np.radians(20.0)))
    force = np.zeros(7, dtype=complex)
    for i, axle in enumerate(("front", "front", "rear", "rear")):
        stiff = ATV[f"wheel.{axle}.tyre_stiffness_N_m"]
        tyre = stiff + 1j * omega * ATV[f"wheel.{axle}.tyre_damping_N_s_m"]
        force[3 + i] = tyre * amplitude * np.exp(1j * phase[i])
    q = np.linalg.solve(stiffness + 1j * omega * damping - omega**2 * mass, force)
    x = np.array([a, a, -b, -b])
    points = np.concatenate([q[0] - x * q[1] + side * q[2], q[3:]])
    expected = np.imag(-(omega**2) * np.outer(np.exp(1j * omega * run.time_s), points))
    assert frequency == 2.5
    assert relative(acceleration, expected) < 2e-3


def test_static_push_deflects_springs_in_series() -> None:
    """Pushed down over the front axle: each front suspension and tyre carries half the force."""
    front = ATV["geometry.cg_to_front_axle_m"]
    motion = integrate(ATV, Run(Track("flat"), 1.0, 0.0, TIME), [Push(front, 0.0, -100.0)])
    tyre = ATV["wheel.front.tyre_stiffness_N_m"]
    spring = ATV["suspension.front.stiffness_N_m"]
    end = dict(zip(CHANNELS, motion.position[-1], strict=True))
    assert end["A1"] == pytest.approx(-50.0 / tyre, rel=1e-4)
    assert end["B2"] == pytest.approx(-50.0 / tyre - 50.0 / spring, rel=1e-4)
    assert end["B3"] == pytest.approx(0.0, abs=1e-7)


def test_linear_car_superposes_forces() -> None:
    run = Run(Track("flat"), 1.0, 0.0, TIME)
    one, other = Push(0.5, 0.3, 900.0, 3.0), Push(-0.4, -0.2, 700.0, 11.0)
    together = simulate_run(ATV, run, [one, other])[1]
    apart = simulate_run(ATV, run, [one])[1] + simulate_run(ATV, run, [other])[1]
    assert relative(together, apart) < 1e-5


@pytest.mark.parametrize("effects", [{}, {"dry-friction": FRICTION}], ids=["linear", "friction"])
def test_power_from_the_road_is_dissipated(effects: dict[str, dict[str, float | str]]) -> None:
    """Over whole periods of a steady state nothing is stored: what the road puts in at the contact
    leaves through tyre dampers, suspension dampers, and friction at 4 F (X - F/k) per cycle."""
    track = Track("washboard", {"amplitude_mm": 15.0, "pitch_mm": 1000.0})
    motion = integrate(ATV, Run(track, 4.0, 40.0, TIME), make_effects(effects))
    mid = (motion.time[:-1] > -0.0001) & (motion.time[:-1] < 1.9999)  # 8 periods of 0.25 s
    rate = 0.5 * (motion.velocity[1:] + motion.velocity[:-1])[mid]
    road_rate = (np.diff(motion.road, axis=0) / np.diff(motion.time)[:, None])[mid]
    power_in = np.mean(np.sum(motion.tyre_force[mid] * road_rate, axis=1))
    travel_rate = rate[:, 4:] - rate[:, :4]
    axles = ("front", "front", "rear", "rear")
    suspension = np.array([ATV[f"suspension.{axle}.damping_N_s_m"] for axle in axles])
    tyre = np.array([ATV[f"wheel.{axle}.tyre_damping_N_s_m"] for axle in axles])
    lost = np.mean(travel_rate**2 @ suspension + (road_rate - rate[:, 4:]) ** 2 @ tyre)
    if effects:
        travel = motion.position[:-1][mid, 4:] - motion.position[:-1][mid, :4]
        coulomb = np.array([75.0, 75.0, 55.0, 55.0])
        swing = np.ptp(travel, axis=0) / 2.0
        friction = np.sum(4.0 * coulomb * (swing - coulomb / 1.5e6)) / 0.25
        assert friction > 0.15 * power_in
        lost += friction
    assert power_in == pytest.approx(lost, rel=2e-3)


HIDDEN: dict[str, dict[str, float | str]] = {
    "none": {},
    "dry-friction": FRICTION,
    "tyre-lift-off": {},
    "bump-stop": {"clearance_m": 0.015, "stiffness_N_m": 3e4},
    "backlash": {"gap_m": 0.002},
    "mount-bushing": {"stiffness_N_m": 2e5, "damping_N_s_m": 300.0},
}


@pytest.mark.parametrize("name", HIDDEN)
def test_halving_the_step_changes_little(name: str) -> None:
    run = Run(HERRINGBONE, 19.0 / 3.6, 35.0, TIME)
    effects = make_effects({name: HIDDEN[name]})
    step = min([5e-4, *(effect.step_s for effect in effects)])
    coarse = in_band(simulate_run(ATV, run, effects)[1])
    fine = in_band(simulate_run(ATV, run, effects, step_s=step / 2.0)[1])
    assert relative(coarse, fine) < 1e-3


# --- track and logger -----------------------------------------------------------------------------


def test_wheel_climbs_a_step_on_its_edge() -> None:
    radius, height = 0.279, 0.05
    track = Track("step-bump", {"height_mm": 50.0, "width_mm": 2000.0})
    path = wheel_path(track, 0.5, radius, -1.0, 1.0)
    reach = np.sqrt(2.0 * radius * height - height**2)
    x = np.linspace(-reach, 0.0, 50)[1:-1]
    np.testing.assert_allclose(path(x), np.sqrt(radius**2 - x**2) - radius + height, atol=1e-3)
    assert path(np.array([-reach - 0.01]))[0] == 0.0


@settings(max_examples=20)
@given(amplitude=st.floats(0.002, 0.03), pitch=st.floats(0.8, 4.0), radius=st.floats(0.2, 0.35))
def test_envelope_is_the_offset_curve_where_the_wheel_touches_once(
    amplitude: float, pitch: float, radius: float
) -> None:
    wave = 2.0 * np.pi / pitch
    radius = min(radius, 0.9 / (amplitude * wave**2))  # below the profile's radius of curvature
    keys: dict[str, float | str] = {"amplitude_mm": amplitude * 1e3, "pitch_mm": pitch * 1e3}
    path = wheel_path(Track("washboard", keys), 0.0, radius, 2.0 * pitch, 4.0 * pitch)
    contact = np.linspace(2.5 * pitch, 3.5 * pitch, 100)
    slope = amplitude * wave * np.cos(wave * contact)
    normal = np.sqrt(1.0 + slope**2)
    centre = contact - radius * slope / normal
    height = amplitude * np.sin(wave * contact) + radius / normal - radius
    np.testing.assert_allclose(path(centre), height, atol=2e-6)


def test_right_wheel_meets_a_herringbone_crest_first() -> None:
    x = np.linspace(9.0, 10.0, 2001)
    left = wheel_path(HERRINGBONE, 0.59, 0.279, 8.0, 10.0)
    right = wheel_path(HERRINGBONE, -0.59, 0.279, 8.0, 10.0)
    earlier = 2.0 * 0.59 * np.tan(np.radians(20.0))
    np.testing.assert_allclose(right(x - earlier), left(x), atol=2e-6)
    crest = 11.25 * 0.8 + 0.59 * np.tan(np.radians(20.0))
    assert x[:1000][np.argmax(left(x)[:1000])] == pytest.approx(crest, abs=1e-3)


def test_logger_averages_over_its_window() -> None:
    """The mean over T of a sine is sinc(f T) of it, without delay."""
    effect = make_effects({"engine-vibration": {"force_N": 100.0, "freq_hz": 40.0, "x_m": 0.0}})
    run = Run(Track("flat"), 1.0, 0.0, TIME, averaging_s=0.0066)
    mean = simulate_run(ATV, run, effect)[1]
    instant = simulate_run(ATV, replace(run, averaging_s=0.0), effect)[1]
    assert relative(mean, np.sinc(40.0 * 0.0066) * instant) < 1e-3


def test_the_simulator_shares_no_code_with_what_it_judges() -> None:
    for file in (ROOT / "tests/truth").glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            names = [alias.name for alias in getattr(node, "names", [])]
            assert not any(
                "wheelhop" in str(name) for name in [*names, getattr(node, "module", "")]
            )


# --- campaigns ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["clean", "open-dry-friction", "open-driver-seat"])
def test_shared_campaigns_are_reproduced_down_to_their_noise(name: str) -> None:
    """Recorded by another simulator: signs, tracks, timing, friction and seat are one by one right.

    The in-band noise power of each channel is known from the truth, so the residual's is, too. The
    rest is rounding in the truth file (speeds to 6 digits are 0.1 mm of track after 10 s).
    """
    truth_file = ROOT / "tests/data/open_truth" / f"{name}.toml"
    truth = read_truth(ROOT / "examples" / name, truth_file)
    sigma = list(tomllib.loads(truth_file.read_text())["noise"].values())
    noise = np.sqrt(29.5 / 50.0 * np.mean(np.square(sigma)))
    for run_id in ("washboard-low-fast", "herringbone-high-fast", "chassis-twist-medium-fast"):
        predicted = simulate_run(truth.vehicle, truth.runs[run_id], truth.effects)[1]
        residual = in_band(truth.recorded[run_id] - predicted)
        assert np.std(in_band(truth.recorded[run_id])) > 30.0 * noise
        assert np.std(residual) < 1.05 * noise


def test_a_written_campaign_is_explained_by_its_truth(tmp_path: Path) -> None:
    effects: dict[str, dict[str, float | str]] = {
        "sensor-polarity": {"channel": "B2"},
        "engine-vibration": {"force_N": 80.0, "freq_hz": 17.0, "x_m": -0.4},
    }
    folder = make_campaign(tmp_path / "c", seed=5, effects=effects, short=True, noise_rms=0.2)
    truth = read_truth(folder)
    assert len(truth.runs) == 8
    assert sorted(truth.roles.values()) == ["fit"] * 5 + ["validate"] * 3
    run_id = "herringbone-high-fast"
    predicted = simulate_run(truth.vehicle, truth.runs[run_id], truth.effects)[1]
    residual = in_band(truth.recorded[run_id] - predicted)
    assert np.std(residual) == pytest.approx(0.2, rel=0.05)
