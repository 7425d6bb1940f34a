"""Universal file format, dataset 58 (function at a nodal degree of freedom), through pyuff.

UFF has no sign for a missing sample: every piece between two gaps is a function of its own, with
its own start, and a gap is what no function covers. Numbers are written in binary (58b), exact.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import TABLE, check_room
from wheelhop.files.units import seconds_in, to_si
from wheelhop.formats.error import ExchangeError, need
from wheelhop.formats.grid import fit_grid, too_few
from wheelhop.formats.groups import no_time, only_recordings
from wheelhop.formats.header import Header, read_sidecar, sidecar
from wheelhop.formats.mapping import Map
from wheelhop.formats.names import is_time_name
from wheelhop.formats.table import POINTS, Table
from wheelhop.logger.recording import ACCELERATION, Channel, Recording

TIME_RESPONSE, EVEN, SI_UNITS = 1, 1, 1
TIME = 17  # specific data type of an abscissa
PLUS_Z = 3
UPWARDS = (0, PLUS_Z)  # 0: it does not say
DIRECTIONS = {
    **{k: f"+{'XYZ'[k - 1]}" for k in (1, 2, 3)},
    **{-k: f"-{'XYZ'[k - 1]}" for k in (1, 2, 3)},
}
KINDS = {"m": 8, ACCELERATION: 12, "m/s": 11, "N": 13}
"""Specific data types of record 9."""
AXES = {8: "displacement", 9: "force", 11: "speed", 12: "acceleration", 13: "force"}
AXES |= {2: "stress", 3: "strain", 5: "temperature", 15: "pressure", 18: "frequency"}
AXES |= {19: "rotational speed", 20: "order"}
"""What an abscissa may be of that is no time, by its specific data type."""
FUNCTIONS = {2: "auto spectrum", 3: "cross spectrum", 4: "frequency response", 6: "coherence"}
FUNCTIONS |= {5: "transmissibility", 7: "auto correlation", 8: "cross correlation"}
FUNCTIONS |= {9: "power spectral density", 10: "energy spectral density", 12: "spectrum"}
Key = tuple[str | int | None, ...]
SAME_S = 1.0
"""Dates of functions that were recorded together may differ by so much."""
PLACE = re.compile(r"samples from (\d+) of (\d+)")


@dataclass(frozen=True, eq=False)
class _Piece:
    """One function: whose it is, where its first sample lies (in rows too, if we wrote it), and its
    samples. Functions with the same `key` are pieces of one channel."""

    key: Key
    label: str
    written: datetime | None
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
    pieces: list[_Piece] = []
    refused: list[str] = []
    for number, item in enumerate(sets, start=1):
        if item.get("type") != 58:
            continue
        if reason := _no_recording(item):
            refused.append(f"dataset {number}: {reason}")
        else:
            pieces.append(_piece(item, number, metric, path))
    for piece in _apart(pieces):
        _sort_in(groups, piece)
    tables = [_table(group, header, str(k), path) for k, group in enumerate(groups, start=1)]
    if header is None:
        return only_recordings(tables, refused, path)
    names = [_ascii(channel.name, 80) for channel in header.bare.channels]
    if len(tables) != 1 or [channel.name for channel in tables[0].channels] != names:
        raise ExchangeError(
            f"{sidecar(path)}: does not describe the functions of {path.name}: correct or delete it"
        )
    return [replace(tables[0], channels=header.bare.channels)]


def _no_recording(item: Mapping[str, Any]) -> str:
    """Why a function is none of time; "" if it is one."""
    if item["func_type"] not in (0, TIME_RESPONSE):
        kind = FUNCTIONS.get(item["func_type"], f"function of type {item['func_type']}")
        return f"is a {kind}, no recording"
    axis = AXES.get(item.get("abscissa_spec_data_type", 0))
    unit = _said(item.get("abscissa_axis_units_lab", ""))
    if axis is None and unit and seconds_in(unit) is None:
        axis = unit
    label = _said(item.get("abscissa_axis_lab", ""))
    if axis is None and "freq" in label.lower():
        axis = "frequency"
    sure = unit or item.get("abscissa_spec_data_type", 0) == TIME
    if axis is None and label and not sure and not is_time_name(label):
        axis = label
    if axis is None:
        return ""
    return f"its abscissa is {axis}, not time: {no_time('Hz' if axis == 'frequency' else unit)}"


def _said(text: str) -> str:
    """A text of a record, "" for NONE."""
    text = text.strip()
    return "" if text.upper() == "NONE" else text


def _apart(pieces: list[_Piece]) -> list[_Piece]:
    """Sensors that share a node are told apart by their first lines: where functions of one node
    overlap in time, have different first lines, and are not the node's part of a repetition."""
    of_node: dict[Key, list[_Piece]] = {}
    for piece in pieces:
        of_node.setdefault(piece.key, []).append(piece)
    fewest = min(map(len, of_node.values()), default=0)
    shared = set()
    for key, found in of_node.items():
        labels = {piece.label for piece in found if piece.label}
        together = any(_overlap(one, other) for one, other in combinations(found, 2))
        dates = {piece.written for piece in found}
        at_once = len(dates) == 1 and None not in dates
        if len(labels) > 1 and together and (at_once or fewest < len(found)):
            shared.add(key)
    return [
        replace(
            piece,
            key=(piece.label, *piece.key[1:]),
            channel=replace(
                piece.channel,
                name=_called(piece.label, piece.channel.unit, piece.key[2]) or piece.channel.name,
            ),
        )
        if piece.key in shared
        else piece
        for piece in pieces
    ]


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
    seconds = seconds_in(_said(item.get("abscissa_axis_units_lab", "")) or "s") or 1.0
    begun = (key, _said(item["id1"]), _written(item["id3"]), channel)
    if item["abscissa_spacing"] != EVEN:
        grid = fit_grid(seconds * np.asarray(item["x"]), lambda row: f"{place}: sample {row + 1}")
        spread = grid.spread(values[:, np.newaxis])[:, 0]
        return _Piece(*begun, grid.start_s, grid.rate_hz, spread)
    start, step = seconds * item["abscissa_min"], seconds * item["abscissa_inc"]
    if not (abs(start) < 1e15 and 0.0 < step < 1e15):
        raise ExchangeError(f"{place}: time from {start:g} s in steps of {step:g} s is no time")
    return _Piece(*begun, start, _rate(step), values, int(found[1]) if found else None)


