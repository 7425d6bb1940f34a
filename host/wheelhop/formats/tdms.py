"""National Instruments TDMS, through npTDMS, for reading."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import NUMBERS, check_room
from wheelhop.files.units import seconds_in
from wheelhop.formats.columns import Column
from wheelhop.formats.error import LONGEST_REASON, ExchangeError, need
from wheelhop.formats.groups import no_time, on_one_clock, only_recordings
from wheelhop.formats.mapping import Map
from wheelhop.formats.names import is_time_name
from wheelhop.formats.stamps import Stamps
from wheelhop.formats.table import Table, plain_channel
from wheelhop.formats.timing import find_timing, stamps_of

X_KEYS = ("wf_xunit_string", "wf_xname")
UNIT_KEYS = ("unit_string", "NI_UnitDescription", "Unit", "unit")
SCALINGS = (
    *("Linear", "Polynomial", "RTD", "Strain", "Table", "Thermistor", "Thermocouple"),
    *("Add", "Subtract", "AdvancedAPI"),
)
"""Those that npTDMS applies; another one leaves the values raw."""


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read the channels of every group; those of one rate and one clock together, from groups of
    several names as well, unless the mapping chooses one."""
    nptdms = need("nptdms", "tdms", path)
    need("nptdms.log", "tdms", path).log_manager.console_handler.setLevel(logging.CRITICAL)
    facts = nptdms.TdmsFile.read_metadata(str(path))
    count = sum(len(channel) for group in facts.groups() for channel in group.channels())
    check_room(path, NUMBERS * count, ExchangeError)
    with _Listener() as listener, nptdms.TdmsFile.open(str(path)) as file:
        return _all(file, mapping, path, listener)


def _all(file: Any, mapping: Map | None, path: Path, listener: _Listener) -> list[Table]:
    names = [channel.name for group in file.groups() for channel in group.channels()]
    if mapping is not None and mapping.time != "" and str(mapping.time) not in names:
        raise ExchangeError(
            f"{path}: there is no channel {mapping.time!r}; it has {', '.join(names)}"
        )
    refused: list[str] = []
    tables = [
        replace(table, remarks=(*listener.heard, *table.remarks))
        for group in file.groups()
        for table in _tables(group, file.properties, mapping, path, refused)
    ]
    chosen = mapping is not None and bool(mapping.group)
    return only_recordings(tables if chosen else on_one_clock(tables), refused, path)


class _Listener(logging.Handler):
    """Hears what npTDMS would print: that the end of a file is missing, say."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.heard: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a message, shortened to what fits into a history."""
        self.heard.append(" ".join(record.getMessage().split())[:LONGEST_REASON])

    def __enter__(self) -> Self:
        logging.getLogger("nptdms").addHandler(self)
        return self

    def __exit__(self, *exception: object) -> None:
        logging.getLogger("nptdms").removeHandler(self)


def _tables(
    group: Any, of_file: Mapping[str, Any], mapping: Map | None, path: Path, refused: list[str]
) -> list[Table]:
    """The channels of a group, those of one length, timing and start together; those that are not
    sampled over time are `refused`."""
    time, gathered = _gathered(group, str(mapping.time) if mapping else "", path, refused)
    tables = []
    for (count, step, start, since), items in gathered.items():
        by_steps = step and time is None  # and what is only dates is no channel
        items = [i for i in items if i.dtype.kind != "M"] if by_steps else items
        columns = [_bare(item) if by_steps else _column(item) for item in items]
        timed = _Time()
        if not by_steps:
            fits = time is not None and len(time) == count
            timed = _time(columns, time if fits else None, mapping, path)
        measured = [
            k
            for k, column in enumerate(columns)
            if (by_steps or column.values is not None) and k not in timed.aside
        ]
        if not measured:
            continue
        raw = {k: kind for k in measured if (kind := _unknown_scaling(items[k], group, of_file))}
        names = [items[k].name for k in measured]
        units = ["" if k in raw else columns[k].unit for k in measured]
        tables.append(
            Table(
                file=path,
                kind="TDMS",
                channels=tuple(map(plain_channel, names, units)),
                values=_values(items, columns, measured, count),
                spare=True,
                time_s=None if timed.stamps is None else timed.stamps.time_s,
                rate_hz=1.0 / step if step else None,
                start_s=start,
                start_unix_s=since if timed.stamps is None else timed.stamps.start_unix_s,
                group=group.name,
                asked=timed.asked,
                granted=timed.granted,
                remarks=(
                    *timed.remarks,
                    *(
                        f"{items[k].name}: scaling {kind} is not known: the values are raw, in an"
                        " unknown unit"
                        for k, kind in raw.items()
                    ),
                ),
            )
        )
    if len(tables) > 1:
        named = enumerate(tables, start=1)
        tables = [replace(table, group=f"{group.name} {number}") for number, table in named]
    return tables


