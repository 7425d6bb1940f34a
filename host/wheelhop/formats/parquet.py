"""Parquet: `time_s` and a column per channel, the header in the schema's metadata."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
from pyarrow import parquet

from wheelhop.files import NUMBERS, InputError, check_plain, check_room
from wheelhop.files.units import SECONDS
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.header import from_text, to_text
from wheelhop.formats.mapping import Map
from wheelhop.formats.table import Table, campaign_channel, plain_channel
from wheelhop.logger.recording import Recording

KEY = b"wheelhop"
UNIT = b"unit"
TIME = "time_s"


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read every column of numbers; units are taken from the fields' metadata."""
    table = read_table(path)
    schema = table.schema
    text = (schema.metadata or {}).get(KEY)
    header = from_text(text.decode("utf-8"), path) if text is not None else None
    clock = str(mapping.time) if mapping is not None and mapping.time else TIME
    names, columns, numbers, units, time_s = [], [], [], [], None
    for number, name in enumerate(schema.names, start=1):
        kind = schema.field(number - 1).type
        if not (pyarrow.types.is_floating(kind) or pyarrow.types.is_integer(kind)):
            continue
        column = table.column(number - 1).to_numpy().astype(np.float64)
        if name == clock:
            time_s = column * _seconds(mapping, path)
            continue
        unit = (schema.field(number - 1).metadata or {}).get(UNIT)
        units.append((unit or b"").decode("utf-8"))
        names.append(name)
        columns.append(column)
        numbers.append(number)
    channels = tuple(map(campaign_channel if clock == TIME else plain_channel, names, units))
    if header is not None:
        channels = header.bare.channels
        if [channel.name for channel in channels] != names:
            raise ExchangeError(f"{path}: its metadata does not describe its columns")
    if not columns:
        return []
    values = np.column_stack(columns)
    return [Table(path, "Parquet", channels, values, time_s, header=header, numbers=tuple(numbers))]


def _seconds(mapping: Map | None, path: Path) -> float:
    """How long the unit of the time stamps is."""
    unit = mapping.time_unit if mapping is not None and mapping.time else "s"
    if unit not in SECONDS:
        raise ExchangeError(f"{path}: its times are numbers, not dates: give their time_unit")
    return SECONDS[unit]


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
