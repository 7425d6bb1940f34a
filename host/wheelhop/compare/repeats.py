"""Noise of a rig's records where the same motion is imposed again: what does not repeat."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.interpolate import CubicSpline

from wheelhop.campaign import RigRun, Run
from wheelhop.compare.band import InBand

Array = NDArray[np.float64]

REPEATS = 0.03
"""Two stretches whose imposed motion, or force, differs by less than this share are repeats: what
follows to second order from such a difference is a thousandth."""

PERIODIC = 0.02
"""A record that differs from itself one period later has at most this share of its power there. A
period that is no whole number of samples leaves (π/n)²/2 for n samples in it: this is n = 16."""

FOLLOWS = 0.5
"""Of a motion that repeats less well than by this much of how well the force repeats, part of the
latter's difference follows from it: at this share, a quarter of the power."""

OF_NORMAL = 1.4826
"""Standard deviation of normal numbers over their median distance from the median."""


@dataclass(frozen=True)
class Scatter:
    """Noise in band of the measured quantity, r.m.s. in its unit, and its relative standard
    uncertainty, as so many `runs` with a repeat show it."""

    noise_rms: float
    uncertainty: float
    runs: int


@dataclass(frozen=True, eq=False)
class _Signals:
    """What was measured of a run, and imposed, means taken out: columns of a function of the
    sample, and the latter (n,) by itself."""

    columns: CubicSpline
    imposed: Array

    @classmethod
    def of(cls, run: RigRun) -> _Signals:
        imposed, measured = run.displacement, run.force
        if run.drive == "force":
            imposed, measured = measured, imposed
        both = np.stack([measured - measured.mean(), imposed - imposed.mean()], axis=1)
        return cls(CubicSpline(np.arange(len(both)), both), both[:, 1])


@lru_cache(maxsize=8)
def scatter(runs: tuple[Run, ...], rate_hz: float, band_hz: tuple[float, float]) -> Scatter | None:
    """The noise of a component's runs as their repeats show it; None where nothing repeats, or
    these are runs of a vehicle.

    Repeats are the periods of a run whose imposed motion is periodic, and runs that impose the same
    motion, each beside the one it is most like. Half the mean square of their difference is the
    noise's. The median over periods and over runs counts: where something happened once, it is not
    the noise of the others.
    """
    signals = [_Signals.of(run) for run in runs if isinstance(run, RigRun)]
    of_run: dict[int, tuple[float, float]] = {}
    for i, one in enumerate(signals):
        pairs = _periods(one)
        found = [each for a, b in pairs if (each := _noise_of(a, b, rate_hz, band_hz)) is not None]
        if found:
            of_run[i] = float(np.median([power for power, _ in found])), sum(n for _, n in found)
    for i, j in combinations(range(len(signals)), 2):
        between = _noise_of(*_aligned(signals[i], signals[j]), rate_hz, band_hz)
        if between is not None:
            of_run |= {k: min(of_run.get(k, between), between) for k in (i, j)}
    if not of_run:
        return None
    power, freedom = np.array(list(of_run.values())).T
    middle = float(np.median(power))
    # Two of three differences: a period is in the one before it and in the one after it.
    by_chance = np.sqrt(2.0 / (freedom.sum() * 2.0 / 3.0))
    apart = OF_NORMAL * float(np.median(np.abs(power - middle))) / max(middle, 1e-300)
    unlike = np.hypot(by_chance, apart / np.sqrt(len(power)))
    return Scatter(float(np.sqrt(middle)), 0.5 * float(unlike), len(power))


def _periods(one: _Signals) -> Iterator[tuple[Array, Array]]:
    """Columns (n, 2) of a run's periods, each with one so many periods later that samples fall on
    samples as nearly as can be: where a force jumps, nothing need be interpolated."""
    period = period_of(one.imposed)
    if period is None:
        return
    n = len(one.imposed)
    later = period * np.arange(1, int(n / (2.0 * period)) + 1)
    lag = round(float(later[np.argmin(np.abs(later - np.round(later)))]))
    within = np.arange(int(period))
    for begin in range(0, n - lag - len(within) + 1, len(within)):
        yield one.columns(begin + within), one.columns(begin + lag + within)


def _aligned(a: _Signals, b: _Signals) -> tuple[Array, Array]:
    """What two runs have in common once the second is shifted to where it is most like the first,
    in parts of a sample."""
    n = min(len(a.imposed), len(b.imposed))
    cross = fft.irfft(fft.rfft(a.imposed[:n]) * fft.rfft(b.imposed[:n]).conj(), n)
    peak = int(np.argmax(cross))
    ahead = peak - n * (peak > n // 2) + _bottom(-np.roll(cross, 1 - peak)[:3], 1) - 1.0
    at = np.arange(np.ceil(max(ahead, 0.0)), n - 1 + min(ahead, 0.0))
    return a.columns(at), b.columns(at - ahead)


def _noise_of(
    a: Array, b: Array, rate_hz: float, band_hz: tuple[float, float]
) -> tuple[float, float] | None:
    """Mean square in band of the noise in the measured quantity, and how many independent data say
    so; None if two stretches (n, 2) are no repeats, or too short to tell."""
    apart, size = a - b, np.linalg.norm(0.5 * (a + b), axis=0)
    measured, imposed = np.linalg.norm(apart, axis=0) / np.maximum(size, 1e-300)
    if size[1] == 0.0 or imposed > min(REPEATS, FOLLOWS * measured):
        return None
    try:
        band = InBand(len(a), rate_hz, band_hz)
    except ValueError:
        return None
    return float(np.sum(band.coefficients(apart[:, 0]) ** 2)) / (2.0 * band.n), float(band.count)


def period_of(u: Array) -> float | None:
    """After how many samples a signal (n,) repeats, at least twice; None if it does not."""
    n = len(u)
    spectrum = fft.rfft(u, 2 * n)
    product = fft.irfft(np.abs(spectrum) ** 2)[: n // 2 + 1]
    square = np.append(0.0, np.cumsum(u**2))
    lag = np.arange(n // 2 + 1)
    both = square[n - lag] + square[n] - square[lag]
    apart = 1.0 - 2.0 * product / np.maximum(both, 1e-300)
    away = np.flatnonzero(apart > 0.5)
    if not len(away):
        return None
    inner = np.arange(away[0] + 1, len(apart) - 1)
    lowest = (apart[inner] <= apart[inner - 1]) & (apart[inner] < apart[inner + 1])
    alike = inner[lowest & (apart[inner] < PERIODIC)]
    if not len(alike):
        return None
    period, times = _bottom(apart, int(alike[0])), 1
    while 2 * times * period + 2 < len(apart):
        times *= 2
        near = round(times * period)
        period = _bottom(apart, near - 1 + int(np.argmin(apart[near - 1 : near + 2]))) / times
    return period


def _bottom(values: Array, at: int) -> float:
    """Where the parabola through a lowest value and its neighbours is lowest."""
    before, here, after = values[at - 1 : at + 2]
    bend = before - 2.0 * here + after
    return at + (0.5 * float((before - after) / bend) if bend > 0.0 else 0.0)
