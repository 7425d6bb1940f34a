"""Free-form text in columns, read as a mapping says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.units import SECONDS, seconds_in
from wheelhop.formats import cells
from wheelhop.formats.bulk import parse_body, plain_body
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.labels import bare_unit, joined_heads, name_and_unit
from wheelhop.formats.long_form import split
from wheelhop.formats.mapping import Map
from wheelhop.formats.names import words_in
from wheelhop.formats.stamps import CLOCK, MINUTES, UNITS, Stamps, of_numbers, of_texts
from wheelhop.formats.table import Table, plain_channel
from wheelhop.formats.timing import unit_of_numbers


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read a text file as `mapping` says; raises `ExchangeError` without one."""
    if mapping is None:
        raise ExchangeError(
            f"{path}: what its columns are must be said in a mapping: "
            f"wheelhop import {path.name} --draft proposes one"
        )
    if mapping.by == "" and (table := _in_bulk(path, mapping)) is not None:
        return [table]
    table, words = _line_by_line(path, mapping)
    return split(table, words) if words else [table]


def _line_by_line(path: Path, mapping: Map) -> tuple[Table, list[str]]:
    """The table of any text, and the words that say which channel each row is of; raises
    `ExchangeError` that says which line is wrong."""
    text = cells.read_lines(path, mapping.encoding)
    lines, first = text.lines, mapping.first
    if len(lines) < first:
        raise ExchangeError(f"{path}: has {len(lines)} lines, the numbers begin at {first}")
    numbers, body, dropped = _body(lines, mapping, path)

    def where(row: int) -> str:
        return f"{path}: line {numbers[row]}"

    names, units = _labels(lines, mapping, len(body[0]))
    width = len(names)
    for row, found in enumerate(body):
        if len(found) != width and not (len(found) == width + 1 and not found[-1].strip()):
            below = "" if row < len(body) - 1 else f": last_row = {numbers[row] - 1} leaves it out"
            raise ExchangeError(f"{where(row)} has {len(found)} values, not {width}{below}")
    clock = _find(names, mapping.time, path)
    if clock is not None:  # a row without any value is none: its time is not known
        kept = [k for k, row in enumerate(body) if any(cell.strip() for cell in row)]
        numbers, body = [numbers[k] for k in kept], [body[k] for k in kept]
    if not body:
        raise ExchangeError(f"{path}: holds no samples: all its rows are empty")

    def column(k: int) -> list[str]:
        return [row[k] for row in body]

    def parsed(k: int) -> NDArray[np.float64]:
        return cells.parse(column(k), mapping.decimal, where, names[k], mapping.thousands)

    by = _find(names, mapping.by, path)
    words = column(by) if by is not None else []
    picked = mapping if by is None else replace(mapping, picks=())  # they mean the words
    wanted = [k for k in _wanted(names, picked, body, path) if k not in (clock, by)]
    if not wanted:
        raise ExchangeError(f"{path}: has no columns of numbers beside time: {', '.join(names)}")
    table = Table(
        file=path,
        kind="text",
        channels=tuple(plain_channel(names[k], units[k]) for k in wanted),
        values=np.column_stack([parsed(k) for k in wanted]),
        numbers=tuple(k + 1 for k in wanted),
        lines=numbers,
        remarks=(*text.remarks, *dropped),
    )
    if clock is None:
        return table, words
    if _are_numbers(column(clock), mapping):
        return _timed(table, names[clock], units[clock], parsed(clock), mapping), words
    return _dated(table, column(clock), mapping), words


def _in_bulk(path: Path, mapping: Map) -> Table | None:
    """The table of a large plain text; None if it is not plain."""
    body = plain_body(path, mapping)
    if body is None:
        return None
    stop = mapping.first - 1 + body.count
    first = cells.split(body.head[mapping.first - 1 : stop], mapping.separator)
    names, units = _labels(body.head, mapping, len(first[0]))
    clock = _find(names, mapping.time, path)
    widths = {len(row) for row in first}
    if widths not in ({len(names)}, {len(names) + 1}):
        return None
    wanted = [k for k in _wanted(names, mapping, first, path) if k != clock]
    known = mapping.picks or all(
        any(row[k].strip().lower() not in cells.EMPTY for row in first) for k in range(len(names))
    )
    if not wanted or not known:
        return None
    numeric = clock is not None and _are_numbers([row[clock] for row in first], mapping)
    timed = [clock] if clock is not None else []
    found = parse_body(
        body,
        mapping,
        widths.pop(),
        [*wanted, *(timed if numeric else [])],
        [] if numeric else timed,
    )
    if found is None or (numeric and np.isnan(found[0][:, -1]).any()):
        return None
    values, texts = found
    table = Table(
        file=path,
        kind="text",
        channels=tuple(plain_channel(names[k], units[k]) for k in wanted),
        values=values[:, : len(wanted)],
        numbers=tuple(k + 1 for k in wanted),
        lines=range(body.first, body.first + body.count),
        remarks=(f"lines from {mapping.last_row + 1} on, below the table: left out",)
        if body.cut
        else (),
        spare=True,
    )
    if clock is None:
        return table
    if numeric:
        return _timed(table, names[clock], units[clock], values[:, -1], mapping)
    return _dated(table, texts[0], mapping)


