"""The force at one place along a motion that is given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numba
import numpy as np
from numpy.typing import NDArray

from wheelhop.effects import Effect
from wheelhop.effects.base import Values
from wheelhop.law.moved import Moved
from wheelhop.law.places import Where
from wheelhop.simulate import Model
from wheelhop.simulate.laws import padded
from wheelhop.vehicle import Assembly, Law
from wheelhop.vehicle.assembly import Row

Array = NDArray[np.float64]


@dataclass
class _Laws(Assembly):
    """Keeps the force laws that effects add."""

    found: list[tuple[Row, Law, tuple[float, ...], str]] = field(default_factory=list)

    def add_law(
        self,
        row: Row,
        law: Law,
        parameters: tuple[float, ...],
        by: str = "",
        begins: str = "",
    ) -> None:
        """Keep the law; along a motion that is given every memory begins at 0."""
        self.found.append((row, law, parameters, by))


def laws_of(
    effect: Effect, theta: Values, values: Values
) -> list[tuple[Row, Law, tuple[float, ...], str]]:
    """The force laws an effect adds to a vehicle: along which extension each acts, its numbers, and
    the input it is times, "" for none."""
    laws = _Laws(prescribed=(), body=())
    effect.modify(theta, values, laws)
    return laws.found


def force_along(model: Model, where: Where, moved: Moved, step_s: float) -> Array:
    """Force (T,), N, of everything between the ends of the place's first part, spring, damper and
    laws, along a motion sampled every `step_s`."""
    values = model.values
    first = where.rows(values)[0]
    stiffness, damping = where.linear(values)
    acting = [
        (law, parameters, by)
        for effect in model.effects
        if effect.place in ("suspension", "tyre")
        for row, law, parameters, by in laws_of(effect, model.theta(effect), values)
        if row == first
    ]
    linear = stiffness * moved.extension + damping * moved.rate
    return np.asarray(linear + _each_along(acting, moved, step_s).sum(axis=1))


def along(law: Law, numbers: Sequence[float], moved: Moved, step_s: float, by: str = "") -> Array:
    """Force (T,) of one law with these numbers along a motion, times an input if one is named."""
    return _each_along([(law, numbers, by)], moved, step_s)[:, 0]


def _each_along(
    acting: Sequence[tuple[Law, Sequence[float], str]], moved: Moved, step_s: float
) -> Array:
    """Forces (T, j) of laws with their numbers, each times its input. All go in one call: a law
    takes less time than the call."""
    if not acting:
        return np.zeros((len(moved.extension), 0))
    laws = [(0, law, numbers) for law, numbers, _ in acting]
    x, v = moved.extension[:, None], moved.rate[:, None]
    own = follow_all(laws, x, v, step_s, moved.before_s, moved.stretches)
    for j, (_, _, by) in enumerate(acting):
        if by:
            own[:, j] *= moved.inputs[by]
    return own


LawAt = tuple[int, Law, Sequence[float]]
"""The number of a port, a law that acts there, and its numbers."""


def follow_all(
    laws: Sequence[LawAt],
    x: Array,
    v: Array,
    dt: float,
    before_s: float = 0.0,
    stretches: Sequence[int] = (),
) -> Array:
    """Forces (T, j) of laws, each along the motion (T, p) of the port of its number; of several
    motions one after the other if the samples of each are given."""
    kinds = tuple(dict.fromkeys(law for _, law, _ in laws))
    which = np.array([(kinds.index(law), port) for port, law, _ in laws], dtype=np.int64)
    numbers = np.zeros((len(laws), max(len(p) for *_, p in laws) or 1))
    for row, (*_, p) in zip(numbers, laws, strict=True):
        row[: len(p)] = p
    ways = np.ascontiguousarray(x.T), np.ascontiguousarray(v.T)
    ends = np.cumsum(stretches or (len(x),), dtype=np.int64)
    return np.asarray(_follow(padded(kinds), which, *ways, ends, dt, numbers, before_s)).T


@numba.njit(cache=True, nogil=True, error_model="numpy")
def _follow(laws, which, x, v, ends, dt, numbers, before_s):  # type: ignore[no-untyped-def]
    total = np.zeros((len(which), x.shape[1]))
    for j in range(len(which)):
        k, i = which[j]
        law, x_j, v_j, p, f = laws[k], x[i], v[i], numbers[j], total[j]
        first = 0
        for end in ends:
            still = x_j[first]
            _, memory = law(still, 0.0, 0.0, before_s, 0.0, p)
            for t in range(first, end):
                f[t], memory = law(x_j[t], v_j[t], x_j[t] - still, dt * (t > first), memory, p)
                still = x_j[t]
            first = end
    return total
