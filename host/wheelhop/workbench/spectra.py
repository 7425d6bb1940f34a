"""Spectra of records by Welch's method, and what one of them says of another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Spectra:
    """Densities (f,) of two signals by frequency, Hz: of power, unit²/Hz, and across; from so many
    `segments`."""

    frequency_hz: Array
    input: Array
    output: Array
    across: NDArray[np.complex128]
    segments: int

    @property
    def by_chance(self) -> float:
        """The coherence that signals which have nothing to do with each other stay below in 95 %
        (J. S. Bendat, A. G. Piersol, Random Data, 2010, section 9.2), 1 of a single segment."""
        return float(1.0 - 0.05 ** (1.0 / (self.segments - 1))) if self.segments > 1 else 1.0

    @property
    def gain(self) -> Array:
        """Size of output over input, of what is coherent with it: the estimate H1."""
        found: Array = np.full(len(self.input), np.nan)
        np.divide(np.abs(self.across), self.input, where=self.input > 0, out=found)
        return found

    @property
    def coherence(self) -> Array:
        """Share of the output's power that goes with the input, 0 to 1."""
        power = self.input * self.output
        found: Array = np.full(len(power), np.nan)
        np.divide(np.abs(self.across) ** 2, power, where=power > 0, out=found)
        return found


def power_density(records: Sequence[Array], rate_hz: float) -> tuple[Array, Array]:
    """Frequencies, Hz, and power density, unit²/Hz, of records (n,)."""
    found = spectra(records, records, rate_hz)
    return found.frequency_hz, found.input


def spectra(
    inputs: Sequence[Array], outputs: Sequence[Array], rate_hz: float, most: int | None = None
) -> Spectra:
    """Of records (n,) of two signals.

    Half-overlapping Hann windows, three of them in the shortest record, or shorter ones of `most`
    samples; none goes across the end of a record. Each record counts by its length.
    """
    length = max(8, min([len(record) // 2 for record in inputs] + [most or len(inputs[0])]))
    window = np.hanning(length)

    def transformed(record: Array) -> NDArray[np.complex128]:
        starts = range(0, len(record) - length + 1, max(1, length // 2))
        pieces = np.array([record[i : i + length] for i in starts])
        return np.asarray(np.fft.rfft(pieces * window)[:, 1:])

    pairs = [(transformed(x), transformed(y)) for x, y in zip(inputs, outputs, strict=True)]
    weights, scale = [len(record) for record in inputs], rate_hz * float((window**2).sum()) / 2

    def mean(powers: Sequence[NDArray[np.complex128]]) -> NDArray[np.complex128]:
        means = [power.mean(axis=0) for power in powers]
        return np.asarray(np.average(means, axis=0, weights=weights) / scale)

    return Spectra(
        np.fft.rfftfreq(length, 1 / rate_hz).astype(np.float64)[1:],
        mean([x.conj() * x for x, _ in pairs]).real,
        mean([y.conj() * y for _, y in pairs]).real,
        mean([x.conj() * y for x, y in pairs]),
        sum(len(x) for x, _ in pairs),
    )
