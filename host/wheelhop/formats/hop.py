"""The logger's own files, as `wheelhop.logger` decodes them."""

from __future__ import annotations

from pathlib import Path

from wheelhop.formats.header import header_of
from wheelhop.formats.mapping import Map
from wheelhop.formats.table import Table


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Decode a log; its samples are codes until a calibration is applied."""
    from wheelhop.logger import read_log

    recording = read_log(path).recording()
    return [
        Table(
            file=path,
            kind="wheelhop log",
            channels=recording.channels,
            values=recording.values,
            rate_hz=recording.rate_hz,
            start_s=recording.start_s,
            header=header_of(recording),
        )
    ]
