"""The force at one place along a motion that is given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numba
import numpy as np
from numpy.typing import NDArray

from wheelhop.law.places import Moved, Where
from wheelhop.simulate import Model
from wheelhop.vehicle import Assembly, Law
from wheelhop.vehicle.assembly import Row

Array = NDArray[np.float64]


@dataclass
class _LawsAt(Assembly):
    """Keeps the force laws that effects add along one extension."""

    row: Row = ()
    found: list[tuple[Law, tuple[float, ...], str]] = field(default_factory=list)

    def add_law(self, row: Row, law: Law, parameters: tuple[float, ...], by: str = "") -> None:
        """Keep the law if it acts there."""
        if row == self.row:
            self.found.append((law, parameters, by))


def force_along(model: Model, where: Where, moved: Moved, step_s: float) -> Array:
    """Force (T,), N, of everything between the ends of the place's first part, spring, damper and
    laws, along a motion sampled every `step_s`."""
    values = model.values
    at = _LawsAt(prescribed=(), body=(), row=where.rows(values)[0])
    for effect in model.effects:
        if effect.place in ("suspension", "tyre"):
            effect.modify(model.theta(effect), values, at)
    stiffness, damping = where.linear(values)
    total = stiffness * moved.extension + damping * moved.rate
    for law, parameters, by in at.found:
        total += along(law, parameters, moved, step_s, by)
    return total


def along(law: Law, numbers: Sequence[float], moved: Moved, step_s: float, by: str = "") -> Array:
    """Force (T,) of one law with these numbers along a motion, times an input if one is named."""
    ends = np.cumsum(moved.stretches)[:-1]
    ways = zip(np.split(moved.extension, ends), np.split(moved.rate, ends), strict=True)
    p = np.array(numbers, dtype=float)
    own = np.concatenate([follow(law, x, v, step_s, p) for x, v in ways])
    return np.asarray(own * moved.inputs[by] if by else own)


@numba.njit(nogil=True, error_model="numpy")
def follow(law, x, v, dt, numbers):  # type: ignore[no-untyped-def]
    """Force (T,) of one law along a motion."""
    total, memory, before = np.zeros(len(x)), 0.0, x[0]
    for t in range(len(x)):
        total[t], memory = law(x[t], v[t], x[t] - before, dt * min(t, 1), memory, numbers)
        before = x[t]
    return total
