"""A run's spectral matrix: what its lines look like on all channels, however its speed wandered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Run

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

SEGMENT_S = 5.0
"""A line is looked for in segments so long: a speed held by hand wanders little within one."""
PADDING = 4  # points of the grid per resolved frequency
QUARTERS = 4


@dataclass(frozen=True, eq=False)
class Spectra:
    """Of one run.

    ``frequency_hz`` (f,), equidistant from ``frequency_hz[0]``; ``lines`` (f, c, c) is, at a line,
    the product of the amplitudes of any two channels, one conjugate, averaged over segments, each
    per its channel's noise scale: in m/s² of accelerations; ``power`` (c,) the mean square in band,
    m²/s⁴; white noise seems as large as a line that holds ``bandwidth_hz`` of it.
    """

    run: Run
    frequency_hz: Array
    lines: ComplexArray
    power: Array
    bandwidth_hz: float

    @property
    def step_hz(self) -> float:
        """Between points of the grid."""
        return float(self.frequency_hz[1] - self.frequency_hz[0])

    @property
    def blocks(self) -> float:
        """Independent pieces of the run: half a second each, as where effects are judged."""
        return 2.0 * float(self.run.time_s[-1] - self.run.time_s[0])

    @property
    def resolved(self) -> float:
        """Independent amplitudes in band: bandwidth times duration."""
        seconds = float(self.run.time_s[-1] - self.run.time_s[0])
        return seconds * float(self.frequency_hz[-1] - self.frequency_hz[0])

    def spread(self, columns: Sequence[int]) -> float:
        """Share of the band that the power of some channels fills: 1 for white noise."""
        power = np.einsum("fcc->fc", self.lines).real[:, list(columns)]
        filled = power.sum(axis=0) ** 2 / np.maximum((power**2).sum(axis=0), 1e-300)
        return float(np.min(filled)) / len(power)

    def amplitudes(self, columns: Sequence[int]) -> float:
        """Independent ones of some channels in a quarter of the band, at the least."""
        band_hz = float(self.frequency_hz[-1] - self.frequency_hz[0])
        return len(columns) * band_hz / (QUARTERS * self.bandwidth_hz)

    def quietest(self, columns: Sequence[int] | None = None) -> float:
        """Mean square in band, m²/s⁴, that white noise has if the quietest quarter of the band,
        taken over all channels, or some, is nothing else; what lines hold is left aside."""
        power = np.einsum("fcc->fc", self.lines).real
        power = power if columns is None else power[:, list(columns)]
        quarters = np.array_split(power, QUARTERS)
        # The median of an exponentially distributed periodogram is ln 2 times its mean.
        level = min(float(np.mean(np.median(q, axis=0))) for q in quarters) / np.log(2.0)
        band_hz = float(self.frequency_hz[-1] - self.frequency_hz[0])
        return float(level * band_hz / (2.0 * self.bandwidth_hz))


def spectra_of(
    run: Run, rate_hz: float, band_hz: tuple[float, float], noise_scale: Array
) -> Spectra:
    """The spectral matrix of a run in band, by Welch's method with a Hann window, every channel
    per its noise scale (c,)."""
    n = len(run.record)
    length = min(n, round(SEGMENT_S * rate_hz))
    starts = np.linspace(0, n - length, 1 + 2 * (n - length) // max(length, 1)).astype(int)
    window = np.hanning(length + 1)[:length]
    centred = (run.record - run.record.mean(axis=0)) / noise_scale
    padded = PADDING * length
    frequency = np.arange(padded // 2 + 1) * rate_hz / padded
    band = (frequency >= band_hz[0]) & (frequency <= band_hz[1])
    sections = np.stack([centred[s : s + length] for s in starts])
    sections = (sections - sections.mean(axis=1, keepdims=True)) * window[:, None]
    amplitude = np.fft.rfft(sections, padded, axis=1)[:, band] * (2.0 / window.sum())
    lines = np.einsum("sfc,sfd->fcd", amplitude, amplitude.conj()) / len(starts)
    whole = np.abs(np.fft.rfft(centred, axis=0)) ** 2 * (2.0 / n**2)
    grid = np.arange(len(whole)) * rate_hz / n
    inside = (grid >= band_hz[0]) & (grid <= band_hz[1])
    bandwidth = rate_hz * float(np.sum(window**2) / np.sum(window) ** 2)
    return Spectra(run, frequency[band], lines, whole[inside].sum(axis=0), bandwidth)
