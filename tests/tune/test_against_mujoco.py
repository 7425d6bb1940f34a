"""A proposed setting, driven in the independent simulator (tests/truth): it gains there, too."""

import numpy as np

from tests import truth
from tests.tune.cars import VEHICLE, car, tuned
from wheelhop.predict import read_drives
from wheelhop.vehicle import static_tyre_load

TRACK = truth.Track("washboard", {"amplitude_mm": 10.0, "pitch_mm": 1200.0})
WORDS = "washboard:amplitude_mm=10:pitch_mm=1200"
SPEED_KMPH = 14.0
FRICTION = {"dry-friction": {"coulomb_front_N": 60.0, "coulomb_rear_N": 45.0}}


def objectives(changes):
    """Road-holding and travel, as MuJoCo has them."""
    values = {**VEHICLE.values, **changes}
    time_s = np.arange(400) / 100.0
    run = truth.Run(TRACK, SPEED_KMPH / 3.6, 30.0, time_s)
    motion = truth.integrate(values, run, truth.make_effects(FRICTION))
    inside = motion.time >= 0.0
    static = np.array([static_tyre_load(values, corner) for corner in range(4)])
    load = (motion.tyre_force / static)[inside[1:]]
    extension = (motion.position[:, :4] - motion.position[:, 4:])[inside]
    axles = [np.mean(load[:, i : i + 2] ** 2) for i in (0, 2)]
    return np.array([np.sqrt(np.mean(axles)), np.abs(extension).max()])


def test_what_the_search_states_happens_in_another_simulator():
    known = car(["dry-friction:front_N=60:rear_N=45:presliding_N_m=1.5e6"])
    vary = ["front.damping=±50%", "rear.damping=±50%", "front.stiffness=±30%"]
    drives = read_drives([WORDS], [SPEED_KMPH])
    found = tuned(known, vary, ("road-holding", "travel"), 40, drives)
    keys = {v.name: v.key for v in found.variables}
    first = found.front[0]
    now = objectives({})
    there = objectives({keys[name]: value for name, value in first.values.items()})
    assert found.proposed is first
    assert np.abs(found.now.scores / now - 1.0).max() < 0.02
    stated = np.array([gain.value for gain in first.gains])
    assert np.abs(stated - (now - there)).max() < 0.01 * now.max()
    assert (there < now).all()
