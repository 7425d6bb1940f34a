"""What a description of a run is, and how well it explains the run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wheelhop.gate.spectra import Spectra

MOST = 0.99
"""Share beyond which no nominal model explains: its numbers are uncertain by 10 %."""
TOLD = 0.3
"""Share from which the gain of a record over its prediction says something."""


@dataclass(frozen=True)
class Places:
    """Of which channels the campaign says something wrong, (m,): the recorded ones among `columns`
    hold the predicted ones of `order`, with which gain, and how much too late, s."""

    columns: tuple[int, ...] = ()
    order: tuple[int, ...] = ()
    gain: tuple[float, ...] = ()
    late_s: tuple[float, ...] = ()

    def of(self, column: int) -> tuple[int, float]:
        """The predicted column that a recorded one holds, and with which gain."""
        if column not in self.columns:
            return column, 1.0
        k = self.columns.index(column)
        return self.order[k], self.gain[k]

    def late(self, column: int) -> float:
        """How much too late a recorded column is, s."""
        return self.late_s[self.columns.index(column)] if column in self.columns else 0.0


@dataclass(frozen=True)
class Match:
    """How well a description explains a run: the share of its power, the gain of the record over
    the prediction (NaN: not told), the speed at which that is so, m/s, and the logarithm of the
    likelihood."""

    share: float
    gain: float
    speed_m_s: float
    log_likelihood: float

    @property
    def has_gain(self) -> bool:
        """Whether the gain means anything."""
        return bool(np.isfinite(self.gain) and self.share > TOLD)


def log_likelihood(spectra: Spectra, share: float) -> float:
    """Of a description that explains a share of the power, over one that explains nothing: normal
    residuals, half a second of which count as one number."""
    return -0.5 * spectra.blocks * float(np.log1p(-share))
