"""ASAM MDF, through asammdf: MDF 3 and 4 are read, MDF 4 is written, as one group with a time
master and the header as an attached text.

Missing samples are NaN, and their invalidation bits are set, for tools that look at those.
"""

from __future__ import annotations

import gc
import logging
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import NUMBERS, check_room
from wheelhop.files.units import seconds_in
from wheelhop.formats.error import ExchangeError, need
from wheelhop.formats.groups import only_recordings, together
from wheelhop.formats.header import Header, from_text, to_text
from wheelhop.formats.mapping import Map
from wheelhop.formats.table import Table, plain_channel
from wheelhop.logger.recording import Channel, Recording

HEADER = "wheelhop.toml"
VERSION = "4.10"  # read by every tool of the last ten years
BEST_COMPRESSION = 1032  # that deflate can reach
VIRTUAL = (3, 6)  # channel types that are counted, not stored
INVALIDATION_BIT = 2  # flag of a channel that has one
MASTERS_3 = (1,)  # of MDF 3, always time
TIME_MASTER = 1
MASTERS = (2, 3)  # channel types of a master and a virtual master: time itself, or
OTHER_MASTERS = {2: "an angle", 3: "a distance", 4: "an index"}  # by its synchronisation type


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read the channels of numbers of every group; groups with the same time stamps are one."""
    asammdf = _library(path)
    # Given a name, asammdf would open the file for writing, and mend it.
    with path.open("rb") as stream, _freed_quietly(), asammdf.MDF(stream) as mdf:
        for group in mdf.groups:
            _check_layout(group, path)
        check_room(path, sum(map(_room, mdf.groups)), ExchangeError)
        header = _header(mdf, path)
        groups: list[Table] = []
        refused: list[str] = []
        for number in range(len(mdf.groups)):
            if reason := _no_time(mdf.groups[number]):
                refused.append(f"group {number} {reason}")
                continue
            table = _group(mdf, number, path)
            if table is not None:
                groups.append(table)
        tables = together(groups)
    if header is None:
        return only_recordings(tables, refused, path)
    if len(tables) != 1 or [c.name for c in tables[0].channels] != [
        channel.name for channel in header.bare.channels
    ]:
        raise ExchangeError(f"{path}: its {HEADER} does not describe its channels")
    own = tables[0]
    return [Table(path, own.kind, header.bare.channels, own.values, own.time_s, header=header)]


@contextmanager
def _freed_quietly() -> Iterator[None]:
    """A file that asammdf cannot read leaves an object half made, and that complains on stderr when
    it is freed: free it now, in silence."""
    try:
        yield
    except Exception as error:
        hook, sys.unraisablehook = sys.unraisablehook, lambda unraisable: None
        try:
            traceback.clear_frames(error.__traceback__)
            gc.collect()
        finally:
            sys.unraisablehook = hook
        raise


def _library(path: Path) -> Any:
    library = need("asammdf", "mdf", path)
    logging.getLogger("asammdf").setLevel(logging.CRITICAL)  # what is wrong is told by us
    return library


def _header(mdf: Any, path: Path) -> Header | None:
    attached = mdf.attachments if mdf.version >= "4" else ()  # MDF 3 has none
    for number, attachment in enumerate(attached):
        if Path(attachment.file_name).name == HEADER:
            packed = BEST_COMPRESSION * attachment.embedded_size
            check_room(path, max(attachment.original_size, packed), ExchangeError)
            data, *_ = mdf.extract_attachment(number)
            return from_text(data.decode("utf-8"), path)
    return None


def _check_layout(group: Any, path: Path) -> None:
    """No more samples than the file can hold, and every channel inside its record: asammdf makes
    room for all that is promised, and its compiled parts read wherever they are sent."""
    size = group.channel_group.samples_byte_nr
    spare = getattr(group.channel_group, "invalidation_bytes_nr", 0)  # MDF 3 has none
    due = group.channel_group.cycles_nr * max(1, size + spare)
    if due > BEST_COMPRESSION * path.stat().st_size:
        raise ExchangeError(f"{path}: is damaged: it is too short for the samples it promises")
    for item in group.channels:
        if hasattr(item, "start_offset"):  # MDF 3, in bits
            begins = 8 * item.additional_byte_offset + item.start_offset
            stored, flagged = True, 0
        else:
            begins = 8 * item.byte_offset + item.bit_offset
            stored = item.channel_type not in VIRTUAL
            flagged = item.flags & INVALIDATION_BIT
        ends = begins + item.bit_count
        if (stored and ends > 8 * size) or (flagged and item.pos_invalidation_bit >= 8 * spare):
            raise ExchangeError(f"{path}: is damaged: channel {item.name} lies outside its records")


def _room(group: Any) -> float:
    """Bytes that the records of a group take, and the columns that are made of them."""
    facts = group.channel_group
    spare = getattr(facts, "invalidation_bytes_nr", 0)
    record = facts.samples_byte_nr + spare + NUMBERS * len(group.channels)
    return float(facts.cycles_nr * record)


def _is_master(item: Any) -> bool:
    return item.channel_type in (MASTERS if hasattr(item, "sync_type") else MASTERS_3)


def _no_time(group: Any) -> str:
    """Why a group is sampled over something else than time, "" if it is not."""
    masters = [item for item in group.channels if _is_master(item)]
    if not masters:
        return ""
    kind = getattr(masters[0], "sync_type", TIME_MASTER)
    if axis := OTHER_MASTERS.get(kind):
        return f"is sampled over {axis}, not over time"
    unit = (masters[0].unit or "").strip()
    if unit and seconds_in(unit) is None:
        return f"is sampled over {masters[0].name} in {unit}, not over time"
    return ""


def _group(mdf: Any, number: int, path: Path) -> Table | None:
    channels: list[Channel] = []
    columns: list[NDArray[np.float64]] = []
    time_s, size = np.empty(0), 0.0
    for index, item in enumerate(mdf.groups[number].channels):
        if _is_master(item):
            size = seconds_in((item.unit or "").strip() or "s") or 1.0
            continue
        signal = mdf.get(group=number, index=index, ignore_invalidation_bits=True)
        samples = signal.samples
        if samples.ndim != 1 or samples.dtype.kind not in "iuf" or not len(samples):
            continue
        column = samples.astype(np.float64)
        if signal.invalidation_bits is not None:
            column[np.asarray(signal.invalidation_bits, dtype=bool)] = np.nan
        channels.append(plain_channel(signal.name, signal.unit or ""))
        columns.append(column)
        time_s = np.asarray(signal.timestamps, dtype=np.float64)
    if not columns:
        return None
    return Table(
        file=path,
        kind=f"MDF {mdf.version}",
        channels=tuple(channels),
        values=np.column_stack(columns),
        # Without a master asammdf counts the samples, as if they were seconds.
        time_s=size * time_s if size else None,
        asked="" if size else f"the samples of group {number} are only counted",
        start_unix_s=mdf.header.start_time.timestamp(),
        group=str(number),
    )


def save(recording: Recording, path: Path) -> None:
    """Write MDF 4.10, uncompressed."""
    asammdf = _library(path)
    missing = np.isnan(recording.values)
    time_s = recording.time_s
    signals = [
        asammdf.Signal(
            samples=np.ascontiguousarray(recording.values[:, k]),
            timestamps=time_s,
            name=channel.name,
            unit=_plain(channel.unit),
            comment=_comment(channel),
            invalidation_bits=missing[:, k] if missing[:, k].any() else None,
        )
        for k, channel in enumerate(recording.channels)
    ]
    with asammdf.MDF(version=VERSION) as mdf:
        mdf.append(signals, comment="wheelhop", common_timebase=True)
        # MDF has no sign for an unknown start; asammdf would write the time of the conversion.
        mdf.header.start_time = datetime.fromtimestamp(recording.start_unix_s or 0.0, UTC)
        mdf.header.comment = "\n".join(map(_plain, recording.history))
        data = to_text(recording).encode("utf-8")
        mdf.attach(data, file_name=HEADER, mime="text/toml", compression=False)
        mdf.save(path, overwrite=True)


def _comment(channel: Channel) -> str:
    facts = {
        "point": channel.point,
        "sensor": channel.sensor,
        "calibration": channel.calibration,
    }
    return _plain(", ".join(f"{key} {value}" for key, value in facts.items() if value))


def _plain(text: str) -> str:
    """Without what XML, in which MDF keeps its comments, cannot hold."""
    return "".join(char if char.isprintable() else "?" for char in text)


def losses(recording: Recording) -> tuple[str, ...]:
    """Nothing."""
    return ()
