"""What a vehicle's campaign and a component's have in common."""

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


def check_entries(top: Table, entries: Sequence[Entry]) -> None:
    """No id and no recording twice, and something to fit."""
    for index, item in enumerate(entries):
        for other in entries[:index]:
            if item.id == other.id:
                raise top.error(f'[[run]] "{item.id}": id is used twice; every run needs its own')
            if item.file.resolve() == other.file.resolve():
                raise top.error(
                    f'[[run]] "{item.id}": file is the recording of run "{other.id}" already'
                )
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
