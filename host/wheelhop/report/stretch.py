"""Which part of a record is shown: where most is left of it, long enough to see its shape."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WINDOW_S, WAVES = 2.5, 25
"""So much of a run is shown against time, and of what moves fast so many waves of the frequency
about which its power lies: enough to see their shape."""

CYCLES = 12
"""So many waves of the frequency about which the motion's power lies are drawn as loops, those
about the farthest point: more would be a blob."""


def worst_stretch(measured: Array, residual: Array, rate_hz: float) -> slice:
    """The samples that hold most of a residual (n,), of a signal (n,)."""
    seconds = min(WINDOW_S, seconds_of(measured, rate_hz, WAVES))
    length = max(min(round(seconds * rate_hz), len(residual)), 1)
    summed = np.concatenate([[0.0], np.cumsum(residual**2)])
    held = summed[length:] - summed[:-length]
    start = int(np.argmax(held))
    return slice(start, start + length)


def farthest(x: Array, rate_hz: float) -> slice:
    """CYCLES waves about the farthest point, or all of a short record."""
    length = min(round(seconds_of(x, rate_hz, CYCLES) * rate_hz), len(x))
    middle = int(np.argmax(np.abs(x - np.median(x))))
    begin = min(max(middle - length // 2, 0), len(x) - length)
    return slice(begin, begin + length)


def seconds_of(signal: Array, rate_hz: float, waves: float) -> float:
    """How long so many waves take, of the frequency about which a signal's power lies."""
    power = np.abs(np.fft.rfft(signal - signal.mean())) ** 2
    frequency = np.fft.rfftfreq(len(signal), 1.0 / rate_hz)
    about_hz = float(power @ frequency / power.sum()) if power.any() else 0.0
    return waves / about_hz if about_hz > 0.0 else np.inf
