"""A mass on a spring, a damper and force laws, moved by a force: the hot loop of a rig.

The scheme is that of `runge_kutta.py`, at a fixed step. Models of one make go through the loop side
by side, one in each lane of the processor's vector unit, as in `integrator.py`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numba
import numpy as np
from numpy.typing import NDArray

from wheelhop.simulate.lanes import LANES, aligned, load, plus, side_by_side, splat, store
from wheelhop.simulate.laws import (
    AFTER,
    FORCE,
    MEMORY,
    START,
    V,
    X,
    addresses,
    call,
    groups_of,
    laws_side_by_side,
)
from wheelhop.simulate.runge_kutta import HALF_STEPS, STAGES, TO_NEXT, TOTAL, WEIGHTS
from wheelhop.vehicle import System

Array = NDArray[np.float64]

FAR_M = 1e3
"""A component that has come so far has run away."""


def displacements(
    systems: Sequence[System],
    starts: Sequence[Sequence[float]],
    force: Array,
    weights: Array,
    dt: float,
    stride: int,
) -> list[Array]:
    """How components of one make, whose laws and ports are the same ones, move under a force.

    Parameters
    ----------
    systems
        Their equations of motion, each of one degree of freedom.
    starts
        Displacement, m, and velocity, m/s, of each at the first step; the constant force, N, that
        acts on it beside `force`: a preload, a weight, the zero of a load cell; and what the law of
        every port remembers at first.
    force : (2 T + 1,)
        The force, N, at every half step.
    weights : (p, 2 T + 1)
        What the force of each port is times; (0, 0) where no law depends on an input.
    dt
        The step, s.
    stride
        Steps per sample.

    Returns
    -------
    (T / stride + 1,) displacements, m, of each; NaN from where one runs away.
    """
    found: list[Array] = []
    laws = systems[0].laws
    groups = groups_of(systems[0].port_law, laws)
    for begin in range(0, len(systems), LANES):
        some = systems[begin : begin + LANES]
        out = aligned((len(force) // 2 // stride + 1, LANES))
        own = starts[begin : begin + LANES]
        state = side_by_side([np.array(start[:2]) for start in own])
        port = aligned((6 * len(some[0].port_law), LANES)).reshape(6, -1, LANES)
        port[MEMORY] = side_by_side([np.array(start[3:]) for start in own])
        _integrate(
            out,
            state,
            port,
            side_by_side([_motion(*pair) for pair in zip(some, own, strict=True)]),
            side_by_side([system.port[:, 0] for system in some]),
            groups,
            addresses(laws),
            laws_side_by_side([system.law_parameters for system in some]),
            force,
            weights,
            dt,
            stride,
        )
        found += [_until_it_runs_away(out[:, lane].copy()) for lane in range(len(some))]
    return found


def _motion(system: System, start: Sequence[float]) -> Array:
    """Acceleration per force, velocity, displacement, by the constant force, and per force of each
    port."""
    linear = [1.0, -system.damping[0, 0], -system.stiffness[0, 0], start[2]]
    numbers = [*linear, *-system.port[:, 0]]
    return np.asarray(np.array(numbers) / system.mass[0, 0])


def _until_it_runs_away(x: Array) -> Array:
    away = ~(np.abs(x) < FAR_M)
    if away.any():
        x[np.argmax(away) :] = np.nan
    return x


@numba.njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _integrate(  # type: ignore[no-untyped-def]
    out, state, port, motion, row, groups, laws, parameters, w, weights, dt, stride
):
    """Displacement (T/stride+1, LANES) at every `stride`-th step. Lanes are the last axis of all
    arrays but `parameters`, which is (lanes used, ports, …), w (2T+1,)
    and the weights (p, 2T+1)."""
    ports, nothing = row.shape[0], splat(0.0)
    x, v = load(state, 0), load(state, 1)
    store(out, 0, x)
    for i in range(ports):
        store(port, START * ports + i, plus(nothing, load(row, i), x))
    for t in range(len(w) // 2):
        at_x, at_v, change_x, change_v = x, v, nothing, nothing
        for stage in range(STAGES):
            half = HALF_STEPS[stage]
            a = plus(load(motion, 3), splat(w[2 * t + half]), load(motion, 0))
            a = plus(plus(a, load(motion, 1), at_v), load(motion, 2), at_x)
            if len(laws):
                for i in range(ports):
                    store(port, X * ports + i, plus(nothing, load(row, i), at_x))
                    store(port, V * ports + i, plus(nothing, load(row, i), at_v))
                for k in range(len(groups)):
                    first, last = groups[k, 1], groups[k, 2]
                    call(laws[groups[k, 0]], port, 0.5 * dt * half, parameters, first, last)
                for i in range(ports):
                    own = load(port, FORCE * ports + i)
                    if len(weights):
                        own = plus(nothing, splat(weights[i, 2 * t + half]), own)
                    a = plus(a, load(motion, 4 + i), own)
            weight, advance = splat(WEIGHTS[stage]), splat(TO_NEXT[stage] * dt)
            change_x = plus(change_x, weight, at_v)
            change_v = plus(change_v, weight, a)
            at_x, at_v = plus(x, advance, at_v), plus(v, advance, a)
        x = plus(x, splat(dt / TOTAL), change_x)
        v = plus(v, splat(dt / TOTAL), change_v)
        if len(laws):
            for i in range(ports):
                store(port, X * ports + i, plus(nothing, load(row, i), x))
                store(port, V * ports + i, plus(nothing, load(row, i), v))
            for k in range(len(groups)):
                if groups[k, 3]:
                    call(laws[groups[k, 0]], port, dt, parameters, groups[k, 1], groups[k, 2])
            for i in range(ports):
                store(port, MEMORY * ports + i, load(port, AFTER * ports + i))
                store(port, START * ports + i, load(port, X * ports + i))
        if (t + 1) % stride == 0:
            store(out, (t + 1) // stride, x)
