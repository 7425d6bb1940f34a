"""Third-octave bands, IEC 61260-1:2014, base ten: centre 10^(x/10) Hz, edges 10^(±1/20) away."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NOMINAL = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)  # times powers of ten


@dataclass(frozen=True)
class ThirdOctave:
    """The band number ``x``; ``name`` is its nominal centre frequency in hertz."""

    x: int

    @property
    def name(self) -> str:
        """Nominal centre frequency, as engineers write it: "0.63", "8", "12.5"."""
        return f"{NOMINAL[self.x % 10] * 10.0 ** (self.x // 10):g}"

    @property
    def edges_hz(self) -> tuple[float, float]:
        """Lower and upper edge, 10^((x ± 1/2) / 10)."""
        return 10.0 ** ((self.x - 0.5) / 10.0), 10.0 ** ((self.x + 0.5) / 10.0)


def third_octave_of(frequency_hz: NDArray[np.float64]) -> NDArray[np.int_]:
    """Number x of the band that holds each (positive) frequency; an upper edge belongs above."""
    return np.floor(10.0 * np.log10(frequency_hz) + 0.5).astype(int)


def third_octaves(band_hz: tuple[float, float]) -> tuple[ThirdOctave, ...]:
    """The bands that hold any frequency of ``band_hz``, in order."""
    low, high = third_octave_of(np.asarray(band_hz))
    return tuple(ThirdOctave(int(x)) for x in range(low, high + 1))
