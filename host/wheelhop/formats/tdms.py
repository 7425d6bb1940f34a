"""National Instruments TDMS, through npTDMS, for reading."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import NUMBERS, check_room
from wheelhop.files.units import SECONDS, seconds_in
from wheelhop.formats.error import LONGEST_REASON, ExchangeError, need
from wheelhop.formats.mapping import Map
from wheelhop.formats.stamps import CLOCK
from wheelhop.formats.table import Table, plain_channel

UNIT_KEYS = ("unit_string", "NI_UnitDescription", "Unit", "unit")


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read the channels of every group, those of one length and waveform timing together."""
    nptdms = need("nptdms", "tdms", path)
    need("nptdms.log", "tdms", path).log_manager.console_handler.setLevel(logging.CRITICAL)
    facts = nptdms.TdmsFile.read_metadata(str(path))
    count = sum(len(channel) for group in facts.groups() for channel in group.channels())
    check_room(path, NUMBERS * count, ExchangeError)
    with _Listener() as listener:
        file = nptdms.TdmsFile.read(str(path))
    tables = [table for group in file.groups() for table in _tables(group, mapping, path)]
    return [replace(table, remarks=tuple(listener.heard)) for table in tables]


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


def _tables(group: Any, mapping: Map | None, path: Path) -> list[Table]:
    clock, unit = (str(mapping.time), mapping.time_unit) if mapping is not None else ("", CLOCK)
    time_s = None
    gathered: dict[tuple[int, float, float], list[Any]] = {}
    for channel in group.channels():
        if not len(channel) or channel.dtype.kind not in "iufM":
            continue
        if clock and channel.name == clock:
            time_s = _seconds(channel[:], unit, f"{path}: {clock}")
        elif channel.dtype.kind != "M":
            gathered.setdefault((len(channel), *_timing(channel, path)), []).append(channel)
    return [
        Table(
            file=path,
            kind="TDMS",
            channels=tuple(plain_channel(item.name, _unit(item)) for item in items),
            values=np.column_stack([item[:].astype(np.float64) for item in items]),
            time_s=time_s if time_s is not None and len(time_s) == count else None,
            rate_hz=1.0 / step if step else None,
            start_s=start,
            start_unix_s=_start(items[0]),
            group=group.name if len(gathered) == 1 else f"{group.name} {number}",
        )
        for number, ((count, step, start), items) in enumerate(gathered.items(), start=1)
    ]


def _timing(channel: Any, path: Path) -> tuple[float, float]:
    """Step and start of a waveform, s, 0 where the file does not say."""
    unit = str(channel.properties.get("wf_xunit_string", "")).strip() or "s"
    if (seconds := seconds_in(unit)) is None:
        raise ExchangeError(
            f"{path}: {channel.name}: its x axis is in {unit}, no unit of time that is known: it is"
            " no recording"
        )
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


def _seconds(stamps: NDArray[Any], unit: str, place: str) -> NDArray[np.float64]:
    if stamps.dtype.kind == "M":
        since: NDArray[np.float64] = (stamps - stamps[0]) / np.timedelta64(1, "s")
        return since
    if unit not in SECONDS:
        raise ExchangeError(f"{place} holds numbers, not dates: give their time_unit")
    return stamps.astype(np.float64) * SECONDS[unit]
