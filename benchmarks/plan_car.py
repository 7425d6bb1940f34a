"""Runs of the car of `mujoco_car.py` as a logger would record them: a third simulator for plans.

It is stepped through `rollout`, with the road as a precomputed force, the ground rolled over by the
disc of tests/truth. Of effects it has what MuJoCo's tendons have: a slip element, a cubic rate.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from benchmarks.mujoco_car import EULER, RUNGE_KUTTA, Rollout, Strut, build, road_force
from tests.truth import Run
from tests.truth.tracks import wheel_path
from tests.truth.vehicle import corner_positions

Array = NDArray[np.float64]
STEP_S, RUN_UP_S, FADE_IN_S, LEAD_OUT_S = 1e-4, 4.0, 1.0, 0.05
STRUTS = {
    "dry-friction": Strut(slip_N=(12.0, 9.0), joint_N_m=1.5e6),
    "progressive-spring": Strut(cubic_N_m3=(2e5, 1e5)),
}
"""What can be hidden: weakly."""


def record(true: Mapping[str, float], run: Run, hidden: str = "") -> Array:
    """Means (n, 8) over the logger's window of the accelerations of B1..B4 and A1..A4, m/s²."""
    steps = round((RUN_UP_S + float(run.time_s[-1]) + LEAD_OUT_S) / STEP_S)
    time_s = -RUN_UP_S + STEP_S * np.arange(steps + 1)
    fade = np.clip((time_s + RUN_UP_S) / FADE_IN_S, 0.0, 1.0)
    fade = fade**2 * (3.0 - 2.0 * fade)
    places = corner_positions(dict(true))
    heights = np.empty((steps + 1, 4))
    for i, (x, y) in enumerate(places):
        way = run.start_m + x - places[0][0] + run.speed_m_s * time_s
        radius = true[f"wheel.{'front' if i < 2 else 'rear'}.radius_m"]
        heights[:, i] = fade * wheel_path(run.track, y, radius, way[0], way[-1])(way)
    middle, rate = 0.5 * (heights[1:] + heights[:-1]), np.diff(heights, axis=0) / STEP_S
    strut = STRUTS.get(hidden, Strut())
    # A tendon that yields would yield in each stage of a method that has several.
    model = build(true, strut, EULER if any(strut.slip_N) else RUNGE_KUTTA)
    model.opt.timestep = STEP_S
    velocity = Rollout(model, road_force(true, middle, rate)[None], 1)()[0]
    body = np.array([[1.0, -x, y] for x, y in places])
    points = np.hstack([velocity[:, :3] @ body.T, velocity[:, 3:7]])
    half = run.averaging_s / 2
    late, early = (
        np.stack([np.interp(run.time_s + lag, time_s[1:], column) for column in points.T], axis=1)
        for lag in (half, -half)
    )
    return np.asarray((late - early) / run.averaging_s)
