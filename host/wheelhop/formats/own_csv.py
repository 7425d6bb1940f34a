"""CSV as campaigns have it: line 1 names the columns, `time_s` first; all else is in a sidecar."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.units import to_si
from wheelhop.formats import cells, text
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.header import read_sidecar, sidecar
from wheelhop.formats.labels import name_and_unit
from wheelhop.formats.mapping import Map
from wheelhop.formats.table import Table, campaign_channel
from wheelhop.logger.recording import Recording

TIME = "time_s"
STAMP_DIGITS = 9  # nanoseconds
CHUNK = 4096  # rows


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read a CSV of ours; any other is text that needs a mapping."""
    names = cells.names_in(cells.first_lines(path)[0])
    header = read_sidecar(path)
    ours = TIME in names and (mapping is None or header is not None)
    if not ours:
        return text.load(path, mapping)
    read = cells.read_lines(path)
    lines = read.lines
    if len(set(names)) != len(names):
        raise ExchangeError(f"{path}: line 1: a column name appears twice")
    numbers = _parse(lines[1:], names, path)
    clock = names.index(TIME)
    del names[clock]
    channels = tuple(campaign_channel(name, _unit(name)) for name in names)
    if header is not None:
        channels = header.bare.channels
        if [channel.name for channel in channels] != names:
            raise ExchangeError(
                f"{sidecar(path)}: does not describe the columns of {path.name}: "
                "correct or delete it"
            )
    values = np.delete(numbers, clock, axis=1)
    where = range(2, 2 + len(values))
    own = Table(
        path, "CSV", channels, values, numbers[:, clock], header=header, lines=where, own=True
    )
    return [replace(own, remarks=read.remarks)]


def is_ours(path: Path) -> bool:
    """Whether a CSV is one of ours: it has a header beside it, or else a column of time under our
    name, names that say no other unit than an SI one, and numbers right below."""
    names, *below = map(cells.names_in, cells.first_lines(path))
    if TIME not in names or sidecar(path).exists():
        return TIME in names
    units = [name_and_unit(name)[1] for name in names]
    known = all(not unit or to_si(unit) == (unit, 1.0) for unit in units if unit != "s")
    return known and all(
        cell.lower() in cells.EMPTY or cells.is_number(cell) for row in below for cell in row
    )


def _parse(body: list[str], names: list[str], path: Path) -> NDArray[np.float64]:
    """(n, c) the numbers of all columns; piece by piece, for text takes much memory."""
    numbers = np.empty((len(body), len(names)))
    for start in range(0, len(body), CHUNK):
        rows = cells.split(body[start : start + CHUNK], ",")

        def where(row: int, start: int = start) -> str:
            return f"{path}: line {start + row + 2}"

        for row, found in enumerate(rows):
            if len(found) != len(names):
                raise ExchangeError(
                    f"{where(row)} has {len(found)} values, line 1 names {len(names)} columns"
                )
        for k, name in enumerate(names):
            column = cells.parse([row[k] for row in rows], ".", where, name)
            numbers[start : start + CHUNK, k] = column
    return numbers


def _unit(name: str) -> str:
    """The unit that a name carries (force_N), if it is SI: a name must not belie its numbers."""
    unit = name_and_unit(name)[1]
    return unit if to_si(unit) == (unit, 1.0) else ""


def save(recording: Recording, path: Path) -> None:
    """Write names and numbers, so that every number reads back to the same bits."""
    for channel in recording.channels:
        _check_name(channel.name, path)
    table = np.column_stack([np.round(recording.time_s, STAMP_DIGITS), recording.values])
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(",".join([TIME, *(channel.name for channel in recording.channels)]) + "\n")
        file.writelines(_lines(table))


def _lines(table: NDArray[np.float64]) -> Iterator[str]:
    for start in range(0, len(table), CHUNK):
        for row in table[start : start + CHUNK].tolist():
            yield ",".join(map(repr, row)) + "\n"


def _check_name(name: str, path: Path) -> None:
    plain = name.isprintable() and name == name.strip() and not set(name) & set(',"')
    if not plain or name == TIME:
        raise ExchangeError(
            f"{path}: a column of CSV cannot be called '{name}': choose another format, "
            "or rename the channel"
        )


def losses(recording: Recording) -> tuple[str, ...]:
    """Nothing, as long as the sidecar stays beside the file."""
    return ()
