"""What a vehicle's campaign and a component's have in common."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign.paths import file_inside
from wheelhop.campaign.types import CampaignError
from wheelhop.files import Table, did_you_mean

ROLES = ("fit", "validate")


@dataclass(frozen=True)
class Entry:
    """A run before its recording is read."""

    id: str
    file: Path
    role: str


def entry(run: Table, folder: Path) -> Entry:
    """What every [[run]] states."""
    return Entry(run.text("id"), file_inside(folder, run, "file"), run.text("role", choices=ROLES))


def band(top: Table, rate_hz: float) -> tuple[float, float]:
    """The band in which errors are computed."""
    low, high = top.pair("band_hz")
    if not 0.0 < low < high:
        raise top.error(f"band_hz = [{low:g}, {high:g}] must rise from above 0: [0.5, 30.0]")
    if high >= rate_hz / 2:
        raise top.error(
            f"band_hz = [{low:g}, {high:g}] must end below half the sample rate, {rate_hz / 2:g} Hz"
        )
    return low, high


def check_resolved(file: Path, rows: int, rate_hz: float, band_hz: tuple[float, float]) -> None:
    """Raise unless a frequency that a recording of so many rows tells apart lies in the band."""
    low, high = (edge * rows / rate_hz for edge in band_hz)
    if math.floor(high + 1e-9) < max(1, math.ceil(low - 1e-9)):
        raise CampaignError(
            f"{file}: {rows} rows at {rate_hz:g} Hz tell nothing between {band_hz[0]:g} and "
            f"{band_hz[1]:g} Hz: widen band_hz in campaign.toml, or leave the run out"
        )


def check_entries(top: Table, entries: Sequence[Entry]) -> None:
    """No id and no recording twice, and something to fit."""
    ids: set[str] = set()
    files: dict[Path, str] = {}
    for item in entries:
        if item.id in ids:
            raise top.error(f'[[run]] "{item.id}": id is used twice; every run needs its own')
        ids.add(item.id)
        other = files.setdefault(item.file.resolve(), item.id)
        if other != item.id:
            raise top.error(f'[[run]] "{item.id}": file is the recording of run "{other}" already')
    if not any(item.role == "fit" for item in entries):
        raise top.error('no [[run]] has role = "fit"; without one there is nothing to fit')


def column(file: Path, columns: list[str], name: str, remedy: str) -> int:
    """Where a column stands; `remedy` is what to do if it was not recorded."""
    if name in columns:
        return columns.index(name)
    guess = did_you_mean(name, columns) or f"; {remedy}"
    raise CampaignError(f"{file}: column {name} is missing{guess}")


def frozen(array: NDArray[np.float64]) -> NDArray[np.float64]:
    """A read-only copy."""
    copy = np.ascontiguousarray(array).copy()
    copy.setflags(write=False)
    return copy
