"""Groups of channels: which of them share a clock, and which are no recordings at all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from wheelhop.files.units import to_si
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.table import Table

TOGETHER = 0.01
"""How far, in steps, clocks may be off a whole number of steps and still be one."""
LONGEST = 1_000_000  # steps between the starts of groups that are one recording


def no_time(unit: str) -> str:
    """What is sampled over another quantity than time, by the unit of that."""
    kept = to_si(unit)[0]
    if kept == "Hz":
        return "this is a spectrum, no recording"
    if kept in ("m", "N", "m/s"):
        return "this is a loop, or sampled over distance, no recording"
    return "this is no recording"


def only_recordings(tables: list[Table], refused: Sequence[str], file: Path) -> list[Table]:
    """The tables, whose history says what of the file was left out. Raises `ExchangeError` if
    nothing else is there."""
    if refused and not tables:
        more = f" (and {len(refused) - 1} more)" if len(refused) > 1 else ""
        raise ExchangeError(f"{file}: {refused[0]}{more}")
    said = tuple(f"left out: {reason}" for reason in refused)
    return [replace(table, remarks=(*table.remarks, *said)) for table in tables]


def together(tables: Sequence[Table]) -> list[Table]:
    """Tables with the same time stamps as one, called like the first of them."""
    found: list[list[Table]] = []
    for table in tables:
        same = next((group for group in found if _same_stamps(group[0], table)), None)
        if same is None:
            found.append([table])
        else:
            same.append(table)
    return [_beside(group) for group in found]


def _same_stamps(one: Table, other: Table) -> bool:
    if one.time_s is None or other.time_s is None:
        return False
    return np.array_equal(one.time_s, other.time_s)


def _beside(tables: Sequence[Table]) -> Table:
    count = Counter(channel.name for table in tables for channel in table.channels)
    channels = [
        channel
        if count[channel.name] == 1 or table.group == channel.name
        else replace(channel, name=f"{table.group}/{channel.name}")
        for table in tables
        for channel in table.channels
    ]
    values = np.column_stack([table.values for table in tables])
    return replace(tables[0], channels=tuple(channels), values=values)


def on_one_clock(tables: Sequence[Table]) -> list[Table]:
    """Tables of one rate whose starts are known, and whole steps apart, are one: each begins in its
    own row. The others stay as they are."""
    together: list[list[Table]] = []
    for table in tables:
        found = next((group for group in together if _steps(group[0], table) is not None), None)
        if found is None:
            together.append([table])
        else:
            found.append(table)
    return [_joined(group) for group in together]


def _steps(one: Table, other: Table) -> int | None:
    """By how many rows the other table begins later; None if it is on another clock."""
    if one.rate_hz is None or one.rate_hz != other.rate_hz:
        return None
    if one.time_s is not None or other.time_s is not None:
        return None
    if one.start_unix_s is None or other.start_unix_s is None:
        return None
    apart_s = other.start_unix_s - one.start_unix_s + other.start_s - one.start_s
    steps = apart_s * one.rate_hz
    whole = abs(steps - round(steps)) < TOGETHER and abs(steps) < LONGEST
    return round(steps) if whole else None


def _joined(tables: Sequence[Table]) -> Table:
    if len(tables) == 1:
        return tables[0]
    later = [_steps(tables[0], table) or 0 for table in tables]
    first = min(later)
    ends = [begin - first + len(t.values) for begin, t in zip(later, tables, strict=True)]
    count = Counter(channel.name for table in tables for channel in table.channels)
    values = np.full((max(ends), sum(len(table.channels) for table in tables)), np.nan)
    channels, at = [], 0
    for begin, table in zip(later, tables, strict=True):
        row, columns = begin - first, len(table.channels)
        values[row : row + len(table.values), at : at + columns] = table.values
        at += columns
        for channel in table.channels:
            name = channel.name if count[channel.name] == 1 else f"{table.group}/{channel.name}"
            channels.append(replace(channel, name=name))
    names = list(dict.fromkeys(table.group for table in tables))
    remarks = [f"groups on one clock: {', '.join(names)}"] if len(names) > 1 else []
    if any(later):
        starts = ", ".join(f"{steps - first}" for steps in later)
        remarks.append(f"they begin {starts} rows after the first: each in its own row")
    opening = tables[later.index(first)]
    return replace(
        opening,
        channels=tuple(channels),
        values=values,
        group=", ".join(names),
        remarks=(*dict.fromkeys(r for table in tables for r in table.remarks), *remarks),
    )
