"""What a sample is the mean of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Averaging:
    """A sample is the mean of `count` values a `step_s` apart, each the mean over `window_s` (0:
    the value itself); all are symmetric about the sample's instant."""

    window_s: float
    count: int = 1
    step_s: float = 0.0

    @property
    def reach_s(self) -> float:
        """How far from its instant a sample still feels what happens."""
        return 0.5 * (self.window_s + (self.count - 1) * self.step_s)

    @property
    def centres_s(self) -> Array:
        """The instants (count,) of the values about the sample's own."""
        places = np.arange(self.count, dtype=np.float64)
        return np.asarray(self.step_s * (places - 0.5 * (self.count - 1)))

    def kept(self, frequency_hz: Array) -> Array:
        """Share of a sine's amplitude (f,) that is left of it; negative: turned over."""
        own: Array = np.sinc(frequency_hz * self.window_s)
        together: Array = np.cos(2 * np.pi * np.outer(frequency_hz, self.centres_s)).mean(axis=1)
        return own * together
