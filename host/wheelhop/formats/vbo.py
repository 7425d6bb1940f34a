"""Racelogic's VBOX .vbo, a text in sections, for reading.

The sections are those of Racelogic's "VBO file format": [header] names the channels, most with
their units, [column names] gives each a word, [channel units] has units of the last channels,
[data] has a row a sample. Time is hours, minutes and seconds in one number, UTC.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from wheelhop.formats import cells
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.labels import is_unit
from wheelhop.formats.mapping import Map
from wheelhop.formats.stamps import DIGITS, of_numbers
from wheelhop.formats.table import Table, plain_channel

SECTION = re.compile(r"\[(?P<name>[^]]+)\]\s*$")
CREATED = re.compile(r"File created on (.*\S)")
TIME = "time"
OWN = frozenset(
    (
        *(
            "sats",
            "time",
            "lat",
            "long",
            "velocity",
            "heading",
            "height",
            "vertvel",
            "vertvelocity",
        ),
        *("tsample", "solutiontype", "avifileindex", "avitime", "avisynctime", "glonasssats"),
        *("gpssats", "glonass", "event", "trig", "triggereventtime"),
    )
)
"""Columns of the instrument itself, without blanks, case, - and _; it says units of the others."""
NO_UNIT = frozenset(("", "(null)", "null", "-"))


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read the rows of [data]. Raises `ExchangeError` for a file without names, rows or time."""
    text = cells.read_lines(path, mapping.encoding if mapping else "")
    parts, first = _sections(text.lines)
    names = " ".join(parts.get("column names", ())).split()
    long = [line.strip() for line in parts.get("header", ()) if line.strip()]
    rows = parts.get("data", ())
    if not (names or long) or not rows:
        raise ExchangeError(f"{path}: has no section [{'data' if not rows else 'column names'}]")
    names = names or ["_".join(name.split()) for name in long]
    said = "\n".join(parts.get("channel units", ())).rstrip().split("\n")
    units = _units(names, long, [unit.strip() for unit in said])
    numbers = [first + k for k, row in enumerate(rows) if row.strip()]
    body = [row.split() for row in rows if row.strip()]

    def where(row: int) -> str:
        return f"{path}: line {numbers[row]}"

    for row, found in enumerate(body):
        if len(found) != len(names):
            raise ExchangeError(f"{where(row)} has {len(found)} values, not {len(names)}")
    decimal = "," if any("," in cell for cell in body[0]) else "."
    columns = [
        cells.parse([row[k] for row in body], decimal, where, name) for k, name in enumerate(names)
    ]
    if TIME not in names:
        raise ExchangeError(f"{path}: has no column {TIME} among {', '.join(names)}")
    clock = names.index(TIME)
    wanted = [k for k in range(len(names)) if k != clock]
    stamps = of_numbers(columns[clock], DIGITS, where, None)
    created = CREATED.match(text.lines[0])
    return [
        Table(
            file=path,
            kind="VBOX",
            channels=tuple(plain_channel(names[k], units[k]) for k in wanted),
            values=np.column_stack([columns[k] for k in wanted]),
            time_s=stamps.time_s,
            notes={"created": created[1]} if created else {},  # by another clock than time's
            numbers=tuple(k + 1 for k in wanted),
            lines=numbers,
            remarks=(*text.remarks, *stamps.remarks),
        )
    ]


def _sections(lines: Sequence[str]) -> tuple[dict[str, Sequence[str]], int]:
    """The lines of each section by its name, and the number of the first line of [data]."""
    starts = [(k, m["name"].strip().lower()) for k, m in enumerate(map(SECTION.match, lines)) if m]
    ends = [k for k, _ in starts[1:]] + [len(lines)]
    parts = {name: lines[k + 1 : end] for (k, name), end in zip(starts, ends, strict=True)}
    return parts, next((k + 2 for k, name in starts if name == "data"), 0)


def _units(names: Sequence[str], long: Sequence[str], said: Sequence[str]) -> list[str]:
    """A unit for each column: the last word of its long name, or what is `said` of all columns, or
    of those that are not the instrument's own; "" where neither tells."""
    units = [""] * len(names)
    if len(long) == len(names):
        for k, name in enumerate(long):
            word = name.split()[-1]
            units[k] = word if len(name.split()) > 1 and is_unit(word) else ""
    added = [k for k, name in enumerate(names) if re.sub(r"[-_]", "", name.lower()) not in OWN]
    for columns in (range(len(names)), added):
        if len(columns) == len(said):  # with a blank among them nobody knows whose they are
            for k, unit in zip(columns, said, strict=True):
                units[k] = units[k] if unit.lower() in NO_UNIT else unit
            break
    return units
