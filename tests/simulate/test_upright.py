"""A mass that stands upright and leans, against the exact equations of an inverted pendulum."""

from math import cos, pi, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.simulate.setup import ATV, campaign_of, model_of, relative, simulated
from tests.simulate.test_against_mujoco import RUNS
from wheelhop.campaign import Averaging
from wheelhop.simulate.integrator import Task, integrate
from wheelhop.vehicle import Assembly

FOOT_KG, MASS_KG, HEIGHT_M, INERTIA = 200.0, 76.0, 0.27, 9.0
K_HEAVE, K_LEAN = 276.0 * (2 * pi * 3.0) ** 2, INERTIA * (2 * pi * 1.6) ** 2


def ours(tilt, lift, *, moment=MASS_KG * HEIGHT_M):
    """Accelerations (n, 2) of foot and angle every 2 ms for a second, released at lift and tilt."""
    parts = Assembly(prescribed=())
    foot, lean = (((1.0, parts.add_coordinate(name)),) for name in ("foot", "lean"))
    parts.add_mass(foot, FOOT_KG + MASS_KG)
    parts.add_mass(lean, INERTIA)
    parts.add_spring(foot, K_HEAVE)
    parts.add_spring(lean, K_LEAN)
    parts.add_upright(foot, lean, moment)
    parts.add_output(foot)
    parts.add_output(lean)
    steps, initial = 502, np.zeros(10)
    initial[3:5] = lift, tilt
    task = Task(
        parts.system((1.0, 1.0, 1.0)),
        np.zeros((steps + 1, 0)),
        np.zeros((steps + 1, 0)),
        np.zeros((2 * steps + 1, 0)),
        initial,
    )
    sampling = {"step_s": 0.002, "first": 1, "stride": 1, "averaging": Averaging(0.0)}
    return integrate([task], **sampling, n_samples=500)[0]


def exact(tilt, lift):
    """The same of m (z̈ − h (φ̈ sin φ + φ̇² cos φ)) and I φ̈ − m h z̈ sin φ: nothing left out."""
    moment = MASS_KG * HEIGHT_M

    def rate(_, y):
        z, angle, _, turning = y
        mass = [[FOOT_KG + MASS_KG, -moment * sin(angle)], [-moment * sin(angle), INERTIA]]
        force = [-K_HEAVE * z + moment * turning**2 * cos(angle), -K_LEAN * angle]
        return [*y[2:], *np.linalg.solve(mass, force)]

    start, time = [lift, tilt, 0.0, 0.0], 0.002 * np.arange(1, 501)
    found = solve_ivp(rate, (0.0, 1.1), start, "DOP853", rtol=1e-11, atol=1e-13, dense_output=True)
    return np.array([rate(t, found.sol(t))[2:] for t in time])


@pytest.mark.parametrize("channel", [0, 1])
def test_what_is_left_out_is_of_the_third_order(channel):
    """Without the mass's height the error is of the second: half the motion leaves a quarter of it.
    With it half the motion leaves an eighth."""
    motions = [(0.1, 0.01), (0.05, 0.005)]
    with_it, without = (
        [
            np.abs(ours(*motion, moment=moment) - exact(*motion))[:, channel].max()
            for motion in motions
        ]
        for moment in (MASS_KG * HEIGHT_M, 0.0)
    )
    assert 3.5 < without[0] / without[1] < 4.5
    assert 7.0 < with_it[0] / with_it[1] < 9.0
    assert with_it[0] < 0.1 * without[0]


THETA = {"inertia_kg_m2": 9.0, "freq_hz": 1.6, "zeta": 0.15}


def herringbone(theta):
    run = {"herringbone": RUNS["herringbone"]}
    found = simulated(campaign_of(run), model_of(ATV, run, "driver-rocking", theta))
    return found["herringbone"]


def test_a_driver_held_stiffly_rolls_with_the_body_however_high_his_mass():
    """What his mass does the body's did when he was part of it."""
    held = THETA | {"freq_hz": 60.0, "zeta": 1.0}
    sways, rolls = (
        relative(herringbone(theta | {"lean_1_m": 2.5}), herringbone(theta | {"lean_1_m": 0.0}))
        for theta in (THETA, held)
    )
    assert sways > 0.005
    assert rolls < 0.05 * sways
