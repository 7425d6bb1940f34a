"""Damping of the free part of a record: where a body swings out after a bump."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from wheelhop.campaign import Campaign, Run
from wheelhop.compare.band import InBand

Array = NDArray[np.float64]

SLOWEST_HZ, FASTEST_HZ = 0.7, 4.0
"""A body bounces and pitches in this range, from limousines to racing cars and bicycles."""

WINDOW_S = 1.5
"""So long a stretch is looked at, a wave of the slowest body and six of the fastest."""

FREE = 0.95
"""A stretch of which one decaying wave explains this share of the power is free: random roads
reach less in nearly every stretch, a swing after a bump more."""

LOUD = 3.0
"""A free stretch begins with an amplitude of at least so many times the record's rms below
`FASTEST_HZ`: a bump stands out so, and a random road hardly ever does."""

FINELY = 10
"""So many samples, at least, of a wave of `FASTEST_HZ` are kept; more would tell no more."""

AT_ONCE = 4096
"""So many stretches are fitted at once: an hour of record would else fill the memory."""

RATIOS = np.geomspace(0.02, 0.8, 30)
PER_OCTAVE = 12


@dataclass(frozen=True)
class FreeDecays:
    """Of one channel with one setting: how many free stretches there are, the frequency and the
    damping ratio of the wave in them, means, and the interval that holds the latter in 95 %; NaN
    where one stretch says nothing of their spread, and without any."""

    setting: str
    channel: str
    count: int
    frequency_hz: float
    damping: float
    low: float
    high: float


def free_decays(campaign: Campaign, setting: str, runs: Sequence[Run]) -> list[FreeDecays]:
    """What the free parts of some runs say, of every channel."""
    found = []
    for column, channel in enumerate(campaign.channels):
        every = [
            wave
            for run in runs
            for wave in decays(run.record[:, column], campaign.sample_rate_hz, campaign.band_hz[0])
        ]
        found.append(FreeDecays(setting, channel.name, len(every), *_mean(every)))
    return found


def _mean(waves: Sequence[tuple[float, float]]) -> tuple[float, float, float, float]:
    """Frequency, damping and its interval; damping counts by its logarithm."""
    nothing = float("nan")
    if not waves:
        return nothing, nothing, nothing, nothing
    frequency, damping = np.log(np.array(waves)).T
    middle = float(damping.mean())
    around = nothing
    if len(waves) > 1:
        around = float(
            stats.t.ppf(0.975, len(waves) - 1) * damping.std(ddof=1) / np.sqrt(len(waves))
        )
    low, high = (float(np.exp(middle + e)) for e in (-around, around))
    return float(np.exp(frequency.mean())), float(np.exp(middle)), low, high


def decays(record: Array, rate_hz: float, lowest_hz: float) -> list[tuple[float, float]]:
    """Frequency, Hz, and damping ratio of the decaying wave in every free stretch of a record
    (n,), the loudest first; stretches do not overlap.

    A wave A e^(−ζωt) cos(ω√(1−ζ²) t + φ) is fitted by least squares to every stretch, for all
    frequencies and damping ratios of a grid at once.
    """
    if len(record) < 2 * WINDOW_S * rate_hz:
        return []
    band = InBand(len(record), rate_hz, (min(lowest_hz, SLOWEST_HZ), FASTEST_HZ))
    every = max(1, int(rate_hz / (FINELY * FASTEST_HZ)))
    slow = band.signal(record)[::every]
    length = round(WINDOW_S * rate_hz / every)
    stretches = np.lib.stride_tricks.sliding_window_view(slow, length)
    power = (stretches**2).sum(axis=1)
    grid, basis = _waves(length, rate_hz / every)
    best, share = _fitted(stretches, basis)
    begins = np.abs(stretches[:, : max(1, length // 4)]).max(axis=1)
    free = (share >= FREE * power) & (begins >= LOUD * slow.std())
    return [grid[best[at]] for at in _apart(np.flatnonzero(free), power, length)]


def _fitted(stretches: Array, basis: Array) -> tuple[NDArray[np.intp], Array]:
    """Of every stretch the wave of the grid that catches most of its power, and how much."""
    best, share = np.empty(len(stretches), np.intp), np.empty(len(stretches))
    for first in range(0, len(stretches), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        along = stretches[part] @ basis.reshape(len(basis), -1)
        caught = (along**2).reshape(len(along), 2, -1).sum(axis=1)
        best[part], share[part] = caught.argmax(axis=1), caught.max(axis=1)
    return best, share


def _apart(places: NDArray[np.intp], power: Array, length: int) -> Iterable[int]:
    """Places that are a length apart, those of the largest power first."""
    taken: list[int] = []
    for at in sorted(places, key=lambda i: -power[i]):
        if all(abs(at - other) >= length for other in taken):
            taken.append(int(at))
    return taken


@lru_cache(maxsize=4)
def _waves(length: int, rate_hz: float) -> tuple[list[tuple[float, float]], Array]:
    """Frequency and damping ratio of every wave of the grid, and an orthonormal basis
    (length, 2, grid) of it with any phase."""
    octaves = np.log2(FASTEST_HZ / SLOWEST_HZ)
    frequencies = np.geomspace(SLOWEST_HZ, FASTEST_HZ, round(PER_OCTAVE * octaves) + 1)
    grid = [(float(f), float(z)) for f in frequencies for z in RATIOS]
    time_s = np.arange(length) / rate_hz
    basis = np.empty((length, 2, len(grid)))
    for i, (frequency_hz, ratio) in enumerate(grid):
        pole = 2 * np.pi * frequency_hz * (-ratio + 1j * np.sqrt(1 - ratio**2))
        wave = np.exp(pole * time_s)
        basis[:, :, i] = np.linalg.qr(np.column_stack([wave.real, wave.imag]))[0]
    return grid, basis
