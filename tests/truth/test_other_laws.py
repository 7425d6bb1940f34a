"""Other laws than the textbook's, held against what they say."""

from __future__ import annotations

import numpy as np
import pytest

from .effects import make_effect
from .model import Drive
from .other_laws import BristleFriction, FoamStop, MeasuredDamper, TanhFriction, WanderingEngine
from .presets import PRESETS

ATV = PRESETS["atv"].vehicle
STEP_S = 2e-4


def a_drive(seed: int = 2, seconds: float = 300.0) -> Drive:
    time = np.arange(0.0, seconds, STEP_S)
    path = np.column_stack([5.0 * time, 5.0 * time])
    damping = np.array([630.0, 630.0, 590.0, 590.0])
    none = np.zeros(4)
    return Drive(ATV, time, path, 5.0, np.random.default_rng(seed), none, damping, none, none)


def along(effect, velocity):
    """Force of each strut (n, 4) beyond the linear one, along a common velocity (n,)."""
    travel = np.cumsum(velocity) * STEP_S
    zero = np.zeros(4)
    return np.array(
        [
            effect.suspension(zero, np.full(4, x), np.full(4, v))
            for x, v in zip(travel, velocity, strict=True)
        ]
    )


def test_creeping_friction_is_a_damper_below_its_creep_and_a_constant_above():
    effect = TanhFriction(70.0, 0.0, 0.005)
    force = along(effect, np.array([1e-5, -1e-5, 0.1, -0.1]))
    np.testing.assert_allclose(force[:, 0], [0.14, -0.14, 70.0, -70.0], rtol=1e-4)
    assert not force[:, 2:].any()


def test_bristles_stick_break_away_and_slide():
    """Loaded slowly they hold more than they do once they slide fast; at rest they keep a force."""
    effect = BristleFriction(70.0, 0.0)
    effect.start(a_drive())
    slow, fast = np.full(5000, 0.002), np.full(2000, 0.3)
    force = along(effect, np.concatenate([slow, fast, np.zeros(2000)]))[:, 0]
    assert force[4999] == pytest.approx(70.0 * (1 + 0.3 * np.exp(-0.01)), rel=0.01)
    assert force[6999] == pytest.approx(70.0, rel=0.01)
    assert 60.0 < force[-1] < 71.0


def test_a_measured_damper_has_its_slopes_and_gives_way_sooner_in_compression():
    effect = MeasuredDamper(0.1, 0.4, 0.3)
    effect.start(a_drive())
    for velocity in (1e-4, 3.0, 3.1, -3.0, -3.1):
        effect.start(a_drive())
        settled = along(effect, np.full(200, velocity))[-1, 0] + 630.0 * velocity
        if abs(velocity) < 1.0:
            assert settled == pytest.approx(630.0 * velocity, rel=1e-3)
        else:
            knee = 0.07 if velocity > 0 else 0.13
            line = 630.0 * (0.4 * velocity + 0.6 * knee * np.sign(velocity))
            assert settled == pytest.approx(line, rel=1e-6)


def test_a_stop_of_foam_begins_softly():
    effect = FoamStop(0.02, 3e4, 0.01)
    x = np.array([0.02, 0.025, 0.03, 0.04])
    force = [effect.suspension(np.zeros(4), np.full(4, at), np.zeros(4))[0] for at in x]
    np.testing.assert_allclose(force, [0.0, 3e4 * 0.005**2 / 0.02, 150.0, 450.0], atol=1e-9)


def test_an_idling_engine_differs_from_run_to_run_and_wanders():
    effect = make_effect(
        "engine-vibration",
        {"force_N": 100.0, "freq_hz": 10.0, "run_spread_hz": 0.5, "wander_hz": 0.16, "x_m": 0.0},
    )
    assert isinstance(effect, WanderingEngine)
    frequencies = [effect.frequency_hz(a_drive(seed, 30.0)) for seed in range(30)]
    means = np.array([f.mean() for f in frequencies])
    assert means.std() == pytest.approx(0.5, rel=0.3)
    wander = np.sqrt(np.mean([f.var() for f in frequencies]))
    assert wander == pytest.approx(0.16, rel=0.1)
    drive = a_drive(3, 20.0)
    effect.start(drive)
    crossings = np.count_nonzero(np.diff(np.sign(drive.forces["engine"]))) / 2
    turns = effect.frequency_hz(a_drive(3, 20.0)).mean() * 20.0
    assert crossings == pytest.approx(turns, abs=1.0)


def test_a_wheel_rolls_on_less_than_its_radius():
    slow, fast = (a_drive(2, 2.0) for _ in range(2))
    make_effect("wheel-imbalance", {"imbalance_kg_m": 0.03}).start(slow)
    make_effect("wheel-imbalance", {"imbalance_kg_m": 0.03, "rolling": 0.9}).start(fast)
    ratio = np.abs(fast.forces["A1"]).max() / np.abs(slow.forces["A1"]).max()
    assert ratio == pytest.approx(0.9**-2, rel=1e-3)
