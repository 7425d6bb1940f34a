"""A day in the field: what eight sensors put out while somebody turns them over, then drives.

The voltages come from a simulator that knows nothing of wheelhop (`tests/truth/voltages.py`); what
is hidden in them stands in truth.toml beside them, which no program reads.
"""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.hil_sim.signals import Signals, from_volts

EIGHT_DRIVES = "eight_drives"
STEP_V = 1e-4
RATE_HZ = 400.0
FINER = 8  # rows for one that is stored: the board draws straight lines between them
REST_S = 4.0  # between and behind the drives
LEAD_RESTS = 10  # before the first: a host may take its time to find the logger


@dataclass(frozen=True)
class Drive:
    """How one of the drives was driven, as campaign.toml says it."""

    id: str
    role: str
    speed_kmph: float
    track: Mapping[str, str | float]


@dataclass(frozen=True)
class Day:
    """`turning` is what the sensors say while they are turned over, `driving` during the `drives`
    and the rests between, both at the logger's inputs; `vehicle` is the text of vehicle.toml."""

    title: str
    turning: Signals
    driving: Signals
    drives: tuple[Drive, ...]
    vehicle: str


def drive_lines(drives: Iterable[Drive]) -> tuple[str, ...]:
    """Of each drive its track and speed, in the words in which `wheelhop campaign add` asks."""
    return tuple(
        f"{drive.id} ({drive.role}): --track"
        f" {' '.join([str(drive.track['kind']), *_numbers(drive.track)])}"
        f" --speed-kmph {drive.speed_kmph:g}"
        for drive in drives
    )


def _numbers(track: Mapping[str, str | float]) -> list[str]:
    return [f"{key}={value:g}" for key, value in track.items() if not isinstance(value, str)]


def read_day(name: str = EIGHT_DRIVES) -> Day:
    """Read a day that comes with wheelhop."""
    with as_file(files("wheelhop.hil_sim") / name) as folder:
        return _read(folder)


def _read(folder: Path) -> Day:
    with np.load(folder / "voltages.npz") as stored:
        volts = {key: stored[key] * STEP_V for key in stored.files}
    plan = tomllib.loads((folder / "drives.toml").read_text(encoding="utf-8"))
    up, down = volts["flip-up"], volts["flip-down"]
    rest = up[: round(REST_S * RATE_HZ)]
    drives = tuple(Drive(**drive) for drive in plan["drive"])
    between = [piece for drive in drives for piece in (volts[drive.id], rest)]
    return Day(
        plan["title"],
        # Turned over and over: a host that begins late also ends late, and inputs that stand still
        # have no noise to tell their level by.
        turning=_signals(np.concatenate([up, down, up, down]), repeat=True),
        driving=_signals(np.concatenate([rest] * LEAD_RESTS + between)),
        drives=drives,
        vehicle=(folder / "vehicle.toml").read_text(encoding="utf-8"),
    )


def _signals(volts: NDArray[np.float64], *, repeat: bool = False) -> Signals:
    from scipy.signal import resample_poly  # takes long to import

    finer = resample_poly(volts, FINER, 1, padtype="line")
    return from_volts(finer, RATE_HZ * FINER, repeat=repeat)
