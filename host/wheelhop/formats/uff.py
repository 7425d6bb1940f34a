"""Universal file format, dataset 58 (function at a nodal degree of freedom), through pyuff.

UFF has no sign for a missing sample: every piece between two gaps is a function of its own, with
its own start, and a gap is what no function covers. Numbers are written in binary (58b), exact.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import TABLE, check_room
from wheelhop.files.units import seconds_in
from wheelhop.formats.error import ExchangeError, need
from wheelhop.formats.grid import fit_grid, too_few
from wheelhop.formats.header import Header, read_sidecar, sidecar
from wheelhop.formats.mapping import Map
from wheelhop.formats.table import POINTS, Table
from wheelhop.logger.recording import ACCELERATION, Channel, Recording

TIME_RESPONSE, EVEN, SI_UNITS = 1, 1, 1
PLUS_Z = 3
DIRECTIONS = {
    **{k: f"+{'XYZ'[k - 1]}" for k in (1, 2, 3)},
    **{-k: f"-{'XYZ'[k - 1]}" for k in (1, 2, 3)},
}
KINDS = {"m": 8, ACCELERATION: 12, "m/s": 11, "N": 13}
"""Specific data types of record 9."""
Key = tuple[str | int | None, ...]
PLACE = re.compile(r"samples from (\d+) of (\d+)")


@dataclass(frozen=True, eq=False)
class _Piece:
    """One function: whose it is, where its first sample lies (in rows too, if we wrote it), and its
    samples. Functions with the same `key` are pieces of one channel."""

    key: Key
    channel: Channel
    start_s: float
    rate_hz: float
    values: NDArray[np.float64]
    row: int | None = None

    @property
    def begins(self) -> float:
        """In rows; starts in six digits would be too coarse after some minutes."""
        return self.start_s * self.rate_hz if self.row is None else self.row


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read the functions of time; those that overlap in time are groups of their own."""
    pyuff = need("pyuff", "uff", path)
    size = path.stat().st_size
    check_room(path, TABLE * size, ExchangeError)
    sets = pyuff.UFF(str(path)).read_sets() if size else []
    sets = sets if isinstance(sets, list) else [sets]
    metric = any(item.get("units_code") == SI_UNITS for item in sets)
    header = read_sidecar(path)
    groups: list[dict[Key, list[_Piece]]] = []
    for number, item in enumerate(sets, start=1):
        if item.get("type") == 58 and item["func_type"] in (0, TIME_RESPONSE):
            _sort_in(groups, _piece(item, number, metric, path))
    tables = [_table(group, header, str(k), path) for k, group in enumerate(groups, start=1)]
    if header is None:
        return tables
    names = [_ascii(channel.name, 80) for channel in header.bare.channels]
    if len(tables) != 1 or [channel.name for channel in tables[0].channels] != names:
        raise ExchangeError(
            f"{sidecar(path)}: does not describe the functions of {path.name}: correct or delete it"
        )
    return [replace(tables[0], channels=header.bare.channels)]


def _piece(item: dict[str, Any], number: int, metric: bool, path: Path) -> _Piece:
    place = f"{path}: dataset {number}"
    values = np.asarray(item["data"])
    if np.iscomplexobj(values):
        raise ExchangeError(f"{place}: its values are complex, a recording's are not")
    if len(values) < item["num_pts"] or item["num_pts"] < 1:
        raise ExchangeError(f"{place}: holds {len(values)} of {item['num_pts']} samples")
    values = values[: item["num_pts"]].astype(np.float64)
    found = PLACE.fullmatch(item["id2"])
    channel = _channel(item, metric, named=found is not None)
    key = (channel.name, item["rsp_node"], item["rsp_dir"], item["func_id"] if found else None)
    seconds = _seconds(item.get("abscissa_axis_units_lab", ""), place)
    if item["abscissa_spacing"] != EVEN:
        grid = fit_grid(seconds * np.asarray(item["x"]), lambda row: f"{place}: sample {row + 1}")
        spread = grid.spread(values[:, np.newaxis])[:, 0]
        return _Piece(key, channel, grid.start_s, grid.rate_hz, spread)
    start, step = seconds * item["abscissa_min"], seconds * item["abscissa_inc"]
    if not (abs(start) < 1e15 and 0.0 < step < 1e15):
        raise ExchangeError(f"{place}: time from {start:g} s in steps of {step:g} s is no time")
    return _Piece(key, channel, start, _rate(step), values, int(found[1]) if found else None)


