"""How far a model may be from the record: the noise of the sensors, or what the model leaves.

No model is exact. Where it is wrong it is wrong in some runs and channels and not in others: a run
placed a wave too far along its track, a channel with a loose sensor, a fast drive that uses up a
clearance. So every channel of every run has a noise of its own. Beforehand its power is believed to
be the sensors', σ², as well as ν data would tell it (a scaled inverse χ² density). With n data
whose squares add up to Q the channel's noise integrates out to Student's t density (A. Gelman et
al., Bayesian Data Analysis, 3rd ed., section 3.2),

    −2 ln p = (ν + n) ln((ν σ² + Q) / (ν + n)) + n + const,

and a step of least squares weighs the channel by 1 / ρ²σ², ρ² = (ν + Q/σ²) / (ν + n) (K. Lange,
R. Little, J. Taylor, J. Am. Stat. Assoc. 84 (1989) 881, eq. 4). At the noise ρ is 1 and this is
least squares; of a channel far above it, only by how many times it becomes smaller counts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtr

Array = NDArray[np.float64]

BELIEVED = 8.0
"""ν: the sensors' noise is believed to be what is stated as well as so many data would tell it: to
a quarter, one standard deviation. Sensors of one make differ by that."""


def spread(residual: Array, sigma: float) -> Array:
    """ρ (c,) of every channel of a residual (n, c): its standard deviation per that of the sensors,
    σ."""
    return np.asarray(np.sqrt(_power(_squares(residual, sigma), len(residual))))


def cost(residual: Array, sigma: float) -> float:
    """−2 ln p of a residual (n, c); n c where it is noise of standard deviation σ."""
    return cost_of(_squares(residual, sigma), len(residual))


def louder(ratio: float) -> float:
    """Chance that the sensors' noise has at least this many times the power that is stated."""
    return float(chdtr(BELIEVED, BELIEVED / ratio))


def cost_of(squares: Array, count: int) -> float:
    """−2 ln p from Q/σ² (c,) of channels with `count` data each."""
    logarithm = np.log(_power(squares, count)).sum()
    return float((BELIEVED + count) * logarithm + count * len(squares))


def weights_of(squares: Array, count: int) -> Array:
    """1/ρ² (c,) of the same."""
    return np.asarray(1.0 / _power(squares, count))


def _squares(residual: Array, sigma: float) -> Array:
    with np.errstate(over="ignore"):  # a model that runs away leaves infinitely much
        return np.asarray(((residual / sigma) ** 2).sum(axis=0))


def _power(squares: Array, count: int) -> Array:
    return np.asarray((BELIEVED + squares) / (BELIEVED + count))
