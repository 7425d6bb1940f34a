"""The error of the logger's clock, from when its scans arrive."""

from dataclasses import dataclass
from math import inf, sqrt

import numpy as np

TRIGGER_S = 156.25e-6  # by which a late trigger shifts all that follows
BIN_S = 1.0
LEAST_BINS = 10
MOST_BINS = 4096
LARGEST_PPM = 20_000
SOUND_PPM = 10.0  # standard deviation


@dataclass(frozen=True)
class ClockError:
    """`ppm` and its standard deviation; positive: the logger's seconds are too long."""

    ppm: float
    deviation_ppm: float

    @property
    def is_sound(self) -> bool:
        """Whether it is good enough to be stored in the logger."""
        return abs(self.ppm) <= LARGEST_PPM and self.deviation_ppm < SOUND_PPM


class ClockEstimate:
    """Compares scan numbers with the host's clock.

    A scan arrives at  t = c + (1 + ε)·(i / rate + late · 156.25 µs) + delay,  with a delay that is
    never less than the line's own: the earliest arrival of each second lies on a straight line,
    whose slope 1 + ε is fitted by least squares. The host's clock is taken as right.
    """

    def __init__(self, rate_hz: float) -> None:
        self._rate_hz = rate_hz
        self._bins: dict[int, tuple[float, float]] = {}  # logger's seconds, and what is beyond

    def add(self, number: int, at_s: float, late: int = 0) -> None:
        """Take a scan's number and when it came."""
        logger_s = number / self._rate_hz + late * TRIGGER_S
        ahead_s = at_s - logger_s
        place = int(logger_s / BIN_S)
        best = self._bins.get(place)
        if best is None or ahead_s < best[1]:
            self._bins[place] = (logger_s, ahead_s)
        if len(self._bins) > MOST_BINS:  # hours: every other second will do
            for old in list(self._bins)[::2]:
                del self._bins[old]

    def result(self) -> ClockError | None:
        """The error so far; None before there is enough to say one."""
        if len(self._bins) < LEAST_BINS:
            return None
        time_s, ahead_s = np.array(list(self._bins.values())[:-1]).T  # the last is not full yet
        design = time_s - time_s.mean()
        slope = float(design @ ahead_s / (design @ design))
        residual = ahead_s - ahead_s.mean() - slope * design
        freedom = len(design) - 2
        variance = float(residual @ residual) / freedom / float(design @ design)
        deviation = sqrt(variance) if freedom > 0 else inf
        return ClockError(1e6 * slope, 1e6 * deviation)
