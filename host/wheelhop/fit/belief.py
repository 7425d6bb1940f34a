"""What is believed of numbers before a fit: a normal density, each number per `Free.scale`.

What is believed in proportion is normal in its logarithm: twice as much is as likely as half.
Records do not show the common scale of masses and forces, only the beliefs of all of them do. Were
these normal in kilograms, each to 10 % of what is stated, those stated too low would count for
more, and all masses would come out 2 % low.

Nothing else may touch that scale (docs/theory.md, section 6). So an effect's stiffness, and what
else `Free.follows_scale`, is believed and bounded as a multiple of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from wheelhop.fit.parameters import Free, after, of_forces, scale_is_given
from wheelhop.vehicle.measured import Measured

Array = NDArray[np.float64]
Values = Mapping[str, float]

BROAD = 2.0
"""Of what next to nothing is believed, so many of its scales are one standard deviation."""

SLOPE_STEP = 1e-4
"""Of a number's scale: over so much on both sides the slope of a relation is a difference."""


@dataclass(frozen=True, eq=False)
class Belief:
    """Numbers (p,) with their mean (p,), per `Free.scale`, and the precision of (p + q,): of the
    numbers about their mean, `absolute` or as multiples of the common scale where they follow it,
    and of q measured relations. ``floored``: the same, none less certain than `BROAD`."""

    free: tuple[Free, ...]
    mean: Array
    precision: Array
    floored: Array
    measured: tuple[Measured, ...] = ()
    absolute: bool = False

    @classmethod
    def of(cls, free: Sequence[Free], measured: Sequence[Measured] = ()) -> Belief:
        """Each number by itself, as `Free` says, none less certain than `BROAD`; and what was
        `measured` of several, if any of them is free."""
        measured = measured if free else ()
        mean = np.array([f.mean / f.scale for f in free])
        alone = np.array([(f.scale / f.sigma) ** 2 for f in free])
        related = np.array([m.relative**-2 for m in measured])
        weight = np.concatenate([alone, related])
        floor = np.concatenate([np.maximum(alone, BROAD**-2), related])
        return cls(tuple(free), mean, np.diag(weight), np.diag(floor), tuple(measured))

    @classmethod
    def after(cls, free: Sequence[Free], values: Values, precision: Array) -> Belief:
        """What a fit that came to these values has left of the numbers' uncertainty."""
        mean = np.array([values[f.name] / f.scale for f in free])
        return cls(tuple(free), mean, precision, precision, absolute=True)

    def pull(self, values: Values) -> Array:
        """The force (p,) towards the mean, half the negative gradient of `distance`."""
        return np.asarray(-self._slope(values).T @ (self.precision @ self._away(values)))

    def precision_at(self, values: Values) -> Array:
        """How steeply (p, p) that force grows, to first order."""
        slope = self._slope(values)
        return np.asarray(slope.T @ self.precision @ slope)

    def log_precision_at(self, values: Values) -> float:
        """Logarithm of the determinant of the precision there, of `floored` beliefs."""
        slope = self._slope(values)
        return float(np.linalg.slogdet(slope.T @ self.floored @ slope)[1])

    @property
    def log_precision(self) -> float:
        """Logarithm of the determinant of the numbers' own precision, without relations, at the
        mean."""
        p = len(self.free)
        return float(np.linalg.slogdet(self.floored[:p, :p])[1])

    def deviations_at(self, values: Values) -> Array:
        """Standard deviation (p,) of each number were it believed to lie there, per `Free.scale`;
        infinite where nothing is believed."""
        precision = self.precision_at(values)
        told = np.diag(precision) > 0.0
        found = np.full(len(told), np.inf)
        unit = np.sqrt(np.diag(precision)[told])
        inverse = np.linalg.inv(precision[np.ix_(told, told)] / np.outer(unit, unit))
        found[told] = np.sqrt(np.diag(inverse)) / unit
        return found

    def distance(self, values: Values) -> float:
        """Square of Mahalanobis' distance from the mean."""
        away = self._away(values)
        return float(away @ self.precision @ away)

    def slopes_of_measured(self, values: Values) -> Array:
        """How the logarithms of the measured relations grow (q, p) with each number."""
        found = np.zeros((len(self.measured), len(self.free)))
        for i, f in enumerate(self.free if self.measured else ()):
            value, step = values[f.name], SLOPE_STEP * f.scale
            up, down = ({**values, f.name: value + d} for d in (step, -step))
            grown = [np.log(m.of(up) / m.of(down)) for m in self.measured]
            found[:, i] = np.array(grown) / (2.0 * SLOPE_STEP)
        return found

    def scale(self, values: Values) -> float:
        """Common scale of masses and forces: the weighted mean of how many times each number that
        is believed in proportion is what is stated; 1 where there is none."""
        told = self._shares > 0.0
        ratios = self._now(values)[told] / self.mean[told]
        return float(np.exp(self._shares[told] @ np.log(ratios)))

    def coordinates(self, values: Values) -> Array:
        """How the numbers change (p, p) per change of those in which bounds stand still: the
        numbers, or as multiples of the common scale where they follow it."""
        found, now = np.eye(len(self.free)), self._now(values)
        if self._following.any():
            rows = np.outer(now, self._scale_slope(now)) + self.scale(values) * found
            found[self._following] = rows[self._following]
        return found

    def room(self, values: Values) -> Array:
        """How far each number may go down and up (2, p) in these `coordinates`."""
        scale = np.array([f.scale for f in self.free])
        bounds = np.array([[f.lower for f in self.free], [f.upper for f in self.free]])
        return np.asarray(bounds / scale - self._relative(values, self._following))

    def moved(self, values: Values, step: Array) -> dict[str, float]:
        """Numbers after a step (p,) in these coordinates, within their bounds."""
        before = self.scale(values)
        relative = {f.name: values[f.name] / before for f in self.free if f.follows_scale}
        found = after(self.free, {**values, **relative}, step)
        now = self.scale({**values, **found})
        return found | {name: found[name] * now for name in relative}

    def on_scale(self, values: Values) -> dict[str, float]:
        """Masses and forces times the one factor at which they are likeliest: no record tells it.
        None where one of them is certain."""
        if self.absolute or not self._shares.any() or scale_is_given(self.free, values):
            return {}
        power = np.array([of_forces(f.name) for f in self.free])
        along = power * self._now(values)
        more = along @ self.pull(values) / (along @ self.precision_at(values) @ along)
        factors = np.exp(more * power).tolist()
        return {f.name: values[f.name] * k for f, k in zip(self.free, factors, strict=True)}

    def _away(self, values: Values) -> Array:
        """How far (p + q,) from the mean: in proportion, the logarithm of that times the mean."""
        now = self._now(values)
        away = self._relative(values, self._multiples) - self.mean
        which = self._in_proportion
        away[which] = self.mean[which] * np.log(now[which] / self.mean[which])
        related = [np.log(m.of(values) / m.value) for m in self.measured]
        return np.concatenate([away, related])

    def _slope(self, values: Values) -> Array:
        """How that grows (p + q, p) with each number."""
        now = self._now(values)
        slope = np.eye(len(now))
        if self._multiples.any():
            rows = (slope - np.outer(now, self._scale_slope(now))) / self.scale(values)
            slope[self._multiples] = rows[self._multiples]
        which = self._in_proportion
        slope[which, which] = self.mean[which] / now[which]
        return np.vstack([slope, self.slopes_of_measured(values)])

    def _now(self, values: Values) -> Array:
        return np.array([values.get(f.name, f.mean) / f.scale for f in self.free])

    def _relative(self, values: Values, which: NDArray[np.bool_]) -> Array:
        """The numbers (p,), some as multiples of the common scale."""
        now = self._now(values)
        return np.where(which, now / self.scale(values), now) if which.any() else now

    def _scale_slope(self, now: Array) -> Array:
        """How the logarithm of the common scale grows (p,) with each number."""
        return np.divide(self._shares, now, out=np.zeros(len(now)), where=self._shares > 0.0)

    @cached_property
    def _shares(self) -> Array:
        """What each number has to say (p,) of the common scale; the sum is 1, or 0."""
        weight = np.array([f.in_proportion and of_forces(f.name) > 0 for f in self.free], float)
        weight *= [(f.mean / f.sigma) ** 2 for f in self.free]
        return np.asarray(weight / max(weight.sum(), np.finfo(float).tiny))

    @cached_property
    def _following(self) -> NDArray[np.bool_]:
        return np.array([f.follows_scale for f in self.free], bool)

    @property
    def _multiples(self) -> NDArray[np.bool_]:
        """Which numbers are believed as multiples of the common scale."""
        return self._following & (not self.absolute)

    @cached_property
    def _in_proportion(self) -> NDArray[np.bool_]:
        return np.array([f.in_proportion for f in self.free], bool)
