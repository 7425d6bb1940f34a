"""What is believed of numbers before a fit: a normal density, each number per `Free.scale`.

What is believed in proportion is normal in its logarithm: twice as much is as likely as half.
Records do not show the common scale of masses and forces, only the beliefs of all of them do. Were
these normal in kilograms, each to 10 % of what is stated, those stated too low would count for
more, and all masses would come out 2 % low.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.fit.parameters import Free

Array = NDArray[np.float64]

BROAD = 2.0
"""Of what next to nothing is believed, so many of its scales are one standard deviation."""


@dataclass(frozen=True, eq=False)
class Belief:
    """Numbers with their mean (p,), and the precision (p, p) at the mean, per `Free.scale`;
    ``log_precision``, logarithm of its determinant."""

    free: tuple[Free, ...]
    mean: Array
    precision: Array
    log_precision: float

    @classmethod
    def of(cls, free: Sequence[Free]) -> Belief:
        """Each number by itself, as `Free` says; none is less certain than `BROAD`."""
        mean = np.array([f.mean / f.scale for f in free])
        weight = np.array([(f.scale / f.sigma) ** 2 for f in free])
        return cls(
            tuple(free), mean, np.diag(weight), float(np.log(np.maximum(weight, BROAD**-2)).sum())
        )

    @classmethod
    def after(cls, free: Sequence[Free], values: Mapping[str, float], precision: Array) -> Belief:
        """What a fit that came to these values has left of the numbers' uncertainty."""
        mean = np.array([values[f.name] / f.scale for f in free])
        return cls(tuple(free), mean, precision, float(np.linalg.slogdet(precision)[1]))

    def pull(self, values: Mapping[str, float]) -> Array:
        """The force (p,) towards the mean, half the negative gradient of `distance`."""
        return np.asarray(-self._slope(values) * (self.precision @ self._away(values)))

    def precision_at(self, values: Mapping[str, float]) -> Array:
        """How steeply (p, p) that force grows, to first order."""
        slope = self._slope(values)
        return np.asarray(self.precision * np.outer(slope, slope))

    def log_precision_at(self, values: Mapping[str, float]) -> float:
        """Logarithm of the determinant of the precision there."""
        return self.log_precision + 2.0 * float(np.log(self._slope(values)).sum())

    def room(self, values: Mapping[str, float]) -> Array:
        """How far each number may go down and up (2, p), from where it is."""
        scale = np.array([f.scale for f in self.free])
        bounds = np.array([[f.lower for f in self.free], [f.upper for f in self.free]])
        return np.asarray(bounds / scale - self._now(values))

    def distance(self, values: Mapping[str, float]) -> float:
        """Square of Mahalanobis' distance from the mean."""
        away = self._away(values)
        return float(away @ self.precision @ away)

    def _away(self, values: Mapping[str, float]) -> Array:
        """How far (p,) from the mean; in proportion, the logarithm of that times the mean."""
        now = self._now(values)
        return np.where(
            self._in_proportion, -self.mean * np.log(self._slope(values)), now - self.mean
        )

    def _slope(self, values: Mapping[str, float]) -> Array:
        """How that grows (p,) with each number."""
        now = self._now(values)
        return np.divide(self.mean, now, out=np.ones(len(now)), where=self._in_proportion)

    def _now(self, values: Mapping[str, float]) -> Array:
        return np.array([values.get(f.name, f.mean) / f.scale for f in self.free])

    @property
    def _in_proportion(self) -> NDArray[np.bool_]:
        return np.array([f.in_proportion for f in self.free], bool)
