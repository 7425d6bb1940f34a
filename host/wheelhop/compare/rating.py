"""ISO/TS 18571:2014, objective rating metric for non-ambiguous signals.

Four scores between 0 (no agreement) and 1 are weighted into one rating: how much of
the model lies inside a corridor about the measurement, how far it must be shifted to
correlate best, and how its magnitude and slope compare after that shift. Above 0.94 the
standard calls the agreement excellent, above 0.80 good, above 0.58 fair, else poor.

The equations count samples. The standard has 10 kHz crash signals in mind; here they are
applied at the record's own rate, so that at 100 Hz the slope's nine-point mean spans
90 ms: compare ratings with each other, not with those of crash tests.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

Array = NDArray[np.float64]

INNER, OUTER, CORRIDOR_POWER = 0.05, 0.5, 2  # corridor half-widths over the largest |measured|
MAX_SHIFT = 0.2  # of the record
DTW_WINDOW = 0.1  # of the shifted record
MAX_MAGNITUDE_ERROR, MAX_SLOPE_ERROR = 0.5, 2.0
WEIGHTS = (0.4, 0.2, 0.2, 0.2)


@dataclass(frozen=True)
class Rating:
    """The four scores of ISO/TS 18571 and their weighted sum, each in [0, 1]."""

    corridor: float
    phase: float
    magnitude: float
    slope: float

    @property
    def overall(self) -> float:
        """Weighted sum, 0.4 corridor + 0.2 (phase + magnitude + slope)."""
        scores = (self.corridor, self.phase, self.magnitude, self.slope)
        return sum(w * s for w, s in zip(WEIGHTS, scores, strict=True))


def iso18571(measured: ArrayLike, model: ArrayLike) -> list[Rating]:
    """Rate each column of ``model`` (n, columns) against the same column of ``measured``.

    All columns advance through the time warping together, so that rating many at once
    costs little more than rating one. A column whose measurement is zero throughout has
    no rating: all its scores are NaN.
    """
    t, c = np.asarray(measured, dtype=float).T, np.asarray(model, dtype=float).T
    if t.ndim != 2 or t.shape != c.shape:
        raise ValueError(f"expected two arrays (n, columns), got {t.T.shape} and {c.T.shape}")
    n = t.shape[1]
    shift = np.array([_best_shift(*pair) for pair in zip(t, c, strict=True)], dtype=int)
    aligned = [_aligned(*pair) for pair in zip(t, c, shift, strict=True)]
    with np.errstate(divide="ignore", invalid="ignore"):
        phase = np.clip(1.0 - np.abs(shift) / (MAX_SHIFT * n), 0.0, 1.0)
        magnitude = np.clip(1.0 - _warped_error(aligned) / MAX_MAGNITUDE_ERROR, 0.0, 1.0)
        slope_error = np.array([_slope_error(*pair) for pair in aligned])
        slope = np.clip(1.0 - slope_error / MAX_SLOPE_ERROR, 0.0, 1.0)
        scores = np.stack([_corridor(t, c), phase, magnitude, slope])
    scores[:, ~t.any(axis=1)] = np.nan
    return [Rating(*map(float, column)) for column in scores.T]


def _corridor(t: Array, c: Array) -> Array:
    """Mean corridor score of each row (clause 6.2)."""
    largest = np.abs(t).max(axis=1, keepdims=True)
    score = (OUTER * largest - np.abs(t - c)) / ((OUTER - INNER) * largest)
    return np.asarray((np.clip(score, 0.0, 1.0) ** CORRIDOR_POWER).mean(axis=1))


def _best_shift(t: Array, c: Array) -> int:
    """Samples by which ``c`` lags ``t``: largest correlation of the parts that overlap.

    Of shifts that correlate equally well (a periodic signal has many) the smallest counts.
    """
    n = len(t)
    lags = np.arange(-int(MAX_SHIFT * n), int(MAX_SHIFT * n) + 1)
    size = fft.next_fast_len(2 * n, real=True)
    product = fft.irfft(np.conj(fft.rfft(t, size)) * fft.rfft(c, size), size)[lags]
    # Sums over the overlap: t from start_t on, c from start_c on, `overlap` samples of each.
    overlap, start_t, start_c = n - np.abs(lags), np.maximum(-lags, 0), np.maximum(lags, 0)

    def windowed(x: Array, start: NDArray[np.int_]) -> Array:
        total = np.concatenate([[0.0], np.cumsum(x)])
        return np.asarray(total[start + overlap] - total[start])

    sum_t, sum_c = windowed(t, start_t), windowed(c, start_c)
    variance_t = windowed(t * t, start_t) - sum_t**2 / overlap
    variance_c = windowed(c * c, start_c) - sum_c**2 / overlap
    with np.errstate(divide="ignore", invalid="ignore"):
        rho = (product - sum_t * sum_c / overlap) / np.sqrt(variance_t * variance_c)
    if not np.isfinite(rho).any():
        return 0
    best = lags[rho >= np.nanmax(rho) - 1e-9]
    return int(min(best, key=lambda lag: (abs(lag), -lag)))


def _aligned(t: Array, c: Array, shift: int) -> tuple[Array, Array]:
    """The parts of both curves that overlap once ``c`` is moved ``shift`` samples earlier."""
    if shift == 0:
        return t, c
    return (t[:-shift], c[shift:]) if shift > 0 else (t[-shift:], c[:shift])


def _slope_error(t: Array, c: Array) -> float:
    """Relative 1-norm distance of the smoothed derivatives."""
    difference, reference = _smooth_slope(t - c), _smooth_slope(t)
    return float(np.abs(difference).sum() / np.abs(reference).sum())


def _smooth_slope(x: Array) -> Array:
    """Central differences, then a nine-point mean that narrows towards both ends."""
    slope = np.gradient(x)
    half = np.minimum(np.arange(len(x)), np.arange(len(x))[::-1]).clip(max=4)
    total = np.concatenate([[0.0], np.cumsum(slope)])
    i = np.arange(len(x))
    return np.asarray((total[i + half + 1] - total[i - half]) / (2 * half + 1))


def _warped_error(aligned: list[tuple[Array, Array]]) -> Array:
    """Relative 1-norm distance of each pair along its optimal warping path.

    Dynamic time warping with squared distances, steps (1,0), (0,1), (1,1) and a window of
    a tenth of the record. Cells (i, j) are visited along antidiagonals i + j; a state array
    over the offset k = i - j then holds, at the parity of the last antidiagonal, its two
    direct predecessors and, at the other, the diagonal one, so that the update happens in
    place. |c - t| and |t| are summed along with the cost: no path is traced back.
    """
    length = np.array([len(t) for t, _ in aligned])
    window = np.ceil(DTW_WINDOW * length).astype(int) - 1
    pairs, n, w = len(aligned), int(length.max()), int(window.max())
    t, c = np.zeros((2, pairs, n + 2 * w))
    for row, pair in enumerate(aligned):
        t[row, w : w + length[row]], c[row, w : w + length[row]] = pair
    t[:, :w] = c[:, :w] = np.inf  # before the first sample there is no path
    t = t[:, ::-1]
    offset = np.arange(-w - 1, w + 2)
    outside = np.where(np.abs(offset) > window[:, None], np.inf, 0.0)
    cost, error, norm = state = np.zeros((3, pairs, 2 * w + 3))
    cost[:, offset != 0] = np.inf
    at_end = np.empty((n, 2, pairs))
    for diagonal in range(2 * n - 1):
        first = -w + (diagonal + w) % 2
        cells = slice(first + w + 1, -1, 2)
        count = len(range(*cells.indices(len(offset))))
        i, j = (diagonal + first) // 2 + w, (diagonal - first) // 2 + w
        reference = t[:, t.shape[1] - 1 - j :][:, :count]
        distance = np.abs(c[:, i : i + count] - reference)
        here, below, above = (state[:, :, cells.start + k : None : 2] for k in (0, -1, 1))
        best = here[:, :, :count]
        for other in (below[:, :, :count], above[:, :, :count]):
            best = np.where(other[0] < best[0], other, best)
        cost[:, cells] = best[0] + distance**2 + outside[:, cells]
        error[:, cells] = best[1] + distance
        norm[:, cells] = best[2] + np.abs(reference)
        if diagonal % 2 == 0:
            at_end[diagonal // 2] = error[:, w + 1], norm[:, w + 1]
    ends = at_end[length - 1, :, np.arange(pairs)]
    return np.asarray(ends[:, 0] / ends[:, 1])
