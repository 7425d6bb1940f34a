"""AiM's .xrk and .xrz, through libxrk, for reading: a group for each clock."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from wheelhop.files import NUMBERS, check_room
from wheelhop.formats.error import ExchangeError, need
from wheelhop.formats.groups import together
from wheelhop.formats.mapping import Map
from wheelhop.formats.table import Table, plain_channel

MILLISECONDS = 1e-3
TIMECODES = "timecodes"


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read every channel; those with the same stamps are one group."""
    libxrk = need("libxrk", "aim", path)
    check_room(path, NUMBERS * path.stat().st_size, ExchangeError)
    log = libxrk.aim_xrk(str(path))
    tables = []
    for name, channel in log.channels.items():
        stamps = channel.column(TIMECODES).to_numpy()
        if not len(stamps) or name not in channel.column_names:
            continue
        facts = channel.schema.field(name).metadata or {}
        unit = facts.get(b"units", b"").decode("utf-8", "replace")
        values = channel.column(name).to_numpy(zero_copy_only=False).astype(np.float64)
        tables.append(
            Table(
                file=path,
                kind="AiM",
                channels=(plain_channel(name, unit),),
                values=values[:, None],
                time_s=MILLISECONDS * stamps.astype(np.float64),
                group=name,
                same_clock=True,
            )
        )
    return together(tables)
