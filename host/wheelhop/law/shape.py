"""How a law that was found looks along the motion recorded."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wheelhop.law.along import force_along
from wheelhop.law.moved import Moved
from wheelhop.law.rival import Rival
from wheelhop.law.search import Found
from wheelhop.simulate import Model
from wheelhop.vehicle import is_component

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


def _along(found: Found, model: Model, moved: Moved | None) -> Array:
    moved = found.moved if moved is None else moved
    assert moved is not None and found.where is not None
    return force_along(model, found.where, moved, 1.0 / found.workshop.campaign.sample_rate_hz)
