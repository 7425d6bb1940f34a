"""Time stamps as a uniform grid: which sample is which, what is missing, and what does not fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.formats.error import ExchangeError

STRAY = 0.25
"""How far a step may be off a whole number of periods, in periods: stamps rounded to milliseconds
at 400 Hz are off by 0.2."""
SILENT = 1e-3
"""Up to here, in periods, stamps are as good as equally spaced."""
FEWEST = 0.1
"""The least share of samples that must be there, beyond `FREE_GAPS`: a clock that was set anew
must not become a billion missing samples."""
FREE_GAPS = 100_000
RESAMPLE = "resample_hz = … takes every channel to one rate, with a stated error"
UNEVEN = 0.1  # share of steps that are no whole number of periods
SURE = 5e-3
"""How coarse rounded stamps may be, as a share of the time they cover, to tell the rate."""
FEWEST_ROUNDED = 10  # stamps that tell by their steps how they were rounded
MANY = 8
"""So many longer steps, as evenly spread as rounding makes them, are no missing samples."""


class UnevenError(ExchangeError):
    """Time stamps that rise, but lie on no equal steps."""


@dataclass(frozen=True)
class Grid:
    """Sample i lies at row `index[i]` of `rows`, and row k at `start_s` + k / `rate_hz`.

    `jitter_s` is how far the stamps were off at most; `rounded_s` is what they were rounded to, if
    that is why they are off.
    """

    start_s: float
    rate_hz: float
    index: NDArray[np.int64]
    jitter_s: float = 0.0
    rounded_s: float = 0.0

    @property
    def rows(self) -> int:
        """Rows of the grid, those without a sample included."""
        return int(self.index[-1]) + 1

    def spread(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """(rows, c) samples at their places and NaN where there are none, from (n, c)."""
        if len(values) == self.rows:
            return values
        spread = np.full((self.rows, values.shape[1]), np.nan)
        spread[self.index] = values
        return spread

    def remarks(self) -> tuple[str, ...]:
        """What is worth a line in the recording's history."""
        found = []
        if self.rounded_s:
            found.append(
                f"time stamps are rounded to {self.rounded_s * 1e3:.6g} ms: taken as equal steps of"
                f" {1e3 / self.rate_hz:.6g} ms"
            )
        elif self.jitter_s > SILENT / self.rate_hz:
            found.append(
                f"time stamps are up to {self.jitter_s * 1e3:.3g} ms off equal steps of "
                f"{1e3 / self.rate_hz:.6g} ms: taken as equal"
            )
        missing = self.rows - len(self.index)
        if missing:
            gaps = int((np.diff(self.index) > 1).sum())
            found.append(
                f"samples missing in the time stamps: {missing}, in gaps: {gaps}; left empty"
            )
        return tuple(found)


def too_few(there: int, rows: float) -> bool:
    """Whether samples are so few of their rows that their times are not to be believed."""
    return rows > max(there / FEWEST, there + FREE_GAPS)


@np.errstate(all="ignore")  # absurd stamps are reported, not warned about
def fit_grid(
    time_s: NDArray[np.float64],
    where: Callable[[int], str],
    rate_hz: float | None = None,
    start_s: float | None = None,
) -> Grid:
    """Find the grid that the stamps (n >= 1) lie on, of a known rate and start if they are given.

    `where(i)` tells a user where stamp i is. Raises `ExchangeError` for stamps that are not finite
    or do not rise, `UnevenError` for those that lie on no grid. Stamps that are equal, as coarse
    ones are, need a known rate.
    """
    if len(time_s) < 2 and rate_hz is None:
        raise ExchangeError(f"{where(0)}: a single time stamp has no rate: give rate_hz")
    bad = ~(np.abs(time_s) < 1e15)
    if bad.any():
        row = int(np.argmax(bad))
        raise ExchangeError(f"{where(row)}: {time_s[row]} is no time")
    steps = np.diff(time_s)
    if start_s is None and (rounded := _rounded(time_s, steps, where, rate_hz)) is not None:
        return rounded
    if (steps <= 0).any():
        row = int(np.argmax(steps <= 0)) + 1
        falls = bool((steps < 0).any())
        raise (ExchangeError if falls else UnevenError)(
            f"{where(row)}: time does not rise, from {time_s[row - 1]:.9g} to {time_s[row]:.9g} s"
            f"{'' if falls else f': {RESAMPLE}'}"
        )
    period = 1.0 / rate_hz if rate_hz else typical_step(steps)
    counts = np.round(steps / period)
    off = np.abs(steps / period - counts)
    if len(steps) >= FEWEST_ROUNDED and (off > STRAY).mean() > UNEVEN:
        raise UnevenError(
            f"{where(0)}: time goes on in uneven steps, {steps.min():.3g} to {steps.max():.3g} s,"
            f" about {1 / steps.mean():.3g} Hz: {RESAMPLE}; if the samples are equally spaced,"
            " leave time out and say rate_hz"
        )
    if (counts < 1).any() or (off > STRAY).any():
        row = int(np.argmax((counts < 1) | (off > STRAY))) + 1
        raise UnevenError(
            f"{where(row)}: time jumps from {time_s[row - 1]:.9g} to {time_s[row]:.9g} s, "
            f"{steps[row - 1] / period:.3g} steps of {period:.6g} s: cut the file there, or"
            f" {RESAMPLE}"
        )
    if too_few(len(time_s), counts.sum() + 1):
        row = int(np.argmax(counts)) + 1
        raise ExchangeError(
            f"{where(row)}: {counts.sum() - len(steps):.6g} samples are missing, most of them "
            f"here ({time_s[row - 1]:.9g} to {time_s[row]:.9g} s): cut the file there"
        )
    index = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    if rate_hz is None:
        rate_hz = _rate(time_s, index)
    places = index / rate_hz
    if start_s is None:
        start_s = float(time_s[0])
        if np.abs(time_s - start_s - places).max() > SILENT / rate_hz:
            start_s = float((time_s - places).mean())
    else:
        index = index + round((float(time_s[0]) - start_s) * rate_hz)
        places = index / rate_hz
    jitter = np.abs(time_s - start_s - places)
    if jitter.max() > 2 * STRAY / rate_hz:
        raise UnevenError(
            f"{where(int(np.argmax(jitter)))}: time is {jitter.max():.3g} s off equal steps at "
            f"{rate_hz:.6g} Hz; on the whole the stamps go at {_rate(time_s, index):.6g} Hz:"
            f" {RESAMPLE}"
        )
    return Grid(start_s, rate_hz, index, float(jitter.max()))


