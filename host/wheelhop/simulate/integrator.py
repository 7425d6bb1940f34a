"""Time integration of a mechanism with nonlinear force laws: the one hot loop of wheelhop.

The scheme is that of `runge_kutta.py`, at a fixed step. Force laws are called by their addresses
(`laws.py`), so that the integrator is compiled once and any set of laws can be combined. Mechanisms
of one make, as derivatives ask for, go through the loop side by side, one in each lane of the
processor's vector unit.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Averaging
from wheelhop.simulate.lanes import LANES, aligned, load, plus, side_by_side, splat, store
from wheelhop.simulate.laws import (
    AFTER,
    FORCE,
    MEMORY,
    START,
    X,
    addresses,
    call,
    groups_of,
    laws_side_by_side,
)
from wheelhop.simulate.runge_kutta import HALF_STEPS, STAGES, TO_NEXT, TOTAL, WEIGHTS
from wheelhop.vehicle import System

Array = NDArray[np.float64]

_compiled: Any = numba.njit(cache=True, nogil=True, fastmath=True, error_model="numpy")

Sparse = tuple[NDArray[np.int64], NDArray[np.int64], Array]
"""Matrices by rows: where each row's entries begin, their columns, and their values (…, LANES)."""


@numba.njit(cache=True, nogil=True, fastmath=True, inline="always")
def _apply(result, first, matrix, vector):  # type: ignore[no-untyped-def]
    """Matrix times vector into the rows of `result` from the `first` on."""
    begins, columns, values = matrix
    for i in range(len(begins) - 1):
        total = splat(0.0)
        for k in range(begins[i], begins[i + 1]):
            total = plus(total, load(values, k), load(vector, columns[k]))
        store(result, first + i, total)


@numba.njit(cache=True, nogil=True, fastmath=True, inline="always")
def _given(array, t, j):  # type: ignore[no-untyped-def]
    """What moves the mechanisms, alike for all (T, k, 1) or one for each (T, k, LANES)."""
    return load(array, t * array.shape[1] + j) if array.shape[2] > 1 else splat(array[t, j, 0])


@numba.njit(cache=True, nogil=True, fastmath=True, inline="always")
def _drive(z, first, u, du, w, half_step, dt):  # type: ignore[no-untyped-def]
    """Prescribed motion, its rate and the applied forces at a half step into z, from row `first`
    on; between steps the motion is a cubic Hermite polynomial."""
    m, k, t = u.shape[1], w.shape[1], half_step // 2
    for j in range(m):
        x, v = _given(u, t, j), _given(du, t, j)
        if half_step % 2 == 1:
            x_next, v_next = _given(u, t + 1, j), _given(du, t + 1, j)
            middle = plus(plus(splat(0.0), splat(0.5), x), splat(0.5), x_next)
            middle = plus(plus(middle, splat(0.125 * dt), v), splat(-0.125 * dt), v_next)
            rate = plus(plus(splat(0.0), splat(-1.5 / dt), x), splat(1.5 / dt), x_next)
            x, v = middle, plus(plus(rate, splat(-0.25), v), splat(-0.25), v_next)
        store(z, first + j, x)
        store(z, first + m + j, v)
    for j in range(k):
        store(z, first + 2 * m + j, _given(w, half_step, j))


@numba.njit(cache=True, nogil=True, fastmath=True, inline="always")
def _sample(  # type: ignore[no-untyped-def]
    y, output, mean, q, acc, v_old, a_old, t, first, stride, ends, weights,
):  # fmt: skip
    """Adds to the samples what they take of the step just finished (`_taps`)."""
    n, c = acc.shape[0], y.shape[1]
    for tap in range(len(ends)):
        since = t - first - ends[tap]
        if since < 0 or since % stride != 0 or since // stride >= y.shape[0]:
            continue
        h00, h01 = splat(weights[tap, 0]), splat(weights[tap, 1])
        h10, h11 = splat(weights[tap, 2]), splat(weights[tap, 3])
        for i in range(n):
            v = plus(plus(splat(0.0), h00, load(v_old, i)), h01, load(q, n + i))
            store(mean, i, plus(plus(v, h10, load(a_old, i)), h11, load(acc, i)))
        row = since // stride * c
        _apply(mean, n, output, mean)
        for o in range(c):
            store(y, row + o, plus(load(y, row + o), splat(1.0), load(mean, n + o)))


@numba.njit(cache=True, nogil=True, fastmath=True, inline="always")
def _lean(acc, room, leaning, z):  # type: ignore[no-untyped-def]
    """Adds to the accelerations what masses do that stand upright (`System.leaning`): they follow
    from the accelerations without it, as these masses are a small part of the whole."""
    of_state, of_acceleration, to_acceleration = leaning
    n, count = acc.shape[0], (len(of_state[0]) - 1) // 2
    _apply(room, 0, of_state, z)
    _apply(room, 2 * count, of_acceleration, acc)
    for i in range(count):
        angle, rate = load(room, i), load(room, count + i)
        faster, lift = load(room, 2 * count + i), load(room, 3 * count + i)
        store(room, i, plus(plus(splat(0.0), rate, rate), angle, faster))
        store(room, count + i, plus(splat(0.0), angle, lift))
    _apply(room, 4 * count, to_acceleration, room)
    for i in range(n):
        store(acc, i, plus(load(acc, i), splat(1.0), load(room, 4 * count + i)))


