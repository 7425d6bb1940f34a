"""A first mapping for a file, made from what it looks like; the user corrects it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from wheelhop.files import quoted
from wheelhop.files.units import SECONDS, to_si
from wheelhop.formats import cells
from wheelhop.formats.error import ExchangeError, guarded
from wheelhop.formats.labels import is_unit, name_and_unit
from wheelhop.formats.mapping import SEPARATORS
from wheelhop.formats.places import likely_points
from wheelhop.formats.registry import load
from wheelhop.formats.table import POINTS
from wheelhop.logger.recording import ACCELERATION

LOOK = 200  # lines that are looked at
STYLES = (
    (";", ","),
    ("\t", ","),
    (";", "."),
    ("\t", "."),
    (",", "."),
    ("|", "."),
    (None, "."),
    (None, ","),
)
"""Separator and decimal point, the ones that are hard to mistake first."""
TIMES = ("time", "time_s", "t", "timestamp", "zeit", "temps", "tiempo", "x_value", "date", "datum")


@dataclass(frozen=True)
class Layout:
    """How a text file is laid out; lines count from 1, 0: there is none."""

    separator: str | None
    decimal: str
    header_row: int
    units_row: int
    first_row: int
    labels: tuple[str, ...]
    units: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def draft_mapping(path: Path) -> str:
    """The text of a mapping file for `path`. Raises `ExchangeError` if no numbers are found."""
    if path.suffix.lower() not in (".csv", ".txt", ".tsv", ".dat", ".asc"):
        return _of_tables(path)
    with guarded(path, "be understood"):
        layout = _layout(path)
    clock, unit = _time(layout)
    keys = _keys(layout.labels)
    mark = {text: name for name, text in SEPARATORS.items() if name not in ("\t", " ")}
    lines = [
        f"separator = {quoted(mark[layout.separator])}",
        f"decimal = {quoted(layout.decimal)}",
        f"header_row = {layout.header_row}  # the line that names the columns, 0: none",
        f"units_row = {layout.units_row}  # the line with their units, 0: none",
        f"first_row = {layout.first_row}  # the line of the first numbers",
    ]
    if clock is None:
        lines.append("rate_hz = 100.0  # no column looks like time: say how many rows are a second")
    else:
        said = f"time_unit = {quoted(unit)}" if unit else 'time_unit = "s"  # not said: s, ms?'
        lines += [f"time = {keys[clock]}", said]
    columns: list[tuple[str, str, str]] = []
    for k, label in enumerate(layout.labels):
        if k == clock or not cells.is_number(layout.rows[0][k], layout.decimal):
            continue
        name, inside = name_and_unit(label)
        columns.append((keys[k], name, layout.units[k] if layout.units else inside))
    return _text(path, lines, columns)


def _layout(path: Path) -> Layout:
    lines = cells.read_lines(path)[:LOOK]
    found = _best(lines, narrowest=2) or _best(lines, narrowest=1)
    if found is None:
        raise ExchangeError(f"{path}: no columns of numbers are found in its first {LOOK} lines")
    return found


def _best(lines: Sequence[str], narrowest: int) -> Layout | None:
    """The layout in which most cells are numbers, of at least so many columns."""
    best: tuple[int, Layout] | None = None
    for separator, decimal in STYLES:
        if separator is None and best is not None:
            continue  # nearly every line has blanks in it
        rows = [cells.split_head(line, separator) for line in lines]
        numeric = [sum(_is_value(cell, decimal) for cell in row) for row in rows]
        begins = (
            k
            for k, n in enumerate(numeric)
            if n == max(numeric[k:]) and n > len(rows[k]) // 2 and len(rows[k]) >= narrowest
        )
        first = next(begins, None)
        if first is None:
            continue
        width = len(rows[first])
        body = [k for k in range(first, len(rows)) if len(rows[k]) == width]
        score = sum(numeric[k] for k in body)
        if score < len(lines) - first:
            continue  # prose with a number in it
        if best is None or score > best[0]:
            numbers = tuple(tuple(rows[k]) for k in body)
            layout = Layout(separator, decimal, 0, 0, first + 1, (), (), numbers)
            best = score, _labels(rows, first, width, layout)
    return None if best is None else best[1]


def _is_value(cell: str, decimal: str) -> bool:
    if cells.is_number(cell, decimal):
        return True
    try:
        cells.instant(cell.strip())
    except ValueError:
        return False
    return True


def _labels(rows: Sequence[Sequence[str]], first: int, width: int, layout: Layout) -> Layout:
    """Find names and units above the numbers: a row of units, if there is one, stands last."""
    above = [k for k in range(first) if len(rows[k]) == width and any(rows[k])]
    stripped = {k: tuple(cell.strip() for cell in rows[k]) for k in above}
    if above and any(is_unit(cell.strip("[]()")) for cell in stripped[above[-1]]):
        row = above.pop()
        units = tuple(cell.strip("[]()") for cell in stripped[row])
        layout = replace(layout, units_row=row + 1, units=units)
    labels = stripped[above[-1]] if above else ("",) * width
    named = tuple(label or f"column {k}" for k, label in enumerate(labels, start=1))
    return replace(layout, header_row=above[-1] + 1 if above else 0, labels=named)


def _time(layout: Layout) -> tuple[int | None, str]:
    """Which column is time, and in what unit the file says, known or not: by its name, or the first
    that rises evenly and is in no other unit than one of time."""
    inside = [name_and_unit(label) for label in layout.labels]
    units = layout.units or tuple(unit for _, unit in inside)
    for k, (name, _) in enumerate(inside):
        if name.lower().split("_")[0] in TIMES or name.lower() in TIMES:
            if not cells.is_number(layout.rows[0][k], layout.decimal):
                return k, "clock"
            return k, units[k]
    for k in (k for k, unit in enumerate(units) if not unit or unit in SECONDS):
        column = [row[k].replace(layout.decimal, ".") for row in layout.rows]
        if all(map(cells.is_number, column)) and len(column) > 2:
            steps = np.diff([float(cell) for cell in column])
            if steps.max() < 1.01 * steps.min():
                return k, units[k]
    return None, ""


def _of_tables(path: Path) -> str:
    lines: list[str] = []
    columns: list[tuple[str, str, str]] = []
    tables = load(path)
    if not tables:
        raise ExchangeError(f"{path}: holds no channels of numbers")
    table = tables[0]
    if len(tables) > 1:
        names = ", ".join(quoted(table.group) for table in tables)
        lines.append(f"group = {quoted(table.group)}  # one of {names}")
    if table.time_s is None and table.rate_hz is None:
        lines.append("rate_hz = 100.0  # the file has no time: say how many samples are a second")
    count = Counter(channel.name for channel in table.channels)
    for number, channel in zip(table.columns, table.channels, strict=True):
        key = quoted(channel.name) if count[channel.name] == 1 else str(number)
        columns.append((key, channel.name, channel.unit))
    return _text(path, lines, columns)


def _keys(labels: Sequence[str]) -> list[str]:
    """How a mapping names each column: by its label, or by number where the label will not do."""
    count = Counter(labels)
    return [
        str(k) if label == f"column {k}" or count[label] > 1 else quoted(label)
        for k, label in enumerate(labels, start=1)
    ]


def _entries(columns: Sequence[tuple[str, str, str]]) -> Iterator[str]:
    """The lines of every channel: how a mapping names it, its own name, and its unit."""
    felt = [k for k, column in enumerate(columns) if to_si(column[2])[0] in ("", ACCELERATION)]
    guessed = dict(zip(felt, likely_points([columns[k][1] for k in felt]), strict=True))
    for k, (key, name, unit) in enumerate(columns):
        si, factor = to_si(unit)
        scaled = f"  # × {factor:g} = {si}" if factor != 1.0 else ""
        scaled = scaled if is_unit(unit) else "  # not known here: it stays as it is"
        point = name if name in POINTS else guessed.get(k, "")
        yield from (
            "",
            "[[channel]]",
            f"column = {key}",
            f"name = {quoted(name)}",
            f"unit = {quoted(unit)}{scaled if unit else '  # not said: g, m/s²?'}",
            f"point = {quoted(point)}{'' if point in ('', name) else '  # by its name: is it so?'}",
        )


def _text(path: Path, lines: Sequence[str], columns: Sequence[tuple[str, str, str]]) -> str:
    head = [
        f"# How to read {path.name}, guessed from its look: correct it, then",
        f"#     wheelhop import --map THIS.toml {path.name}",
        "# Delete the channels that are not wanted. point is A1 … A4 (axles), B1 … B4 or body.",
        "# A channel is column × scale + offset, in unit: add scale = … and offset = … as needed.",
        "format = 1",
    ]
    return "\n".join([*head, *lines, *_entries(columns)]) + "\n"
