"""Motions and loads of a run: closed forms, balances of forces, agreement with the record."""

from pathlib import Path

import numpy as np
import pytest

from wheelhop.effects import load_effects
from wheelhop.predict import Case, read_drives, read_effects
from wheelhop.predict.ride import ride
from wheelhop.simulate import frequency_response
from wheelhop.vehicle import read_vehicle, static_tyre_load

VEHICLE = read_vehicle(Path(__file__).parents[2] / "examples/clean/vehicle.toml")
EFFECTS = ((), ("dry-friction", "progressive-tyre"), ("tyre-lift-off", "driver-seat"))


def case(track, speed, effects=(), vehicle=VEHICLE, **more):
    drives = read_drives([track], [speed])
    return Case(vehicle, read_effects(effects, load_effects()), drives, **more)


@pytest.mark.parametrize("effects", EFFECTS, ids="+".join)
def test_motion_and_record_are_the_same_run(effects):
    one = case("washboard/low", 9.0, effects, seconds=4.0)
    motion = one.motion(0)
    step_s = motion.time_s[1] - motion.time_s[0]
    seen = (motion.acceleration @ one.system.output.T)[motion.recorded]
    assert seen[:: round(0.01 / step_s)] == pytest.approx(one.record(0, 100.0, 0.0), abs=1e-6)
    change = np.diff(motion.displacement, axis=0) / step_s
    between = (motion.velocity[1:] + motion.velocity[:-1]) / 2
    assert np.abs(change - between).max() < 0.02 * np.abs(between).max()


@pytest.mark.parametrize("effects", EFFECTS, ids="+".join)
def test_tyres_carry_all_that_accelerates(effects):
    """Newton's second law for the whole vehicle: no force comes from anywhere but the ground."""
    one = case("washboard/low", 9.0, effects, seconds=4.0)
    motion = one.motion(0)
    lifted = np.ones(len(one.system.mass))
    lifted[1:3] = 0.0  # pitch and roll lift nothing
    momentum = motion.acceleration @ one.system.mass @ lifted
    assert motion.tyre_force.sum(axis=1) == pytest.approx(momentum, abs=1e-6 * 5e3)


def test_over_long_waves_travel_and_load_are_those_of_the_frequency_response():
    """Waves of 6 m at 6 m/s, 1 Hz: a wheel follows them, and the linear model is exact."""
    one = case("washboard:amplitude_mm=20:pitch_mm=6000", 21.6, seconds=10.0)
    found = ride(one, 0)
    late = np.exp(-2j * np.pi * VEHICLE["geometry.wheelbase_m"] / 6.0)
    under = 0.02 * np.array([1.0, 1.0, late, late])
    moved = frequency_response(one.system, 1.0)[0] @ under / -((2 * np.pi) ** 2)
    strut = np.abs(moved[:4] - moved[4:]) / np.sqrt(2)
    assert found.travel_front_rms_m == pytest.approx(strut[0], rel=0.01)
    assert found.travel_rear_rms_m == pytest.approx(strut[2], rel=0.01)
    assert found.travel_rear_peak_m == pytest.approx(strut[2] * np.sqrt(2), rel=0.02)
    stiffness = [VEHICLE[f"wheel.front.tyre_{k}"] for k in ("stiffness_N_m", "damping_N_s_m")]
    load = abs((under[0] - moved[4]) * complex(stiffness[0], 2 * np.pi * stiffness[1]))
    static = static_tyre_load(VEHICLE.values, 0)
    assert found.dynamic_load_front == pytest.approx(load / np.sqrt(2) / static, rel=0.01)


def test_twice_the_track_moves_twice_as_much():
    low, high = (
        ride(case(f"iso8608:unevenness_m3={c}:waviness=2:seed=3", 20.0, seconds=4.0), 0)
        for c in (1e-9, 4e-9)
    )
    for name, value in vars(low).items():
        if name != "tyre_load_least":
            assert getattr(high, name) == pytest.approx(2 * value, rel=0.01), name
    assert 1 - high.tyre_load_least == pytest.approx(2 * (1 - low.tyre_load_least), rel=0.01)


def test_a_tyre_that_lifts_off_never_pulls():
    one = case("step-bump/thesis", 30.0, seconds=4.0)
    two = case("step-bump/thesis", 30.0, ["tyre-lift-off"], seconds=4.0)
    assert ride(one, 0).tyre_load_least < -0.1
    assert ride(two, 0).tyre_load_least == pytest.approx(0.0, abs=1e-9)