def _gathered(
    group: Any, clock: str, path: Path, refused: list[str]
) -> tuple[Any, dict[tuple[int, float, float, float | None], list[Any]]]:
    """The channel that is called `clock`, None if none is, and the others by length and timing."""
    time: Any = None
    gathered: dict[tuple[int, float, float, float | None], list[Any]] = {}
    for channel in group.channels():
        if not len(channel) or channel.dtype.kind not in "iufM":
            continue
        if clock and channel.name == clock:
            time = channel
            continue
        unit, axis = (str(channel.properties.get(key, "")).strip() for key in X_KEYS)
        if not unit and axis and not is_time_name(axis):
            kind = no_time("Hz" if "freq" in axis.lower() else "")
            refused.append(f"{channel.name}: its x axis is {axis}, not time: {kind}")
            continue
        if unit and seconds_in(unit) is None:
            refused.append(f"{channel.name}: its x axis is in {unit}, not in time: {no_time(unit)}")
            continue
        timing = (*_timing(channel, path), _start(channel))
        gathered.setdefault((len(channel), *timing), []).append(channel)
    return time, gathered


@dataclass(frozen=True)
class _Time:
    """Stamps that a channel holds, the columns that are no channels then, and what is said of it;
    or why there are none."""

    stamps: Stamps | None = None
    aside: frozenset[int] = frozenset()
    remarks: tuple[str, ...] = ()
    asked: str = ""
    granted: str = ""


def _time(columns: list[Column], time: Any, mapping: Map | None, path: Path) -> _Time:
    """Time as the channel `time` that the mapping names has it, or else one that is called so."""
    rate_hz = mapping.rate_hz if mapping is not None else None
    if time is not None:
        assert mapping is not None
        return _Time(stamps_of(_column(time), mapping.time_unit, rate_hz, path))
    dates = frozenset(k for k, column in enumerate(columns) if column.values is None)
    if mapping is not None and (mapping.time != "" or mapping.rate_hz is not None):
        return _Time(aside=dates)
    timing = find_timing(columns, {})
    if timing.index is None or timing.questions:
        asked = timing.questions[0].words if timing.index is not None else ""
        return _Time(aside=dates | timing.aside.keys(), asked=asked)
    chosen = columns[timing.index]
    stamps = stamps_of(chosen, timing.unit, rate_hz, path)
    aside = dates | timing.aside.keys() | {timing.index}
    said = (f"time is {chosen.label}, {timing.why}", *stamps.remarks)
    return _Time(stamps, aside, said, granted=timing.guess)


def _bare(channel: Any) -> Column:
    """A channel without its samples, which are read once there is room for them."""
    return Column(channel.name, channel.name, _unit(channel))


def _values(
    items: list[Any], columns: list[Column], measured: list[int], count: int
) -> NDArray[np.float64]:
    """The samples (count, c) of the channels that are measured, one after the other read from the
    file."""
    values = np.empty((count, len(measured)), order="F")
    for at, k in enumerate(measured):
        held = columns[k].values
        values[:, at] = items[k][:] if held is None else held
    return values


def _column(channel: Any) -> Column:
    data = channel[:]
    column = Column(channel.name, channel.name, _unit(channel))
    if data.dtype.kind != "M":
        return replace(column, values=data.astype(np.float64))
    since = (data - data[0]) / np.timedelta64(1, "s")
    return replace(column, stamps=Stamps(np.asarray(since, dtype=np.float64)))


def _unknown_scaling(channel: Any, group: Any, of_file: Mapping[str, Any]) -> str:
    """The type of a scaling that npTDMS cannot apply, which leaves raw values; "" if it can."""
    for facts in (channel.properties, group.properties, of_file):
        if facts.get("NI_Scaling_Status", "unscaled") == "scaled":
            continue
        for number in range(int(facts.get("NI_Number_Of_Scales", 0))):
            kind = facts.get(f"NI_Scale[{number}]_Scale_Type", SCALINGS[0])
            if kind not in SCALINGS:
                return str(kind)
    return ""


def _timing(channel: Any, path: Path) -> tuple[float, float]:
    """Step and start of a waveform, s, 0 where the file does not say."""
    unit = str(channel.properties.get("wf_xunit_string", "")).strip() or "s"
    seconds = seconds_in(unit) or 1.0
    step = seconds * float(channel.properties.get("wf_increment", 0.0))
    start = seconds * float(channel.properties.get("wf_start_offset", 0.0))
    if not ((step == 0.0 or 1e-15 < step < 1e15) and abs(start) < 1e15):
        raise ExchangeError(
            f"{path}: {channel.name}: from {start} s in steps of {step} s (wf_increment) is no time"
        )
    return step, start


def _unit(channel: Any) -> str:
    found = (channel.properties.get(key) for key in UNIT_KEYS)
    return next((unit for unit in found if isinstance(unit, str) and unit), "")


def _start(channel: Any) -> float | None:
    """Unix time of the waveform's zero; TDMS times are UTC."""
    start = channel.properties.get("wf_start_time")
    return float(start.astype("datetime64[ns]").astype(np.int64)) / 1e9 if start else None
