"""Channels with clocks of their own on one rate, and how uncertain each is between its samples.

Between two samples a channel is taken on the straight line. How far off that is, the samples tell
themselves: each is drawn from its neighbours, at twice and at four times the step. The error grows
with a power of the step, 2 for a smooth signal, ½ for a random walk, 0 for noise, so its value at
the step itself follows from those two.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import NUMBERS, check_room
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.grid import SILENT, STRAY, too_few
from wheelhop.formats.mapping import Map, Pick
from wheelhop.formats.table import Between, Table, clocks_are_known, columns_of

USUAL = 0.9
"""Share of a channel's steps that do not exceed its usual one: phones and buses take short and long
steps in turn."""
LONGEST_GAP = 4.0
"""In usual steps: over more than that a straight line says nothing, for the error of a smooth
signal is 16 times as large by then. It is left empty."""
FEWEST = 10
"""Samples that tell how uncertain a channel is between them."""
LATEST_S = 1e15  # beyond it a number is no time


def onto_rate(tables: Sequence[Table], mapping: Map) -> Table:
    """What the mapping picks of all tables as one table, at `resample_hz` samples a second; before
    a channel's first sample, after its last and in gaps its rows are NaN.

    Raises `ExchangeError` for clocks that do not tell how far they are apart, stamps that fall, and
    a rate below a channel's own, which would lose samples.
    """
    rate_hz = mapping.resample_hz
    assert rate_hz is not None
    clocks = _clocks(tables, mapping)
    whole = side_by_side(tables)
    picks = mapping.picks or tuple(Pick(number) for number in whole.columns)
    wanted = list(dict.fromkeys(columns_of(whole, picks)))
    source = [(n, k) for n, table in enumerate(tables) for k in range(len(table.channels))]
    series = [_series(tables[n], clocks[n], k) for n, k in (source[column] for column in wanted)]
    first = min(float(one.time_s[0]) for one in series)
    last = max(float(one.time_s[-1]) for one in series)
    count = int((last - first) * rate_hz + SILENT) + 1
    _check_rows(count, max(one.lasts_s for one in series) * rate_hz, len(series), whole.file)
    rows_s = first + np.arange(count) / rate_hz
    values, between = np.empty((len(rows_s), len(series))), []
    for at, (column, one) in enumerate(zip(wanted, series, strict=True)):
        if rate_hz < (1 - STRAY) * one.rate_hz:
            raise ExchangeError(
                f"{whole.file}: {whole.channels[column].name} has {one.rate_hz:.4g} samples a"
                f" second: resample_hz = {rate_hz:g} would lose some: say more, or leave it out"
            )
        values[:, at], on_samples = one.at(rows_s)
        between.append(Between(one.rate_hz, 0.0 if on_samples else one.error()))
    return replace(
        whole,
        channels=tuple(whole.channels[column] for column in wanted),
        numbers=tuple(whole.columns[column] for column in wanted),
        values=values,
        between=tuple(between),
        time_s=None,
        rate_hz=rate_hz,
        start_s=first,
        lines=(),
        remarks=(*whole.remarks, *_merged(series), f"taken to {rate_hz:g} Hz, on straight lines"),
    )


@dataclass(frozen=True)
class _Series:
    """A channel's own samples (n,) and when they were taken (n,), s; steps longer than `gap_s` are
    gaps; `merged` is how many samples shared a stamp with another one."""

    time_s: NDArray[np.float64]
    values: NDArray[np.float64]
    gap_s: float
    merged: int

    @property
    def lasts_s(self) -> float:
        """How long the channel was recorded, gaps apart, s."""
        steps = np.diff(self.time_s)
        return float(steps[steps <= self.gap_s].sum())

    @property
    def rate_hz(self) -> float:
        """Samples a second, gaps apart."""
        kept = int((np.diff(self.time_s) <= self.gap_s).sum())
        return kept / self.lasts_s if kept else 0.0

    def at(self, rows_s: NDArray[np.float64]) -> tuple[NDArray[np.float64], bool]:
        """The channel at these instants (m,), and whether all of them are its samples'."""
        found = np.interp(rows_s, self.time_s, self.values)
        slack = SILENT * float(rows_s[1] - rows_s[0]) if len(rows_s) > 1 else 0.0
        before = np.clip(np.searchsorted(self.time_s, rows_s, "right") - 1, 0, None)
        after = np.clip(before + 1, None, len(self.time_s) - 1)
        off = np.minimum(np.abs(rows_s - self.time_s[before]), np.abs(rows_s - self.time_s[after]))
        empty = (rows_s < self.time_s[0]) | (rows_s > self.time_s[-1])
        empty |= self.time_s[after] - self.time_s[before] > self.gap_s
        empty &= off > slack
        found[empty] = np.nan
        return found, bool((off[~empty] <= slack).all())

    def error(self) -> float:
        """Root mean square error of the straight line midway between two samples; all there is of
        the signal if the samples are too few to tell."""
        near, far = self._left_out(1), self._left_out(2)
        if min(len(near), len(far)) < FEWEST:
            return float(np.std(self.values))
        one, two = (float(np.sqrt(np.mean(np.square(off)))) for off in (near, far))
        return 0.0 if one == 0.0 else one / max(1.0, two / one)

    def _left_out(self, reach: int) -> NDArray[np.float64]:
        """How far samples are off the line between those `reach` before and after, without gaps."""
        t, x = self.time_s, self.values
        gaps = np.concatenate([[0], np.cumsum(np.diff(t) > self.gap_s)])
        a, b, c = slice(None, -2 * reach), slice(reach, -reach), slice(2 * reach, None)
        line = x[a] + (x[c] - x[a]) * (t[b] - t[a]) / (t[c] - t[a])
        off: NDArray[np.float64] = (x[b] - line)[gaps[a] == gaps[c]]
        return off