def _seconds(unit: str, place: str) -> float:
    """How long a unit of the abscissa is; without one it is in seconds, which are SI."""
    if unit in ("", "NONE"):
        return 1.0
    if (seconds := seconds_in(unit)) is None:
        raise ExchangeError(f"{place}: its abscissa is in {unit}, no unit of time that is known")
    return seconds


def _rate(step_s: float) -> float:
    """The roundest rate whose period is this one in the six digits that a file has."""
    for digits in range(18):
        rate = float(f"{1 / step_s:.{digits}g}")
        if f"{1 / rate:.5e}" == f"{step_s:.5e}":
            break
    return rate


def _channel(item: dict[str, Any], metric: bool, named: bool) -> Channel:
    """The channel of a function, `named` by its first line, or by its node as is the custom."""
    entity, label = item["rsp_ent_name"], item["id1"]
    node = f"{item['rsp_node']}{DIRECTIONS.get(item['rsp_dir'], '')}"
    name = label if named or (not item["rsp_node"] and label not in ("", "NONE")) else node
    unit = item["ordinate_axis_units_lab"]
    if unit in ("", "NONE"):
        known = {code: unit for unit, code in KINDS.items()}
        unit = known.get(item["ordinate_spec_data_type"], "") if metric else ""
    point = entity if entity in POINTS else ""
    return Channel(name, unit, point)


def _sort_in(groups: list[dict[Key, list[_Piece]]], piece: _Piece) -> None:
    """Put a piece into the first group of its rate in which its channel is still free then."""
    for group in groups:
        of_channel = group.get(piece.key, [])
        rate_hz = next(iter(group.values()))[0].rate_hz
        if rate_hz == piece.rate_hz and not any(_overlap(other, piece) for other in of_channel):
            group.setdefault(piece.key, []).append(piece)
            return
    groups.append({piece.key: [piece]})


def _overlap(one: _Piece, other: _Piece) -> bool:
    first, second = sorted((one, other), key=lambda piece: piece.begins)
    return second.begins < first.begins + len(first.values) - 0.5


def _table(found: dict[Key, list[_Piece]], header: Header | None, group: str, path: Path) -> Table:
    pieces = [piece for of_channel in found.values() for piece in of_channel]
    rate, start_s = pieces[0].rate_hz, min(piece.start_s for piece in pieces)
    rows = _rows(pieces, start_s, whole=header is not None)
    count = max(row + len(piece.values) for row, piece in zip(rows, pieces, strict=True))
    if header is not None:
        count = max(count, header.rows)
        rate, start_s = header.bare.rate_hz, header.bare.start_s
    held = sum(len(piece.values) for piece in pieces)
    if too_few(held, count):
        raise ExchangeError(f"{path}: {count} samples are due, and {held} are there")
    columns = {key: k for k, key in enumerate(found)}
    values = np.full((count, len(columns)), np.nan)
    for row, piece in zip(rows, pieces, strict=True):
        values[row : row + len(piece.values), columns[piece.key]] = piece.values
    return Table(
        file=path,
        kind="UFF 58",
        channels=tuple(of_channel[-1].channel for of_channel in found.values()),
        values=values,
        rate_hz=rate,
        start_s=start_s,
        group=group,
        header=header,
    )


def _rows(pieces: list[_Piece], start_s: float, whole: bool) -> list[int]:
    """Where pieces begin: in the `whole` recording if we wrote them, else from their start."""
    known = [piece.row for piece in pieces if piece.row is not None]
    if len(known) < len(pieces):
        return [round((piece.start_s - start_s) * piece.rate_hz) for piece in pieces]
    return known if whole else [row - min(known) for row in known]


