"""Noise that a record cannot be below: its values come in steps."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Run
from wheelhop.compare.band import InBand

Array = NDArray[np.float64]

ON_STEP = 0.01
"""How far from a multiple of the step values may lie, in steps: what rounding to six digits leaves
of some thousand steps. Numbers on no grid lie within it once in fifty."""

FEWEST = 3  # different values show that steps are alike


def step_of(values: Array) -> float:
    """The step in which the values (n,) of a record come; 0 if they come in none."""
    levels = np.unique(values)
    gaps = np.diff(levels)
    rounding = 1e-9 * float(np.abs(levels).max())
    gaps = gaps[gaps > rounding]
    if len(gaps) < FEWEST - 1:
        return 0.0
    step = float(gaps.min())
    count = np.maximum(np.round(gaps / step), 1.0)
    step = float(gaps.sum() / count.sum())
    within = np.maximum(ON_STEP, rounding / step)
    return step if np.all(np.abs(gaps / step - count) < within) else 0.0


def quantisation_rms(values: Array, band: InBand) -> float:
    """Noise in band, r.m.s., that the steps of a record (n,) make of the signal, in its unit.

    The error is even within a step, of variance step²/12 (W. R. Bennett, Spectra of quantized
    signals, Bell Syst. Tech. J. 27 (1948) 446). Where nearly every sample is another value it is
    white. Where a value lasts it is a sawtooth of as many teeth as there are changes, m, whose
    power below the frequency of b/2 periods is about 1 / (1 + 2m/b), b being the data in band.
    """
    step = step_of(values)
    if step == 0.0:
        return 0.0
    changes = float(np.count_nonzero(np.diff(values)))
    share = max(band.count / band.n, 1.0 / (1.0 + 2.0 * changes / band.count))
    return step * float(np.sqrt(share / 12.0))


@lru_cache(maxsize=8)
def least_noise(runs: tuple[Run, ...], rate_hz: float, band_hz: tuple[float, float]) -> Array:
    """`quantisation_rms` (n_channels,) of every channel over all runs, in the channels' units."""
    powers = [
        [quantisation_rms(values, InBand(len(values), rate_hz, band_hz)) ** 2 for values in columns]
        for columns in (run.record.T for run in runs)
    ]
    return np.asarray(np.sqrt(np.mean(powers, axis=0)))
