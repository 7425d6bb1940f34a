"""A speed that changes along the track: where the front axle is, and how fast it is there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
EVEN = 1e-12
"""Below this change, relative, the speed of a stretch is constant."""


@dataclass(frozen=True)
class Course:
    """Speeds (k,), m/s, above 0, at places (k,) of the front axle, m, increasing; linear between,
    constant before the first and after the last.

    A drive of the whole course takes the time T(x) = ∫ dx / v(x), counted from the first place.
    """

    x_m: tuple[float, ...]
    speed_m_s: tuple[float, ...]

    @staticmethod
    def of(pairs: Sequence[Sequence[float]]) -> Course:
        """From pairs of place, m, and speed, km/h. Raises ValueError, with a reason."""
        if len(pairs) < 2 or any(len(pair) != 2 for pair in pairs):
            raise ValueError("needs two or more pairs of place, m, and speed, km/h")
        x, kmph = (tuple(float(pair[i]) for pair in pairs) for i in (0, 1))
        if not np.isfinite([*x, *kmph]).all() or min(kmph) <= 0.0:
            raise ValueError("its speeds must be above 0 km/h")
        if not (np.diff(x) > 0.0).all():
            raise ValueError("its places must increase")
        return Course(x, tuple(v / 3.6 for v in kmph))

    @property
    def mean_m_s(self) -> float:
        """Length over time, from the first place to the last."""
        return float((self.x_m[-1] - self.x_m[0]) / self._knots_s[-1])

    def speed(self, x_m: ArrayLike) -> Array:
        """Speed at a place."""
        return np.interp(np.asarray(x_m, dtype=np.float64), self.x_m, self.speed_m_s)

    def time(self, x_m: ArrayLike) -> Array:
        """T(x), s; on a stretch whose speed rises by a per metre ln(v/v₀)/a."""
        x = np.asarray(x_m, dtype=np.float64)
        k = np.searchsorted(self.x_m, x, side="right")
        start, v, a, t = self._stretches[:, k]
        u = a * (x - start) / v
        safe = np.where(np.abs(u) < EVEN, 1.0, u)
        shape = np.where(np.abs(u) < EVEN, 1.0, np.log1p(safe) / safe)
        return np.asarray(t + (x - start) / v * shape)

    def place(self, time_s: ArrayLike) -> Array:
        """Where the front axle is at T, m: the inverse of `time`."""
        time = np.asarray(time_s, dtype=np.float64)
        k = np.searchsorted(self._knots_s, time, side="right")
        start, v, a, t = self._stretches[:, k]
        u = a * (time - t)
        safe = np.where(np.abs(u) < EVEN, 1.0, u)
        shape = np.where(np.abs(u) < EVEN, 1.0, np.expm1(safe) / safe)
        return np.asarray(start + v * (time - t) * shape)

    @cached_property
    def _knots_s(self) -> Array:
        """T at the places."""
        x, v = np.array(self.x_m), np.array(self.speed_m_s)
        u = np.diff(v) / v[:-1]
        safe = np.where(np.abs(u) < EVEN, 1.0, u)
        shape = np.where(np.abs(u) < EVEN, 1.0, np.log1p(safe) / safe)
        return np.concatenate([[0.0], np.cumsum(np.diff(x) / v[:-1] * shape)])

    @cached_property
    def _stretches(self) -> Array:
        """Of the stretch before the first place, those between, and after the last: where it is
        counted from, speed there, rise of speed, 1/s, and T there, (4, k + 1)."""
        x, v = np.array(self.x_m), np.array(self.speed_m_s)
        rise = np.concatenate([[0.0], np.diff(v) / np.diff(x), [0.0]])
        first = np.concatenate([[0], np.arange(len(x))])
        return np.stack([x[first], v[first], rise, self._knots_s[first]])