def _check_rows(count: int, filled: float, columns: int, file: Path) -> None:
    """Raise for a clock that was set anew, which makes more rows than memory, nearly all empty."""
    if too_few(int(filled) + 1, count):
        raise ExchangeError(
            f"{file}: {count} rows, of which only {filled:.0f} would be filled: is a clock set anew"
            " in between? cut the file there"
        )
    check_room(file, NUMBERS * count * columns, ExchangeError)


def _series(table: Table, clock_s: NDArray[np.float64], column: int) -> _Series:
    rows = np.flatnonzero(~np.isnan(table.values[:, column]))
    if not len(rows):
        name = table.channels[column].name
        raise ExchangeError(f"{table.file}: {name} has no samples: leave it out with a mapping")
    time_s, values = clock_s[rows], table.values[rows, column]
    falls = np.diff(time_s) < 0
    if falls.any():
        row = int(np.argmax(falls)) + 1
        raise ExchangeError(
            f"{table.where(int(rows[row]))}: time does not rise, from {time_s[row - 1]:.9g} to"
            f" {time_s[row]:.9g} s"
        )
    stamps, places = np.unique(time_s, return_inverse=True)
    merged = len(time_s) - len(stamps)
    if merged:
        values = np.bincount(places, values) / np.bincount(places)
    steps = np.diff(stamps)
    gap_s = LONGEST_GAP * float(np.quantile(steps, USUAL)) if len(steps) else 0.0
    return _Series(stamps, values, gap_s, merged)


def _merged(series: Sequence[_Series]) -> list[str]:
    most = max(one.merged for one in series)
    return [f"samples that share a stamp with another: {most}; their mean is taken"] if most else []


def _clocks(tables: Sequence[Table], mapping: Map) -> list[NDArray[np.float64]]:
    """When the rows of each table were taken, s, on the clock of the first."""
    apart = _apart(tables)
    found = []
    for table, offset_s in zip(tables, apart, strict=True):
        rate_hz = mapping.rate_hz or table.rate_hz
        if table.time_s is not None:
            time_s = table.time_s
        elif rate_hz is not None:
            time_s = table.start_s + np.arange(len(table.values)) / rate_hz
        else:
            raise ExchangeError(f"{table.file}: has no time: give time or rate_hz in a mapping")
        if not (np.abs(time_s) < LATEST_S).all():
            row = int(np.argmin(np.abs(time_s) < LATEST_S))
            raise ExchangeError(f"{table.where(row)}: {time_s[row]} is no time")
        found.append(time_s + offset_s)
    return found


def _apart(tables: Sequence[Table]) -> list[float]:
    """By how much the zero of each table's clock is later than that of the first, s."""
    if len(tables) == 1:
        return [0.0]
    if not clocks_are_known(tables):
        names = ", ".join(f'"{table.group}"' for table in tables)
        raise ExchangeError(
            f"{tables[0].file}: does not say how far apart its groups began: choose with group = …"
            f" in a mapping from {names}"
        )
    if tables[0].same_clock:
        return [0.0] * len(tables)
    starts = [table.start_unix_s or 0.0 for table in tables]
    return [start - starts[0] for start in starts]


def side_by_side(tables: Sequence[Table]) -> Table:
    """The channels of all tables, without samples; those of one name are kept apart by group."""
    if len(tables) == 1:
        return tables[0]
    count = Counter(channel.name for table in tables for channel in table.channels)
    channels = [
        channel
        if count[channel.name] == 1
        else replace(channel, name=f"{table.group}/{channel.name}")
        for table in tables
        for channel in table.channels
    ]
    remarks = dict.fromkeys(remark for table in tables for remark in table.remarks)
    names = ", ".join(table.group for table in tables)
    return replace(
        tables[0],
        channels=tuple(channels),
        numbers=(),
        group=names,
        remarks=(*remarks, f"groups with clocks of their own: {names}"),
    )