def _body(
    lines: Sequence[str], mapping: Map, path: Path
) -> tuple[Sequence[int], list[list[str]], list[str]]:
    """The numbers of the lines that are rows, their cells, and what was left out between them:
    lines that are blank or remarks, and names that are repeated."""
    last = min(mapping.last_row or len(lines), len(lines))
    above = {lines[k - 1].strip() for k in (*mapping.header_rows, mapping.units_row) if k}
    numbers: Sequence[int] = range(mapping.first, last + 1)
    remarks, repeated, said = [], [], []
    if mapping.last_row and mapping.last_row < len(lines):
        said.append(f"lines from {mapping.last_row + 1} on, below the table: left out")
    for number in numbers:
        line = lines[number - 1].strip()
        if line in above and line:
            repeated.append(number)
        elif cells.is_remark(line, mapping.separator):
            remarks.append(number)
    skipped = {*remarks, *repeated}
    if skipped or any(not lines[number - 1].strip() for number in numbers):
        numbers = [n for n in numbers if n not in skipped and lines[n - 1].strip()]
    for what, found in (("a remark", remarks), ("names repeated", repeated)):
        if found:
            more = f" and {len(found) - 1} more" if len(found) > 1 else ""
            said.append(f"line {found[0]}{more}: {what}; left out")
    if not numbers:
        raise ExchangeError(f"{path}: has no rows from line {mapping.first} on")
    return numbers, cells.split([lines[n - 1] for n in numbers], mapping.separator), said


def _are_numbers(texts: Sequence[str], mapping: Map) -> bool:
    """Whether time stamps are numbers, as the mapping says, or else as the first of them is."""
    if mapping.time_unit:
        return mapping.time_unit not in (CLOCK, MINUTES)
    return cells.is_number(next((cell for cell in texts if cell.strip()), ""), mapping.decimal)


def _timed(table: Table, name: str, unit: str, values: NDArray[np.float64], mapping: Map) -> Table:
    """The table with stamps that are numbers, in the unit that the mapping says, or else the
    file."""
    said, rate_hz = mapping.time_unit, mapping.rate_hz
    if np.isnan(values).any():
        raise ExchangeError(f"{table.where(int(np.argmax(np.isnan(values))))}: {name}: has no time")
    if not said:
        said, asked = unit_of_numbers(name, unit, values)
        if asked and not rate_hz:
            raise ExchangeError(
                f"{table.where(0)}: {asked}: say time_unit in the mapping: {', '.join(UNITS)}"
            )
        said = said or "s"
    stamps = of_numbers(values, said, table.where, rate_hz)
    told, remarks = seconds_in(unit), stamps.remarks
    if stamps.start_unix_s is not None and "gps" in words_in(name):
        stamps = replace(stamps, start_unix_s=None)
        remarks = (f"{name} may count since 1980, as GPS does: its start is not known", *remarks)
    if told is not None and said in SECONDS and told != SECONDS[said]:
        remarks = (f"{name}: the file says {unit}, the mapping {said}", *remarks)
    return _with(table, replace(stamps, remarks=remarks))


def _dated(table: Table, texts: Sequence[str], mapping: Map) -> Table:
    """The table with stamps that are dates or times of day."""
    return _with(table, of_texts(texts, mapping.time_unit or CLOCK, table.where))


def _with(table: Table, stamps: Stamps) -> Table:
    remarks = (*table.remarks, *stamps.remarks)
    return replace(table, time_s=stamps.time_s, start_unix_s=stamps.start_unix_s, remarks=remarks)


def _wanted(names: list[str], mapping: Map, body: Sequence[Sequence[str]], path: Path) -> list[int]:
    """The columns that the mapping picks, or else all whose first value is a number."""
    picked = {pick.column for pick in mapping.picks}
    known = set(names)
    for column in picked:
        if column not in known:
            _find(names, column, path)
    if picked:
        return [k for k, name in enumerate(names) if name in picked or k + 1 in picked]
    firsts = (
        next((row[k] for row in body if row[k].strip().lower() not in cells.EMPTY), "")
        for k in range(len(names))
    )
    return [k for k, first in enumerate(firsts) if cells.is_number(first, mapping.decimal)]


def _labels(lines: Sequence[str], mapping: Map, width: int) -> tuple[list[str], list[str]]:
    """Names and units of the columns; a unit may stand behind the name: "Acc [g]"."""

    def row(number: int) -> list[str]:
        return [cell.strip() for cell in cells.split_head(lines[number - 1], mapping.separator)]

    heads = joined_heads([row(number) for number in mapping.header_rows])
    if heads and heads[-1] == "":
        heads.pop()  # a separator at the end of every line
    if not heads:
        heads = [""] * width
    names = [head or f"column {k}" for k, head in enumerate(heads, start=1)]
    below = [bare_unit(unit) for unit in row(mapping.units_row)] if mapping.units_row else []
    inside = [name_and_unit(name)[1] for name in names]
    units = [
        unit or other for unit, other in zip_longest(below[: len(names)], inside, fillvalue="")
    ]
    return names, units


def _find(names: list[str], column: str | int, path: Path) -> int | None:
    if column == "":
        return None
    if isinstance(column, int) and 1 <= column <= len(names):
        return column - 1
    if isinstance(column, str) and column in names:
        if names.count(column) > 1:
            raise ExchangeError(
                f'{path}: several columns are called "{column}": give their numbers'
            )
        return names.index(column)
    raise ExchangeError(f"{path}: there is no column {column!r}; it has {', '.join(names)}")
