"""A series cut where its level or its scatter changes, as far as the evidence goes."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

Array = NDArray[np.float64]
Rows = NDArray[np.int_]

WEAK = 0.01  # observations that the prior mean is worth: a level may lie ten deviations from it
FINER = np.sqrt(0.5)  # length of the intervals of one layer over those of the one before
SHIFTS = 8  # intervals of a layer begin so often within one's length


def segments(series: Array, variance: Array, shortest: int) -> list[tuple[int, int]]:
    """First and last + 1 row of each piece of one level, in order; together they are all rows.

    `series` (n, k) are levels, `variance` (k,) what each scatters by at least where nothing
    changes, in the squared unit. Within a piece column j is independent and normal, mean and
    variance unknown under their conjugate prior, so that its evidence is a closed form (K. Murphy,
    Conjugate Bayesian analysis of the Gaussian distribution, 2007, section 3.5); each cut costs
    log n, as its place is one of n. Of all partitions the one of most evidence is taken (B. Jackson
    et al., IEEE Signal Process. Lett. 12 (2005) 105), whose cuts are among those that are best in
    some interval, of all lengths (S. Kovács et al., Seeded binary segmentation, Biometrika 110
    (2023) 249). No piece has less than `shortest` rows, unless the series has.
    """
    n = len(series)
    if not n:
        return []
    pieces = _Pieces(series, variance)
    cuts = np.array([0, *sorted(pieces.candidates(shortest)), n])
    best, before = np.zeros(len(cuts)), np.zeros(len(cuts), dtype=int)
    for k in range(1, len(cuts)):
        fits = int(np.searchsorted(cuts, cuts[k] - shortest, side="right"))
        begin = cuts[: max(fits, 1)]
        total = best[: len(begin)] + pieces.evidence(begin, np.full_like(begin, cuts[k]))
        before[k] = int(np.argmax(total))
        best[k] = total[before[k]] - np.log(n)
    taken = [len(cuts) - 1]
    while taken[-1]:
        taken.append(int(before[taken[-1]]))
    return list(pairwise(cuts[taken[::-1]].tolist()))


class _Pieces:
    """The evidence of each piece of a series, up to what all partitions have alike."""

    def __init__(self, series: Array, variance: Array) -> None:
        centred = series - (series.min(axis=0) + series.max(axis=0)) / 2
        zero = np.zeros((1, series.shape[1]))
        self._sums = np.concatenate([zero, np.cumsum(centred, axis=0)])
        self._squares = np.concatenate([zero, np.cumsum(centred**2, axis=0)])
        self._variance = variance
        count = np.arange(1, len(series) + 1)
        own = gammaln(1.0 + count / 2) + np.log(WEAK / (WEAK + count)) / 2
        self._own = np.concatenate([[0.0], series.shape[1] * own + np.log(variance).sum()])

    def evidence(self, first: Rows, last: Rows) -> Array:
        """Log marginal likelihood of rows `first` to before `last`, of any shape."""
        count = (last - first).astype(np.float64)[..., None]
        total = self._sums[last] - self._sums[first]
        spread = np.maximum(self._squares[last] - self._squares[first] - total**2 / count, 0.0)
        scale = self._variance + (spread + WEAK * total**2 / (count * (WEAK + count))) / 2
        scaled = (1.0 + count[..., 0] / 2) * np.log(scale).sum(axis=-1)
        return np.asarray(self._own[last - first] - scaled)

    def candidates(self, shortest: int) -> set[int]:
        """The best cut of each interval that is better cut than whole."""
        found: set[int] = set()
        n = len(self._sums) - 1
        length = float(n)
        while int(length) >= 2 * shortest:
            rows = int(length)
            first = np.arange(0, n - rows + 1, max(rows // SHIFTS, 1))[:, None]
            at = first + np.arange(shortest, rows - shortest + 1)
            sides = self.evidence(np.broadcast_to(first, at.shape), at)
            sides += self.evidence(at, np.broadcast_to(first + rows, at.shape))
            gain = sides.max(axis=1) - self.evidence(first, first + rows)[:, 0]
            found |= set(at[np.arange(len(at)), sides.argmax(axis=1)][gain > 0.0].tolist())
            length *= FINER
        return found