@_compiled
def _integrate(  # type: ignore[no-untyped-def]
    y, room, motion, extension, output, leaning, groups, laws, parameters, u, du, w, q, dt, first,
    stride, ends, weights,
):  # fmt: skip
    """Run-time loop; lanes are the last axis of all arrays but `parameters`. It goes by the vector
    z = (x, ẋ, u, u̇, w, f) of state, prescribed motions, applied forces and laws' forces: `motion`
    z is ẍ, `extension` z the ports' extensions and rates, `output` ẍ the outputs. u, du: (T+1, m)
    and w: (2T+1, k), the last axis 1 where alike for all; q: (2n,) state; parameters: (lanes used,
    ports, …); `room` for z, the ports, and what a step needs. Adds the mean accelerations to y
    (n_samples, c)."""
    n, ports = q.shape[0] // 2, parameters.shape[1]
    driven = 2 * n + 2 * u.shape[1]
    forced = driven + w.shape[1]
    z, port, change, acc, v_old, a_old, mean, lean = room
    for i in range(2 * n):
        store(z, i, load(q, i))
    _drive(z, 2 * n, u, du, w, 0, dt)
    _apply(port, X * ports, extension, z)
    for i in range(ports):
        store(port, START * ports + i, load(port, X * ports + i))

    for t in range(u.shape[0] - 1):
        for stage in range(STAGES):
            half = HALF_STEPS[stage]
            if stage > 0 and half > HALF_STEPS[stage - 1]:
                _drive(z, 2 * n, u, du, w, 2 * t + half, dt)
            if len(laws):
                if stage > 0:  # else they are still where the last step left them
                    _apply(port, X * ports, extension, z)
                elapsed = 0.5 * dt * half
                for k in range(len(groups)):
                    law = laws[groups[k, 0]]
                    call(law, port, elapsed, parameters, groups[k, 1], groups[k, 2])
                for i in range(ports):
                    store(z, forced + i, load(port, FORCE * ports + i))
            _apply(acc, 0, motion, z)
            if lean.shape[0]:
                _lean(acc, lean, leaning, z)
            if stage == 0:
                _sample(
                    y, output, mean, q, acc, v_old, a_old, t, first, stride, ends, weights,
                )  # fmt: skip
                for i in range(n):
                    store(v_old, i, load(q, n + i))
                    store(a_old, i, load(acc, i))
            weight, advance = splat(WEIGHTS[stage]), splat(TO_NEXT[stage] * dt)
            for i in range(2 * n):
                rate = load(z, n + i) if i < n else load(acc, i - n)
                before = splat(0.0) if stage == 0 else load(change, i)
                store(change, i, plus(before, weight, rate))
                store(z, i, plus(load(q, i), advance, rate))
        for i in range(2 * n):
            end = plus(load(q, i), splat(dt / TOTAL), load(change, i))
            store(q, i, end)
            store(z, i, end)
        if len(laws):
            # The motion at the end of the step is in z already.
            _apply(port, X * ports, extension, z)
            for k in range(len(groups)):
                if groups[k, 3]:
                    law = laws[groups[k, 0]]
                    call(law, port, dt, parameters, groups[k, 1], groups[k, 2])
            for i in range(ports):
                store(port, MEMORY * ports + i, load(port, AFTER * ports + i))
                store(port, START * ports + i, load(port, X * ports + i))


@dataclass(frozen=True, eq=False)
class Task:
    """A mechanism and what moves it.

    Parameters
    ----------
    system
        The mechanism.
    height, rate : (T + 1, m)
        Prescribed motions (m) and their rates (m/s) at every step.
    force : (2 T + 1, k)
        Applied forces (N) at every half step.
    initial : (2 n,)
        Displacements and velocities at the first step.
    """

    system: System
    height: Array
    rate: Array
    force: Array
    initial: Array

    @property
    def make(self) -> tuple[object, ...]:
        """What mechanisms that are integrated side by side have in common."""
        s = self.system
        sizes = (*s.output.shape, s.reads, *self.height.shape, *self.force.shape, len(s.upright))
        return (*sizes, s.port_law, s.laws)


