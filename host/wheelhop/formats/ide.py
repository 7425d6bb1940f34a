"""enDAQ's .IDE recordings, through idelib, for reading: a group for each channel, on its clock."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from wheelhop.files import NUMBERS, check_room
from wheelhop.formats.error import ExchangeError, need
from wheelhop.formats.groups import together
from wheelhop.formats.mapping import Map
from wheelhop.formats.table import Table, plain_channel

MICROSECONDS = 1e-6


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read the channels in the units their calibration gives; those with the same stamps are
    one."""
    idelib = need("idelib", "endaq", path)
    with closing(idelib.importFile(str(path))) as file:
        channels = list(file.channels.values())
        count = sum(len(c.getSession()) * (1 + len(c.subchannels)) for c in channels)
        check_room(path, NUMBERS * count, ExchangeError)
        start = file.sessions[0].utcStartTime if file.sessions else None
        tables = [t for c in channels if (t := _table(c, start, path)) is not None]
    return together(tables)


def _table(channel: Any, start: float | None, path: Path) -> Table | None:
    """The parts of a channel, X, Y and Z say; None for one that recorded nothing."""
    if not len(channel.getSession()):
        return None
    parts = [(part, np.asarray(part.getSession().arraySlice())) for part in channel.subchannels]
    time_s = MICROSECONDS * parts[0][1][0]
    return Table(
        file=path,
        kind="enDAQ",
        channels=tuple(plain_channel(part.name, part.units[1] or "") for part, _ in parts),
        values=np.column_stack([samples[1] for _, samples in parts]),
        time_s=time_s,
        start_unix_s=None if start is None else float(start),
        group=channel.name,
        same_clock=True,
    )
