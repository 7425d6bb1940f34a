"""Free-form text in columns, read as a mapping says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.units import SECONDS
from wheelhop.formats import cells
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.labels import name_and_unit
from wheelhop.formats.mapping import CLOCK, Map
from wheelhop.formats.table import Table, plain_channel


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read a text file as `mapping` says; raises `ExchangeError` without one."""
    if mapping is None:
        raise ExchangeError(
            f"{path}: what its columns are must be said in a mapping: "
            f"wheelhop import {path.name} --draft proposes one"
        )
    lines = cells.read_lines(path, mapping.encoding)
    first = mapping.first
    if len(lines) < first:
        raise ExchangeError(f"{path}: has {len(lines)} lines, the numbers begin at {first}")

    def where(row: int) -> str:
        return f"{path}: line {row + first}"

    body = cells.split(lines[first - 1 :], mapping.separator)
    names, units = _labels(lines, mapping, len(body[0]))
    width = len(names)
    for row, found in enumerate(body):
        if len(found) != width and not (len(found) == width + 1 and not found[-1].strip()):
            raise ExchangeError(f"{where(row)} has {len(found)} values, not {width}")

    def column(k: int) -> list[str]:
        return [row[k] for row in body]

    clock = _find(names, mapping.time, path)
    wanted = [k for k in _wanted(names, mapping, body[0], path) if k != clock]
    if not wanted:
        raise ExchangeError(f"{path}: has no columns of numbers beside time: {', '.join(names)}")
    parsed = [cells.parse(column(k), mapping.decimal, where, names[k]) for k in wanted]
    start_unix_s, time_s = None, None
    if clock is not None and mapping.time_unit == CLOCK:
        time_s, start_unix_s = _clock(column(clock), path, first)
    elif clock is not None:
        stamps = cells.parse(column(clock), mapping.decimal, where, names[clock])
        time_s = stamps * SECONDS[mapping.time_unit]
    return [
        Table(
            file=path,
            kind="text",
            channels=tuple(plain_channel(names[k], units[k]) for k in wanted),
            values=np.column_stack(parsed),
            time_s=time_s,
            start_unix_s=start_unix_s,
            line=first,
            numbers=tuple(k + 1 for k in wanted),
        )
    ]


def _wanted(names: list[str], mapping: Map, first: list[str], path: Path) -> list[int]:
    """The columns that the mapping picks, or else all that begin with a number."""
    picked = {pick.column for pick in mapping.picks}
    known = set(names)
    for column in picked:
        if column not in known:
            _find(names, column, path)
    if picked:
        return [k for k, name in enumerate(names) if name in picked or k + 1 in picked]
    return [k for k in range(len(names)) if cells.is_number(first[k], mapping.decimal)]


def _labels(lines: list[str], mapping: Map, width: int) -> tuple[list[str], list[str]]:
    """Names and units of the columns; a unit may stand behind the name: "Acc [g]"."""

    def row(number: int) -> list[str]:
        if not number:
            return []
        return [cell.strip() for cell in cells.split_head(lines[number - 1], mapping.separator)]

    heads = row(mapping.header_row)
    if heads and heads[-1] == "":
        heads.pop()  # a separator at the end of every line
    if not heads:
        heads = [""] * width
    names = [head or f"column {k}" for k, head in enumerate(heads, start=1)]
    units = [unit.strip("[]()") for unit in row(mapping.units_row)]
    inside = [name_and_unit(name)[1] for name in names]
    units += inside[len(units) :]
    return names, units


def _find(names: list[str], column: str | int, path: Path) -> int | None:
    if column == "":
        return None
    if isinstance(column, int) and 1 <= column <= len(names):
        return column - 1
    if isinstance(column, str) and column in names:
        return names.index(column)
    raise ExchangeError(f"{path}: there is no column {column!r}; it has {', '.join(names)}")


def _clock(stamps: list[str], path: Path, first: int) -> tuple[NDArray[np.float64], float | None]:
    """Seconds since the first stamp, and its Unix time if the stamps say their time zone."""
    found = []
    for row, stamp in enumerate(stamps):
        try:
            found.append(cells.instant(stamp.strip()))
        except ValueError:
            raise ExchangeError(
                f"{path}: line {row + first}: '{stamp[:40]}' is no time: write "
                "2026-05-01 12:34:56.789 or 12:34:56.789"
            ) from None
    start = found[0]
    zoned = start.tzinfo is not None
    if any((instant.tzinfo is not None) != zoned for instant in found):
        raise ExchangeError(f"{path}: only some of the times have a time zone")
    seconds = [(instant - start).total_seconds() for instant in found]
    dated = start.date() != cells.NO_DATE
    return np.array(seconds), start.timestamp() if zoned and dated else None
