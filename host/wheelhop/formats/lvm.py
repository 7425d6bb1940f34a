"""LabVIEW measurement files (.lvm), read by "Specification for the LabVIEW Measurement File", NI.

A file header, then segments: each a header of its own and rows of numbers. X is in one column, in
one column per channel, or not written at all.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import accumulate, pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.units import seconds_in
from wheelhop.formats import cells
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.grid import STRAY
from wheelhop.formats.groups import no_time
from wheelhop.formats.mapping import Map
from wheelhop.formats.table import Table, plain_channel

MAGIC = "LabVIEW Measurement"
END = "***End_of_Header***"
SPECIAL = ("***Start_Special***", "***End_Special***")
SEPARATOR = re.compile(r"separator(?P<mark>.)[ \t,;]*(?P<name>\w*)", re.IGNORECASE)
SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";", "space": " "}
X = "X_Value"
NO_TIMES = ("frequency", "length", "distance", "displacement", "position", "angle", "order")
"""Dimensions of X that are no time; of others the unit tells."""


@dataclass(frozen=True)
class _Style:
    """What the file header says of how the rest is written."""

    separator: str
    decimal: str
    tags: Mapping[str, list[str]]


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read the segments, as one recording if they follow each other in time."""
    text = cells.read_lines(path, mapping.encoding if mapping else "")
    lines = text.lines
    style, at = _file_header(lines, path)
    tables = []
    for number, (start, stop) in enumerate(_segments(lines, at, style), start=1):
        table = _segment(lines, start, stop, style, str(number), path)
        tables.append(replace(table, remarks=text.remarks))
    if mapping is not None and mapping.group:
        return tables
    return _joined(tables)


def _file_header(lines: list[str], path: Path) -> tuple[_Style, int]:
    if not lines[0].startswith(MAGIC):
        raise ExchangeError(f"{path}: line 1 must begin with {MAGIC}: this is no .lvm file")
    said = next(filter(None, map(SEPARATOR.match, lines)), None)
    separator = SEPARATORS.get(said["name"].lower(), said["mark"]) if said else "\t"
    tags, at = _tags(lines, 0, separator, path)
    decimal = tags.get("Decimal_Separator", ["."])[0] or "."
    return _Style(separator, decimal, tags), at


def _tags(
    lines: list[str], at: int, separator: str, path: Path
) -> tuple[dict[str, list[str]], int]:
    """The tags of a header that begins at line index `at`, and where it has ended."""
    tags: dict[str, list[str]] = {}
    inside = True
    for index in range(at, len(lines)):
        tag, *values = (cell.strip() for cell in lines[index].split(separator))
        if tag == END:
            return tags, index + 1
        if tag in SPECIAL:
            inside = tag != SPECIAL[0]
        elif inside and tag:
            tags[tag] = values
    raise ExchangeError(f"{path}: line {at + 1}: the header that begins here has no {END}")


def _segments(lines: list[str], at: int, style: _Style) -> Iterator[tuple[int, int]]:
    """First and last line index (exclusive) of each segment; blank lines lie between them."""
    starts, begins = [], at
    for k in range(at, len(lines)):
        if not lines[k].strip():
            begins = k + 1
        elif lines[k].split(style.separator)[0].strip() == END:
            starts.append(begins)
    return pairwise([*starts, len(lines)])


