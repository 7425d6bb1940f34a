"""Judgement: is one model better than another on runs that neither was fitted to?"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.confirm import Rung
from wheelhop.fit import Fit, RunFit

Array = NDArray[np.float64]

BLOCK_S = 1.0
"""Residuals are not white, but what one second of a run says of a model says little of the next."""


def advantage(base: Rung, rival: Rung) -> float:
    """How surely `rival` beats `base` on the runs that judge: t = Σd / √Σd².

    d is the logarithm of the ratio of the residuals' sums of squares, base to rival, in one block
    (one second of one run), charged for the numbers free in that run; the logarithm gives loud and
    quiet blocks one vote each. If the models were equally good, the signs of d would be those of
    fair coins, and t would exceed t₀ with a probability below exp(−t₀²/2) (Hoeffding's inequality,
    J. Am. Stat. Assoc. 58 (1963) 13), whatever the distribution of d. Negative if the rival is
    worse.

    The runs with role "validate" judge; a campaign without any is judged by its fitted runs.
    """
    before, after = _judging(base), _judging(rival)
    drops = np.concatenate([_drops(a, b) for a, b in zip(before.runs, after.runs, strict=True)])
    spread = float(np.sqrt(np.sum(drops**2)))
    return float(np.sum(drops)) / spread if spread > 0 else 0.0


def p_value(t: float, tried: int) -> float:
    """Chance that one of `tried` worthless effects shows an advantage of t or more."""
    return min(1.0, tried * float(np.exp(-0.5 * t * t))) if t > 0 else 1.0


def relative_to_noise(base: Rung, rival: Rung, noise: float) -> float:
    """Drop of the held-out sum of squares, charged, in units of what noise alone leaves there."""
    before, after = _charged(base), _charged(rival)
    size = sum(run.bench.size for run in _judging(base).runs)
    return (before - after) / (size * noise**2) if noise > 0 else np.inf


def _judging(rung: Rung) -> Fit:
    return rung.fit if rung.validation is None else rung.validation


def _charged(rung: Rung) -> float:
    return sum(
        run.rss * run.bench.size / max(run.bench.size - len(run.own), 1)
        for run in _judging(rung).runs
    )


def _count(run: RunFit) -> int:
    time = run.bench.run.time_s
    return max(1, round(float(time[-1] - time[0]) / BLOCK_S))


def _drops(base: RunFit, rival: RunFit) -> Array:
    count = _count(base)
    size = base.bench.size
    charge = float(np.log(max(size - len(rival.own), 1) / max(size - len(base.own), 1)))
    return np.log(_block_squares(base, count) / _block_squares(rival, count)) + charge


def _block_squares(run: RunFit, count: int) -> Array:
    band = run.bench.band
    signal = band.from_coefficients(run.residual.reshape(band.count, -1))
    return np.array([np.sum(part**2) for part in np.array_split(signal, count)])
