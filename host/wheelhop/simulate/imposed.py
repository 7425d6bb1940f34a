"""The force of a spring, a damper and force laws along a motion that a rig imposes.

There is nothing to integrate: laws with memory go through the motion step by step, models of one
make side by side, one in each lane of the processor's vector unit, as in `oscillator.py`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numba
import numpy as np
from numpy.typing import NDArray

from wheelhop.simulate.lanes import LANES, aligned, side_by_side
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
from wheelhop.vehicle import System

Array = NDArray[np.float64]


def forces(
    systems: Sequence[System],
    begins: Sequence[Sequence[float]],
    motion: Array,
    weights: Array,
    dt: float,
    stride: int,
) -> list[Array]:
    """Forces, N, at every sample, of components of one make, whose laws and ports are the same.

    Parameters
    ----------
    systems
        Their equations of motion, each of one degree of freedom.
    begins
        What the law of every port of each remembers at first.
    motion : (3, T)
        Displacement, m, velocity, m/s, and acceleration, m/s², at every step.
    weights : (p, T)
        What the force of each port is times; (0, 0) where no law depends on an input.
    dt
        The step, s.
    stride
        Steps per sample.
    """
    sampled = np.ascontiguousarray(motion[:, ::stride])
    found = [
        np.array([s.stiffness[0, 0], s.damping[0, 0], s.mass[0, 0]]) @ sampled for s in systems
    ]
    laws = systems[0].laws
    if not laws:
        return found
    groups = groups_of(systems[0].port_law, laws)
    for first in range(0, len(systems), LANES):
        some = systems[first : first + LANES]
        port = aligned((6 * len(some[0].port_law), LANES)).reshape(6, -1, LANES)
        port[MEMORY] = side_by_side([np.array(one) for one in begins[first : first + LANES]])
        total = np.zeros((len(some), sampled.shape[1]))
        _follow(
            total,
            motion,
            port,
            side_by_side([system.port[:, 0] for system in some]),
            groups,
            addresses(laws),
            laws_side_by_side([system.law_parameters for system in some]),
            weights,
            dt,
            stride,
        )
        for own, laws_own in zip(found[first : first + LANES], total, strict=True):
            own += laws_own
    return found


@numba.njit(cache=True, nogil=True, error_model="numpy")
def _follow(  # type: ignore[no-untyped-def]
    total, motion, port, row, groups, laws, parameters, weights, dt, stride
):
    """Add the laws' forces at every `stride`-th step to the total (lanes used, samples). Lanes are
    the last axis of `port` and `row`, the first of `parameters`."""
    lanes, ports = len(total), len(row)
    for t in range(motion.shape[1]):
        x, v = motion[0, t], motion[1, t]
        for i in range(ports):
            for s in range(lanes):
                port[START, i, s] = port[X, i, s] if t else row[i, s] * x
                port[X, i, s], port[V, i, s] = row[i, s] * x, row[i, s] * v
        for k in range(len(groups)):
            call(laws[groups[k, 0]], port, dt * min(t, 1), parameters, groups[k, 1], groups[k, 2])
        for i in range(ports):
            for s in range(lanes):
                port[MEMORY, i, s] = port[AFTER, i, s]
                if t % stride == 0:
                    weight = weights[i, t] if len(weights) else 1.0
                    total[s, t // stride] += weight * row[i, s] * port[FORCE, i, s]