def _rounded(
    time_s: NDArray[np.float64],
    steps: NDArray[np.float64],
    where: Callable[[int], str],
    rate_hz: float | None,
) -> Grid | None:
    """The grid of stamps without gaps that were rounded to a decimal so coarse that their steps
    are uneven, or some of them 0; None if that is not what they look like.

    Raises `ExchangeError` where the rate, or whether samples are missing, cannot be told.
    """
    forward = steps[steps > 0]
    if len(time_s) < FEWEST_ROUNDED or (steps < 0).any() or not len(forward):
        return None
    unit_s, index = float(forward.min()), np.arange(len(time_s))
    counts = np.round(steps / unit_s)
    decade = np.log10(unit_s)
    decimal = abs(decade - round(decade)) < 1e-5 and np.abs(steps / unit_s - counts).max() < 0.1
    if not decimal or counts.max() == counts.min() or counts.max() - counts.min() > 1:
        return None
    equal, longer = bool((steps == 0).any()), int((counts == counts.max()).sum())
    # Steps of one and two units may be a grid from which samples are missing, too.
    gaps = not equal and counts.max() == 2 and longer < len(steps) / 4
    if rate_hz is not None:
        fits = _spread(time_s, index, rate_hz) < unit_s and not gaps
        return _on_steps(time_s, index, rate_hz, unit_s) if fits else None
    rate = (len(time_s) - 1) / float(time_s[-1] - time_s[0])
    if (gaps and longer < 2) or _least_spread(time_s, index) > 1.02 * unit_s:
        return None
    if equal or unit_s > SURE * (time_s[-1] - time_s[0]) or (gaps and longer < MANY):
        row = int(np.argmax(counts == counts.max())) + 1
        raise UnevenError(
            f"{where(row)}: time stamps are rounded to {unit_s:.6g} s, too coarse to tell the rate,"
            f" about {rate:.4g} Hz: say rate_hz, or {RESAMPLE}"
        )
    return _on_steps(time_s, index, _rate(time_s, index), unit_s)


def _on_steps(
    time_s: NDArray[np.float64], index: NDArray[np.int64], rate_hz: float, unit_s: float
) -> Grid:
    """Stamps that were rounded to `unit_s` as equal steps, which begin where they fit best."""
    since = time_s - index / rate_hz
    start_s = float(since.max() + since.min()) / 2
    return Grid(start_s, rate_hz, index, float(np.abs(since - start_s).max()), unit_s)


def _least_spread(time_s: NDArray[np.float64], index: NDArray[np.int64]) -> float:
    """How far apart the stamps are, s, on the grid that fits them best."""
    places = index - index.mean()
    return _spread(time_s, index, float(places @ places / (places @ (time_s - time_s[0]))))


def typical_step(steps: NDArray[np.float64]) -> float:
    """The period: the mean of the steps that are no gaps, for rounded stamps alternate."""
    period = float(np.median(steps))
    for least, most in ((0.5, 1.6), (1 - STRAY, 1 + STRAY)):
        near = steps[(steps > least * period) & (steps < most * period)]
        period = float(near.mean()) if len(near) else period
    return period


def _rate(time_s: NDArray[np.float64], index: NDArray[np.int64]) -> float:
    """The rate by least squares, or the roundest number that fits the stamps as well."""
    places = index - index.mean()
    exact = float(places @ places / (places @ (time_s - time_s[0])))
    allowed = 1.05 * _spread(time_s, index, exact) + 2e-6 / exact
    for digits in range(17):
        rate_hz = float(f"{exact:.{digits}g}")
        if _spread(time_s, index, rate_hz) <= allowed:
            break
    return rate_hz


def _spread(time_s: NDArray[np.float64], index: NDArray[np.int64], rate_hz: float) -> float:
    """How far apart the stamps are on a grid of this rate, seconds, wherever it starts."""
    return float(np.ptp(time_s - time_s[0] - index / rate_hz))  # clocks hold large numbers
