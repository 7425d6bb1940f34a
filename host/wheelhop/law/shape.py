"""How a law that was found looks along the motion recorded."""

from __future__ import annotations

from dataclasses import dataclass, field

import numba
import numpy as np
from numpy.typing import NDArray

from wheelhop.law.places import Moved, Where
from wheelhop.law.search import Found, Rival
from wheelhop.simulate import Model
from wheelhop.vehicle import Assembly, Law, is_component
from wheelhop.vehicle.assembly import Row

Array = NDArray[np.float64]


def forces(found: Found, rival: Rival, moved: Moved | None = None) -> Array:
    """Force (T,), N, of a law along the motion of the place, or another one: on a rig all of the
    component's but its inertia; on a vehicle beyond the spring and damper of the model without it,
    and what they changed with it counts as part of it."""
    whole = _along(found, rival.rung.model, moved)
    on_rig = is_component(rival.rung.model.values)
    return whole if on_rig else whole - _along(found, found.base.model, moved)


def spread(found: Found, rival: Rival, moved: Moved | None = None) -> Array:
    """Standard deviation (T,), N, of that force, from the covariance of all shared numbers; they
    are as uncertain as the residual that is left says."""
    fit = rival.rung.fit
    names = [free.name for free in fit.shared]
    base = _along(found, fit.model, moved)
    columns = []
    for name, free in zip(names, fit.shared, strict=True):
        step = 1e-3 * free.scale
        changed = fit.model.with_values({name: fit.model.values[name] + step})
        columns.append((_along(found, changed, moved) - base) / step)
    matrix = np.stack(columns, axis=1)
    grown = max(fit.rss / (fit.size * fit.sigma**2), 1.0)
    variance = np.einsum("ti,ij,tj->t", matrix, fit.covariance * grown, matrix)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))


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
    begin = 0
    for length in moved.stretches:
        part = slice(begin, begin + length)
        for law, parameters, by in at.found:
            numbers = np.array(parameters)
            own = follow(law, moved.extension[part], moved.rate[part], step_s, numbers)
            total[part] += own * moved.inputs[by][part] if by else own
        begin += length
    return total


def _along(found: Found, model: Model, moved: Moved | None) -> Array:
    moved = found.moved if moved is None else moved
    assert moved is not None and found.where is not None
    return force_along(model, found.where, moved, 1.0 / found.workshop.campaign.sample_rate_hz)


@numba.njit(nogil=True, error_model="numpy")
def follow(law, x, v, dt, numbers):  # type: ignore[no-untyped-def]
    """Force (T,) of one law along a motion."""
    total, memory, before = np.zeros(len(x)), 0.0, x[0]
    for t in range(len(x)):
        total[t], memory = law(x[t], v[t], x[t] - before, dt * min(t, 1), memory, numbers)
        before = x[t]
    return total