def save(recording: Recording, path: Path) -> None:
    """Write a function for each channel and each piece without gaps."""
    pyuff = need("pyuff", "uff", path)
    pieces = _pieces(np.asarray(np.isfinite(recording.values).all(axis=1)))
    if not pieces:
        raise ExchangeError(f"{path}: every sample is missing: UFF cannot hold that")
    units = {"type": 164, "units_code": SI_UNITS, "units_description": "SI: m, N, K"}
    units |= {"length": 1.0, "force": 1.0, "temp": 1.0, "temp_offset": 273.15}
    sets = [units]
    for k, channel in enumerate(recording.channels):
        for start, stop in pieces:
            sets.append(_function(recording, k, channel, start, stop))
    with TemporaryDirectory() as folder, path.open("wb") as file:
        for item in sets:
            # After each set pyuff reads the whole file again, so each has a file of its own first;
            # that must not exist, and be added to: "overwrite" loses the text of a binary set.
            apart = Path(folder) / "set.uff"
            pyuff.UFF(str(apart)).write_sets(item, mode="add")
            file.write(apart.read_bytes())
            apart.unlink()


def _pieces(there: NDArray[np.bool_]) -> list[list[int]]:
    """First and last row (exclusive) of each piece."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], there, [False]]).astype(np.int8)))
    pairs: list[list[int]] = edges.reshape(-1, 2).tolist()
    return pairs


def _function(
    recording: Recording, k: int, channel: Channel, start: int, stop: int
) -> dict[str, Any]:
    begin = recording.start_s + start / recording.rate_hz
    node = POINTS.index(channel.point) + 1 if channel.point in POINTS else 0
    since = recording.start_unix_s
    return {
        "type": 58,
        "binary": 1,
        "id1": _ascii(channel.name, 80),
        "id2": f"samples from {start} of {len(recording.values)}",
        "id3": _date(since) if since is not None else "NONE",
        "id4": _ascii(f"sensor {channel.sensor}" if channel.sensor else "", 80),
        "id5": _ascii(f"calibration {channel.calibration}" if channel.calibration else "", 80),
        "func_type": TIME_RESPONSE,
        "func_id": k + 1,
        "rsp_ent_name": _ascii(channel.point, 10),
        "rsp_node": node,
        "rsp_dir": PLUS_Z if node and channel.unit == ACCELERATION else 0,
        "ref_ent_name": "NONE",
        "ref_node": 0,
        "ref_dir": 0,
        "abscissa_spacing": EVEN,
        "abscissa_spec_data_type": 17,
        "abscissa_axis_lab": "time",
        "abscissa_axis_units_lab": "s",
        "ordinate_spec_data_type": KINDS.get(channel.unit, 0),
        "ordinate_axis_units_lab": _ascii(channel.unit.replace("²", "^2"), 20),
        "orddenom_spec_data_type": 0,
        "z_axis_spec_data_type": 0,
        "x": np.array([begin, begin + 1 / recording.rate_hz]),
        "data": recording.values[start:stop, k].copy(),
    }


def _ascii(text: str, width: int) -> str:
    """What a record of fixed width can hold of a text; records are never blank."""
    plain = "".join(char if " " <= char <= "~" else "?" for char in text)
    return plain[:width].strip() or "NONE"


def _date(unix_s: float) -> str:
    """DD-MMM-YY HH:MM:SS, as record 3 has it; UTC."""
    return datetime.fromtimestamp(unix_s, UTC).strftime("%d-%b-%y %H:%M:%S").upper()


def losses(recording: Recording) -> tuple[str, ...]:
    """Single values of rows that are incomplete; nothing else while the sidecar is there."""
    finite = np.isfinite(recording.values)
    partly = int((finite.any(axis=1) & ~finite.all(axis=1)).sum())
    infinite = int(np.isinf(recording.values).any(axis=1).sum())
    found = []
    if partly:
        found.append(f"rows with a value in some channels only: {partly}; they become gaps")
    if infinite:
        found.append(f"rows with an infinite value: {infinite}; they become gaps")
    return tuple(found)
