"""Sweeps: the same drives with numbers that change, every combination of them."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import cache
from pathlib import Path

import numpy as np

from wheelhop.campaign import CampaignError
from wheelhop.campaign.course import Course
from wheelhop.effects import Effect, load_effects
from wheelhop.files import Source, digest
from wheelhop.predict.case import Case
from wheelhop.predict.drives import Word, absolute, read_drives, read_effects
from wheelhop.predict.identity import identity
from wheelhop.predict.ride import Ride, ride
from wheelhop.predict.trouble import lasting
from wheelhop.vehicle import Vehicle, changed

SPEED = "speed"
"""The name under which the speed of all drives is swept, km/h."""
MOST_POINTS = 1_000_000
MEASURES = tuple(field.name for field in fields(Ride))
ASKED = Path("--sweep")

Row = dict[str, float | str | None]


@dataclass(frozen=True)
class Axis:
    """A number that is swept, and its values: SI, or km/h for `speed`."""

    name: str
    values: tuple[float, ...]

    @staticmethod
    def parse(text: str) -> Axis:
        """`NAME=a:b:n`: n values from a to b, equally spaced. Raises CampaignError."""
        name, _, numbers = text.partition("=")
        parts = numbers.split(":")
        try:
            first, last, count = float(parts[0]), float(parts[1]), int(parts[2])
            whole = len(parts) == 3 and bool(name) and math.isfinite(first) and math.isfinite(last)
        except (ValueError, IndexError):
            whole, count = False, 0
        if not (whole and 1 <= count <= MOST_POINTS):
            raise CampaignError(
                f"--sweep {text}: write NAME=FIRST:LAST:COUNT, such as speed=10:40:7"
            )
        return Axis(name, tuple(np.linspace(first, last, count).tolist()))


@dataclass(frozen=True)
class Sweep:
    """What is swept, as plain data that any worker anywhere can begin with.

    `tracks` and `effects` are words as on the command line, `library` the text of a file with
    effects of one's own; however a survey's path is spelt, it is kept as the one that leads there
    from anywhere. Points are numbered with the last axis changing fastest.
    """

    vehicle: Vehicle
    tracks: tuple[str, ...]
    speeds_kmph: tuple[float | Course, ...]
    effects: tuple[str, ...]
    axes: tuple[Axis, ...]
    seconds: float
    seed: int
    library: Source | None = None
    things = "points"

    def __post_init__(self) -> None:
        object.__setattr__(self, "tracks", tuple(map(absolute, self.tracks)))

    def __len__(self) -> int:
        return math.prod(len(axis.values) for axis in self.axes)

    def check(self) -> None:
        """Raise CampaignError for a name that cannot be swept, and for both ends of every axis."""
        if len({axis.name for axis in self.axes}) < len(self.axes):
            raise CampaignError("--sweep: a number is swept twice")
        if len(self) > MOST_POINTS:
            raise CampaignError(f"--sweep: {len(self)} points are more than {MOST_POINTS}")
        for number in (0, len(self) - 1):
            self.case(number)

    def point(self, number: int) -> dict[str, float]:
        """The values of the swept numbers at a point."""
        found: dict[str, float] = {}
        for axis in reversed(self.axes):
            number, place = divmod(number, len(axis.values))
            found[axis.name] = axis.values[place]
        return dict(reversed(found.items()))

    def case(self, number: int) -> Case:
        """What is simulated at a point. All have the same seed, so that what changes is swept."""
        point = self.point(number)
        speeds = (point.pop(SPEED),) if SPEED in point else self.speeds_kmph
        chosen = read_effects(self.effects, _library(self.library))
        for name in [name for name in point if name.partition(".")[0] in _ids(self.effects)]:
            effect, _, parameter = name.partition(".")
            value = {parameter: point.pop(name)}
            chosen = tuple(
                replace(one, values={**one.values, **value}) if one.effect.id == effect else one
                for one in chosen
            )
        vehicle = changed(self.vehicle, point, ASKED)
        return Case(vehicle, chosen, read_drives(self.tracks, speeds), self.seconds, self.seed)

    def rows(self, number: int) -> list[Row]:
        """One row per drive at a point. A simulation that fails leaves its reason as `problem`."""
        point = {name: value for name, value in self.point(number).items() if name != SPEED}
        empty: Row = dict.fromkeys(MEASURES)
        try:
            case = self.case(number)
        except CampaignError as error:
            return [
                {
                    "run": "",
                    "speed_kmph": None,
                    **point,
                    **empty,
                    "problem": lasting(error, self.name(number)),
                }
            ]
        rows: list[Row] = []
        for place, drive in enumerate(case.drives):
            row: Row = {"run": drive.id, "speed_kmph": drive.speed_kmph, **point}
            try:
                rows.append({**row, **vars(ride(case, place)), "problem": ""})
            except CampaignError as error:
                rows.append({**row, **empty, "problem": lasting(error, self.name(number))})
        return rows

    def name(self, number: int) -> str:
        """What a user calls a point."""
        return ", ".join(f"{name} = {value:g}" for name, value in self.point(number).items())

    def files(self, number: int) -> str:
        """Differs where a file differs that a point depends on: they are the same for all."""
        words = [Word.parse(text, "--tracks").options for text in self.tracks]
        files = [Path(str(options["file"])) for options in words if "file" in options]
        own = [] if self.library is None else [self.library.digest]
        return " ".join([*map(digest, files), *own])

    @property
    def fingerprint(self) -> str:
        """Differs where anything differs that the results depend on, files included."""
        known = asdict(replace(self, library=None))
        known |= {"wheelhop": identity(), "files": self.files(0)}
        return hashlib.sha256(json.dumps(known, sort_keys=True).encode()).hexdigest()


@cache
def _library(source: Source | None) -> Mapping[str, Effect]:
    """Read once in each process: looking for installed effects takes longer than a run."""
    return load_effects(source)


def _ids(effects: Sequence[str]) -> set[str]:
    return {Word.parse(text, "--with").name for text in effects}