def integrate(
    tasks: Sequence[Task],
    *,
    step_s: float,
    first: int,
    stride: int,
    averaging: Averaging,
    n_samples: int,
) -> list[Array]:
    """What the outputs of mechanisms of one make show, accelerations and readings.

    Parameters
    ----------
    tasks
        The mechanisms and their motions.
    step_s
        Step of the integration. Accuracy needs (highest natural frequency) × step below about 1.
    first, stride
        Sample i is taken at step first + i · stride.
    averaging
        What each sample is the mean of.
    n_samples
        Number of samples; what the last is the mean of must end before step T.

    Returns
    -------
    (n_samples, c) of each, SI; NaN columns for outputs that are not predicted.
    """
    if any(task.system.port_by and any(task.system.port_by) for task in tasks):
        raise ValueError("a law that depends on an input acts on a component on a rig alone")
    steps = len(tasks[0].height) - 1
    ends, weights = _taps(averaging, step_s)
    if first + min(ends) < 1 or first + (n_samples - 1) * stride + max(ends) >= steps:
        raise ValueError("the samples do not lie inside the integrated span")
    sampling = (step_s, first, stride, ends, weights)
    found: list[Array] = []
    for begin in range(0, len(tasks), LANES):
        together = tasks[begin : begin + LANES]
        y = aligned((n_samples, len(together[0].system.output), LANES))
        _integrate(y, _room(together[0]), *_arguments(together), *sampling)
        for lane, task in enumerate(together):
            record = y[:, :, lane].copy()
            record[:, np.isnan(task.system.output).any(axis=1)] = np.nan
            found.append(record)
    return found


@lru_cache(maxsize=64)
def _taps(averaging: Averaging, step_s: float) -> tuple[NDArray[np.int64], Array]:
    """What samples take of the motion: how many steps after a sample the steps end of which it
    takes something (m,), and so much of velocities and accelerations at their beginnings and ends,
    (v, v, a, a), (m, 4): a mean acceleration is the velocity at the end of its window less that at
    the beginning, a cubic Hermite polynomial within a step."""
    half, found = averaging.window_s / 2, defaultdict[float, float](float)
    size = 1.0 / (averaging.count * (2 * half or 1.0))
    for centre in averaging.centres_s:
        for edge, sign in ((half, 1.0), (-half, -1.0)) if half else ((0.0, 1.0),):
            # Where windows abut, the end of one is the beginning of the next.
            found[round((centre + edge) / step_s, 9)] += sign * size
    at = np.array([instant for instant, weight in found.items() if abs(weight) > 1e-9 * size])
    weight = np.array([found[instant] for instant in at])
    ends = np.ceil(at).astype(np.int64)
    p = at - ends + 1.0
    if half:
        h00, h01 = (1 + 2 * p) * (1 - p) ** 2, p * p * (3 - 2 * p)
        h10, h11 = p * (1 - p) ** 2 * step_s, p * p * (p - 1) * step_s
    else:
        h01 = 6 * p * (1 - p) / step_s
        h00, h10, h11 = -h01, (1 - p) * (1 - 3 * p), p * (3 * p - 2)
    return ends, np.ascontiguousarray(weight[:, None] * np.stack([h00, h01, h10, h11], axis=1))


def _arguments(tasks: Sequence[Task]) -> list[object]:
    """What the loop takes, the sampling left out."""
    return [
        *_mechanisms(tuple(task.system for task in tasks)),
        *(_alike([getattr(task, name) for task in tasks]) for name in ("height", "rate", "force")),
        side_by_side([task.system.widened(task.initial) for task in tasks]),
    ]


@lru_cache(maxsize=64)
def _mechanisms(systems: tuple[System, ...]) -> tuple[object, ...]:
    """Their matrices and laws: a fit asks for the same ones side by side in every run."""
    laws = systems[0].laws
    motion, extension, output = zip(*(system.explicit for system in systems), strict=True)
    leaning = zip(*(system.leaning for system in systems), strict=True)
    return (
        *(_sparse(motion), _sparse(extension), _sparse(output)),
        tuple(_sparse(matrices) for matrices in leaning),
        groups_of(systems[0].port_law, laws),
        addresses(laws),
        laws_side_by_side([system.law_parameters for system in systems]),
    )


def _room(task: Task) -> tuple[Array, ...]:
    """The loop's own vectors: z, the ports, the sums of a step, accelerations, velocities and
    accelerations at its beginning, their mean over the window and what the outputs show of it, and
    what stands upright."""
    c, n = task.system.output.shape
    n += len(task.system.reads)
    ports, k, m = len(task.system.port_law), task.force.shape[1], task.height.shape[1]
    upright = len(task.system.upright)
    lean = 4 * upright + n if upright else 0
    rows = (2 * n + 2 * m + k + ports, 6 * ports, 2 * n, n, n, n, n + c, lean)
    z, port, *others = (aligned((count, LANES)) for count in rows)
    return (z, port.reshape(6, ports, LANES), *others)


def _sparse(matrices: Sequence[Array]) -> Sparse:
    """Matrices of the same shape, one for each lane; zero is what is zero in all."""
    rows, columns = np.nonzero(np.any(matrices, axis=0))
    begins = np.searchsorted(rows, np.arange(len(matrices[0]) + 1))
    return begins, columns, side_by_side([matrix[rows, columns] for matrix in matrices])


def _alike(given: Sequence[Array]) -> Array:
    """Motions (T, k, LANES), or (T, k, 1) where they are the same for all."""
    if all(one is given[0] for one in given):
        return np.ascontiguousarray(given[0])[:, :, None]
    return side_by_side(given)
