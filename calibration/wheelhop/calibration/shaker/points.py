"""`Points`: what a session says of one channel's response, frequency by frequency."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


COMPLEX = ("ratio", "rounding")


@dataclass(frozen=True, eq=False)
class Points:
    """Arrays of shape (n,), one element a frequency.

    `frequency_hz` by the reference's clock, `time_s` by the logger's, `amplitude_m_s2` of the
    reference, `ratio` complex, channel over reference (codes, or its unit, per m/s²) at the clocks
    that were assumed, `random` the relative standard uncertainty of each of its magnitude and phase
    by repeatability and noise, `rounding` (n, draws) complex relative errors that quantisation may
    have made, `offset` and `noise` (rms) of the channel in its own unit, `coherence` squared,
    `distortion` of the table, relative.
    """

    frequency_hz: Array
    time_s: Array
    amplitude_m_s2: Array
    ratio: NDArray[np.complex128]
    random: Array
    rounding: NDArray[np.complex128]
    offset: Array
    noise: Array
    coherence: Array
    distortion: Array

    @classmethod
    def of(cls, rows: Sequence[Sequence[Any]]) -> "Points":
        """Make points from rows in the order of the fields."""
        columns = list(zip(*rows, strict=True)) or [()] * len(fields(cls))
        arrays = {
            field.name: np.array(column, dtype=complex if field.name in COMPLEX else float)
            for field, column in zip(fields(cls), columns, strict=True)
        }
        return cls(**arrays)

    def __len__(self) -> int:
        return len(self.frequency_hz)

    @property
    def uncertainty(self) -> Array:
        """Relative standard uncertainty of magnitude, and of phase in rad."""
        rounding = (np.abs(self.rounding) ** 2).mean(axis=1) / 2
        return np.asarray(np.sqrt(self.random**2 + rounding))

    def corrected(self, gain: NDArray[np.complex128] | Array) -> "Points":
        """The points with a known response taken out of the ratio."""
        return replace(self, ratio=self.ratio / gain)

    def where(self, chosen: NDArray[np.bool_]) -> "Points":
        """Some of the points."""
        return Points(**{field.name: getattr(self, field.name)[chosen] for field in fields(self)})