def _segment(
    lines: list[str], start: int, stop: int, style: _Style, group: str, path: Path
) -> Table:
    tags, at = _tags(lines, start, style.separator, path)
    if at >= stop:
        raise ExchangeError(f"{path}: line {at}: no columns are named behind this header")
    heads = [name.strip() for name in lines[at].split(style.separator)]
    width = max((k for k, head in enumerate(heads, 1) if head not in ("", "Comment")), default=0)
    names = [head or f"column {k}" for k, head in enumerate(heads[:width], start=1)]
    first = at + 1
    last = next(k for k in range(stop - 1, 0, -1) if lines[k].strip())
    body = [line.split(style.separator) for line in lines[first : last + 1]]

    def where(row: int) -> str:
        return f"{path}: line {first + row + 1}"

    for row, found in enumerate(body):
        if len(found) < len(names):
            raise ExchangeError(f"{where(row)} has {len(found)} values, not {len(names)}")

    def column(k: int) -> NDArray[np.float64]:
        return cells.parse([row[k] for row in body], style.decimal, where, names[k])

    def tag(key: str, k: int) -> str:
        """The entry of channel column k; segment headers have one cell per column behind X."""
        values = tags.get(key, [])
        return values[k - 1] if k - 1 < len(values) else ""

    size = _seconds(tags, f"{path}: line {start + 1}")
    x_kind = style.tags.get("X_Columns", ["One"])[0].lower()
    wanted = [k for k in range(1, len(names)) if names[k] != X]
    samples = {k: column(k) for k in wanted}
    wanted = [k for k in wanted if not np.isnan(samples[k]).all()]
    if not wanted:
        raise ExchangeError(
            f"{path}: line {start + 1}: the segment that begins here has no samples"
        )
    stamps = None
    if x_kind != "no":
        before = list(accumulate((k if name == X else 0 for k, name in enumerate(names)), max))
        stamps, *others = (column(k) for k in sorted({before[k - 1] for k in wanted}))
        if any(not np.array_equal(stamps, other) for other in others):
            raise ExchangeError(
                f"{path}: line {start + 1}: the channels of this segment were not sampled together"
            )
    step = _number(tag("Delta_X", wanted[0]), style)
    x0 = _number(tag("X0", wanted[0]), style)
    exact = step > 0.0 and (
        stamps is None
        or bool((np.abs(stamps - x0 - step * np.arange(len(body))) <= STRAY * step).all())
    )
    return Table(
        file=path,
        kind="LabVIEW measurement",
        channels=tuple(plain_channel(names[k], tag("Y_Unit_Label", k)) for k in wanted),
        values=np.column_stack([samples[k] for k in wanted]),
        # X is often printed with six decimals; Delta_X is exact.
        time_s=None if exact or stamps is None else size * stamps,
        rate_hz=1.0 / (size * step) if exact else None,
        start_s=size * x0,
        notes=_notes(style.tags, tags),
        group=group,
        lines=range(first + 1, first + 1 + len(body)),
    )


def _seconds(tags: Mapping[str, list[str]], place: str) -> float:
    """How long the unit of X is; raises `ExchangeError` where X is no time."""
    for tag in ("X_Unit_Label", "X_Dimension"):
        for said in filter(None, (value.strip() for value in tags.get(tag, []))):
            unit = "Hz" if said.lower().startswith("freq") else said
            wrong = said.lower() in NO_TIMES if tag == "X_Dimension" else seconds_in(said) is None
            if wrong:
                raise ExchangeError(f"{place}: its X is {said}, not time: {no_time(unit)}")
    units = [value.strip() for value in tags.get("X_Unit_Label", []) if value.strip()]
    return seconds_in(units[0]) or 1.0 if units else 1.0


def _number(text: str, style: _Style) -> float:
    """A number of a header, 0 if there is none."""
    text = text.replace(style.decimal, ".")
    value = float(text) if cells.is_number(text) else 0.0
    return value if abs(value) < 1e15 else 0.0


def _notes(*headers: Mapping[str, list[str]]) -> dict[str, str]:
    """What the headers say of the whole; a date without a time zone is no instant, but worth it."""
    tags = {key: value for header in headers for key, value in header.items()}
    kept = ("Operator", "Project", "Description", "Date", "Time")
    return {key.lower(): tags[key][0] for key in kept if key in tags and tags[key] and tags[key][0]}


def _joined(tables: list[Table]) -> list[Table]:
    """One table of segments with the same channels that follow each other in time, or all as is.

    X goes on from segment to segment, or begins anew and the headers' times tell the distance.
    """
    if len(tables) < 2 or len({(table.channels, table.rate_hz) for table in tables}) > 1:
        return tables
    stamps = [_stamps(table) for table in tables]
    if all(two[0] <= one[-1] for one, two in pairwise(stamps)):
        clocks = [_clock(table) for table in tables]
        if None in clocks:
            return tables
        since = [(clock - clocks[0]).total_seconds() for clock in clocks]  # type: ignore[operator]
        stamps = list(map(np.add, stamps, since))
    if any(two[0] <= one[-1] for one, two in pairwise(stamps)):
        return tables
    values = np.concatenate([table.values for table in tables])
    return [replace(tables[0], values=values, time_s=np.concatenate(stamps), lines=())]


def _stamps(table: Table) -> NDArray[np.float64]:
    if table.time_s is not None:
        return table.time_s
    if table.rate_hz is None:
        raise ExchangeError(
            f"{table.file}: has neither X nor Delta_X: give rate_hz and group in a mapping"
        )
    return table.start_s + np.arange(len(table.values)) / table.rate_hz


def _clock(table: Table) -> datetime | None:
    day, time = table.notes.get("date", ""), table.notes.get("time", "").replace(",", ".")
    try:
        return datetime.fromisoformat(f"{day.replace('/', '-')} {time[:15]}")
    except ValueError:
        return None