def _written(date: str) -> datetime | None:
    """The date of record 3, None if there is none."""
    try:
        return datetime.strptime(date.strip(), "%d-%b-%y %H:%M:%S")
    except ValueError:
        return None


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
    if per := _said(item.get("orddenom_axis_units_lab", "")):
        unit = f"{unit}/{per}"
    name = name if name == node else _called(name, unit, item["rsp_dir"])
    point = entity if entity in POINTS and item["rsp_dir"] in UPWARDS else ""
    return Channel(name, unit, point)


def _called(label: str, unit: str, direction: object) -> str:
    """A function by its first line, and an acceleration by its direction, too, unless it is up."""
    way = DIRECTIONS.get(direction, "") if isinstance(direction, int) else ""
    felt = to_si(unit)[0] == ACCELERATION and direction not in UPWARDS
    return f"{label} {way}".strip() if label and felt else label


def _sort_in(groups: list[dict[Key, list[_Piece]]], piece: _Piece) -> None:
    """Put a piece into the first group of its rate in which its channel is still free then."""
    for group in groups:
        of_channel = group.get(piece.key, [])
        first = next(iter(group.values()))[0]
        at_once = first.rate_hz == piece.rate_hz and not _days_apart(first, piece)
        if at_once and not any(_overlap(other, piece) for other in of_channel):
            group.setdefault(piece.key, []).append(piece)
            return
    groups.append({piece.key: [piece]})


def _days_apart(one: _Piece, other: _Piece) -> bool:
    """Whether two functions say that they were recorded at different times."""
    if one.written is None or other.written is None:
        return False
    return abs((other.written - one.written).total_seconds()) > SAME_S


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
