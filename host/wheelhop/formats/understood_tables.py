"""What was understood of a file that names its channels: MDF, TDMS and their like, or long form."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from wheelhop.files import quoted
from wheelhop.formats.asked import answered, resample_keys, timing_keys, uneven
from wheelhop.formats.columns import Question, Timing
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.grid import RESAMPLE, typical_step
from wheelhop.formats.labels import apart, name_and_unit
from wheelhop.formats.resample import side_by_side
from wheelhop.formats.table import Table, clocks_are_known, odd_rate
from wheelhop.formats.understood import CHANNEL, Found, Understood, places_of, why_of

Keys = Sequence[tuple[str, str, str]]
"""Keys of a mapping, their values and comments."""


def of_tables(
    path: Path, tables: Sequence[Table], answers: Mapping[str, str], above: Keys = ()
) -> Understood:
    """What there is to say of a file that was read into these tables; `above` are the keys of its
    mapping that say how. Raises `ExchangeError` for one without channels."""
    if not tables:
        raise ExchangeError(f"{path}: holds no channels of numbers")
    keys, table = list(above), tables[0]
    several: tuple[str, ...] = ()
    clocks = ""
    if len(tables) > 1 and ("resample_hz" in answers or above):
        table = side_by_side(tables)
        clocks = f"{', '.join(t.group for t in tables)} have clocks of their own: {RESAMPLE}"
    elif len(tables) > 1:
        names = ", ".join(quoted(table.group) for table in tables)
        together = f"; or leave group out, and {RESAMPLE}" if clocks_are_known(tables) else ""
        keys.append(("group", quoted(table.group), f"one of {names}{together}"))
        several = (f"of groups with clocks of their own, {names}, the first is shown",)
    timing = Timing()
    if table.time_s is None and table.rate_hz is None:
        words = table.asked or "the file has no time"
        timing = answered(Timing(questions=(Question("rate_hz", words),)), answers)
        keys += timing_keys(timing, ())
    elif (words := _odd(table)) and "resample_hz" not in answers:
        timing = answered(Timing(questions=(Question("rate_hz", words),)), answers)
        keys += timing_keys(timing, ())
    resampling, asked = resample_keys(clocks or uneven(table), answers)
    keys += resampling
    count = Counter(channel.name for channel in table.channels)
    units = [channel.unit for channel in table.channels]
    bare = [name_and_unit(channel.name) for channel in table.channels]
    short = [
        name if unit and unit == channel.unit else channel.name
        for (name, unit), channel in zip(bare, table.channels, strict=True)
    ]
    named = apart(short, units, table.columns)
    points = places_of(list(zip(named, units, strict=True)))
    columns = []
    for k, (number, channel) in enumerate(zip(table.columns, table.channels, strict=True)):
        key = quoted(channel.name) if count[channel.name] == 1 else str(number)
        why = why_of(named[k], channel.unit)
        found = Found(key, channel.name, named[k], channel.unit, CHANNEL, why, points[k])
        columns.append(found)
    questions = (*timing.questions, *asked)
    return Understood(path, tuple(keys), tuple(columns), questions, (), (*several, *table.remarks))


def _odd(table: Table) -> str:
    """What is asked of the rate of a table that says one, "" if nothing is."""
    if table.rate_hz is not None:
        return odd_rate(table, table.rate_hz)
    if table.time_s is None or len(table.time_s) < 2:
        return ""
    forward = np.diff(table.time_s)
    forward = forward[forward > 0]
    return odd_rate(table, 1.0 / typical_step(forward)) if len(forward) else ""
