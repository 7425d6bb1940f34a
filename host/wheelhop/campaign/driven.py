"""The speed that a channel recorded: how a run was really driven."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Driven:
    """Speeds (n,), m/s, at times (n,), s, as a `channel` shows them; before and after them it was
    driven as if time ran backwards from the record's ends.

    `uncertainty` is that of the speed's scale, relative, and `noise_rms` its noise, m/s, both 0
    where they are not stated; `stated_m_s` is the run's speed as campaign.toml says it.
    """

    channel: str
    time_s: Array
    speed_m_s: Array
    stated_m_s: float
    uncertainty: float = 0.0
    noise_rms: float = 0.0

    @property
    def mean_m_s(self) -> float:
        """Way over time."""
        return float(self._way_m[-1]) / self._length_s

    def faster(self, time_s: ArrayLike) -> Array:
        """Speed over its mean."""
        inside, _ = self._mirrored(time_s)
        return np.interp(inside, self.time_s, self.speed_m_s) / self.mean_m_s

    def gone(self, time_s: ArrayLike) -> Array:
        """Way from time 0 on, over the mean speed, s."""
        return self._since_first(time_s) - self._since_first(0.0)

    def _since_first(self, time_s: ArrayLike) -> Array:
        inside, there_and_back = self._mirrored(time_s)
        way_s = np.interp(inside, self.time_s, self._way_m) / self.mean_m_s
        turned = there_and_back % 2 == 1
        before = (there_and_back + turned) * self._length_s
        return np.asarray(before + np.where(turned, -way_s, way_s))

    def _mirrored(self, time_s: ArrayLike) -> tuple[Array, Array]:
        """Times within the record, and how many times its length was driven before."""
        lengths, rest = np.divmod(np.asarray(time_s) - self.time_s[0], self._length_s)
        inside = np.where(lengths % 2 == 1, self._length_s - rest, rest)
        return self.time_s[0] + inside, lengths

    @property
    def _length_s(self) -> float:
        return float(self.time_s[-1] - self.time_s[0])

    @cached_property
    def _way_m(self) -> Array:
        """From the first sample to each."""
        steps = np.diff(self.time_s) * (self.speed_m_s[1:] + self.speed_m_s[:-1]) / 2
        return np.concatenate([[0.0], np.cumsum(steps)])
