"""Parquet: `time_s` and a column per channel, the header in the schema's metadata."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
from pyarrow import parquet

from wheelhop.files import NUMBERS, InputError, check_plain, check_room
from wheelhop.files.units import SECONDS
from wheelhop.formats.columns import Column, Timing
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.header import from_text, to_text
from wheelhop.formats.labels import is_doubtful, name_and_unit
from wheelhop.formats.mapping import Map
from wheelhop.formats.stamps import Stamps
from wheelhop.formats.table import Table, campaign_channel, plain_channel
from wheelhop.formats.timing import find_timing, stamps_of
from wheelhop.logger.recording import Recording

KEY = b"wheelhop"
UNIT = b"unit"
TIME = "time_s"


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read every column of numbers; units are taken from the fields' metadata, or from their names.

    Time is the column that the mapping says, `TIME`, or one that is called so and whose unit is
    said; see `find_timing`.
    """
    table = read_table(path)
    text = (table.schema.metadata or {}).get(KEY)
    header = from_text(text.decode("utf-8"), path) if text is not None else None
    columns = [_column(table, k) for k in range(table.num_columns)]
    labels = [column.label for column in columns]
    timing = Timing()
    if mapping is not None and mapping.time != "":
        index = _index(labels, mapping.time, path)
        timing = Timing(index, mapping.time_unit)
    elif TIME in labels:
        timing = Timing(labels.index(TIME), "s")
    elif mapping is None or mapping.rate_hz is None:
        timing = find_timing(columns, {})
        if timing.questions:
            asked = timing.questions[0].words if timing.index is not None else ""
            timing = Timing(aside=timing.aside, why=asked)
    wanted = [
        k
        for k, column in enumerate(columns)
        if column.values is not None and k != timing.index and k not in timing.aside
    ]
    if not wanted:
        return []
    names = [labels[k] for k in wanted]
    ours = timing.index is not None and labels[timing.index] == TIME
    make = campaign_channel if ours and header is None else plain_channel
    channels = tuple(make(labels[k], columns[k].unit) for k in wanted)
    if header is not None:
        channels = header.bare.channels
        if [channel.name for channel in channels] != names:
            raise ExchangeError(f"{path}: its metadata does not describe its columns")
    found = Table(
        path,
        "Parquet",
        channels,
        np.column_stack([v for k in wanted if (v := columns[k].values) is not None]),
        header=header,
        numbers=tuple(k + 1 for k in wanted),
        asked=timing.why,
        own=ours,
        granted="" if ours or header is not None else _doubtful(table, columns, mapping),
    )
    if timing.index is None:
        return [found]
    time = columns[timing.index]
    stamps = stamps_of(time, timing.unit, mapping.rate_hz if mapping else None, path)
    said = f"time is {time.label}{f', {timing.why}' if timing.why else ''}"
    remarks = (*(() if ours or (mapping and mapping.time) else (said,)), *stamps.remarks)
    timed = replace(found, time_s=stamps.time_s, start_unix_s=stamps.start_unix_s)
    granted = "; ".join(filter(None, [timing.guess, found.granted]))
    return [replace(timed, remarks=remarks, granted=granted)]


def _doubtful(table: Any, columns: Sequence[Column], mapping: Map | None) -> str:
    """Units that only the ends of names say, and no mapping."""
    said = {pick.column for pick in mapping.picks if pick.unit} if mapping else set()
    return "; ".join(
        f"{column.label} is in {column.unit}, by the end of its name"
        for k, (column, field) in enumerate(zip(columns, table.schema, strict=True), start=1)
        if column.values is not None
        and column.unit
        and not (field.metadata or {}).get(UNIT)
        and is_doubtful(column.label)
        and not said & {k, column.label}
    )


def _column(table: Any, k: int) -> Column:
    """A column of the file: numbers, dates, or words."""
    field, data = table.schema.field(k), table.column(k)
    said = (field.metadata or {}).get(UNIT, b"").decode("utf-8")
    name, unit = name_and_unit(field.name)
    column = Column(field.name, name, said or unit)
    kinds = pyarrow.types
    if kinds.is_floating(field.type) or kinds.is_integer(field.type):
        return replace(column, values=data.to_numpy().astype(np.float64))
    if kinds.is_timestamp(field.type) or kinds.is_time(field.type) or kinds.is_duration(field.type):
        if data.null_count:
            return replace(column, stamps="some rows have no time")
        short = kinds.is_time32(field.type)
        counts = data.cast(pyarrow.int32() if short else pyarrow.int64()).to_numpy().astype(int)
        seconds = (counts - counts[:1]) * SECONDS[field.type.unit]
        zero = None
        if kinds.is_timestamp(field.type) and field.type.tz and len(counts):
            zero = float(counts[0]) * SECONDS[field.type.unit]
        return replace(column, stamps=Stamps(np.asarray(seconds, dtype=np.float64), zero))
    if kinds.is_dictionary(field.type) or kinds.is_string(field.type):
        return replace(column, texts=tuple(text or "" for text in data.to_pylist()))
    return column


def _index(labels: list[str], time: str | int, path: Path) -> int:
    if isinstance(time, int) and 1 <= time <= len(labels):
        return time - 1
    if time in labels:
        return labels.index(str(time))
    raise ExchangeError(f"{path}: there is no column {time!r}; it has {', '.join(labels)}")


def read_table(path: Path, kind: type[InputError] = ExchangeError) -> Any:
    """What is in a Parquet file, texts as dictionaries. Raises an error of this `kind` for what is
    no plain file, and if the numbers that it says it holds take more memory than is free: a column
    of one number is packed into a few bytes."""
    check_plain(path, kind)
    with parquet.ParquetFile(path) as file:
        facts, schema = file.metadata, file.schema_arrow
    columns = [
        facts.row_group(group).column(k)
        for group in range(facts.num_row_groups)
        for k in range(facts.num_columns)
    ]
    unpacked = sum(column.total_uncompressed_size for column in columns)
    check_room(path, unpacked + NUMBERS * sum(column.num_values for column in columns), kind)
    texts = [
        field.name
        for field in schema
        if pyarrow.types.is_string(field.type) or pyarrow.types.is_binary(field.type)
    ]
    with parquet.ParquetFile(path, read_dictionary=texts) as file:
        return file.read()


def save(recording: Recording, path: Path) -> None:
    """Write time and channels as float64."""
    fields = [pyarrow.field(TIME, pyarrow.float64(), metadata={UNIT: "s"})]
    fields += [
        pyarrow.field(channel.name, pyarrow.float64(), metadata={UNIT: channel.unit})
        for channel in recording.channels
    ]
    if TIME in (channel.name for channel in recording.channels):
        raise ExchangeError(f"{path}: a channel cannot be called {TIME}: rename it")
    schema = pyarrow.schema(fields, metadata={KEY: to_text(recording)})
    columns = [recording.time_s, *recording.values.T.copy()]
    arrays = [pyarrow.array(column, pyarrow.float64()) for column in columns]
    table = pyarrow.Table.from_arrays(arrays, schema=schema)
    parquet.write_table(table, path)


def losses(recording: Recording) -> tuple[str, ...]:
    """Nothing."""
    return ()
