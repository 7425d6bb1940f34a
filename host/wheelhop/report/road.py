"""What a track does to the wheels, over time: ground and wheels' paths (thesis 4.14 and after)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, isinf
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.files import write_picture
from wheelhop.predict.drives import Drive
from wheelhop.report.figures import AFTER, BEFORE, SOFT, WIDTH
from wheelhop.report.svg import STYLE
from wheelhop.track import CannotClimb, Wheel, make_track

Array = NDArray[np.float64]

SHOWN_M, BEFORE_M, RATE_HZ = 8.0, 1.0, 500.0
"""Way that is drawn; a track that begins is met so far on."""


@dataclass(frozen=True)
class RoadWheels:
    """Where a vehicle's wheels roll: radii of front and rear ones, m, how far apart left and right
    ones are, and front and rear ones."""

    radius_m: tuple[float, float]
    apart_m: float
    wheelbase_m: float

    @classmethod
    def of(cls, values: Mapping[str, float]) -> RoadWheels:
        """Those of a vehicle.toml; raises CampaignError for one that has not four."""
        keys = [f"wheel.{end}.radius_m" for end in ("front", "rear")]
        keys += [f"geometry.{name}_m" for name in ("track_width", "wheelbase")]
        missing = [key for key in keys if key not in values]
        if missing:
            raise CampaignError(f"--plot: the vehicle has no {missing[0]}: it takes a full car")
        front, rear, apart, wheelbase = (values[key] for key in keys)
        return cls((front, rear), apart, wheelbase)


WHEELS = RoadWheels((0.2794, 0.2794), 1.18, 1.42)
"""The thesis's: tyres 22x7-10."""


def ground_inputs(drive: Drive, wheels: RoadWheels) -> tuple[Array, Array, Array]:
    """Times (n,), s; heights of the ground and of the wheels' centres (n, 4), m, corner by
    corner, the front wheels at the track's 0 at time 0 or, if it begins there, after `BEFORE_M`.

    Raises CampaignError for ground that a wheel cannot climb.
    """
    track = make_track(drive.track)
    speed = drive.speed_kmph / 3.6
    time_s: Array = np.arange(round(SHOWN_M / speed * RATE_HZ)) / RATE_HZ
    begins = 0.0 if isinf(track.start_m) else BEFORE_M
    ground, paths = np.empty((len(time_s), 4)), np.empty((len(time_s), 4))
    for corner in range(4):
        rear, y = corner >= 2, (0.5 - corner % 2) * wheels.apart_m
        x = speed * time_s - begins - rear * wheels.wheelbase_m
        ground[:, corner] = track.elevation(x, y)
        wheel = Wheel(track, y, wheels.radius_m[rear], float(x[0]), float(x[-1]))
        try:
            paths[:, corner] = wheel.rigid().height_and_slope(x)[0]
        except CannotClimb as error:
            raise CampaignError(f"--plot: {error}") from None
    return time_s, ground, paths


def draw_ground(drives: Sequence[Drive], wheels: RoadWheels, path: Path) -> None:
    """A row for each speed, the left wheels in its left panel. Raises CampaignError, InputError."""
    for drive in drives:
        if not (isfinite(drive.speed_kmph) and drive.speed_kmph > 0.0):
            raise CampaignError(f"--speed {drive.speed_kmph:g}: must be above 0 km/h")
    with mpl.rc_context(STYLE):
        size = (WIDTH, 1.7 * len(drives) + 0.7)
        figure = Figure(figsize=size, layout="constrained")
        grid = figure.subplots(len(drives), 2, sharey=True, squeeze=False)
        for line, drive in zip(grid, drives, strict=True):
            time_s, ground, centres = ground_inputs(drive, wheels)
            for side, (axes, name) in enumerate(zip(line, ("left", "right"), strict=True)):
                axes.plot(
                    time_s, 1e3 * ground[:, side], color=SOFT, lw=0.8, label="ground in front"
                )
                for corner, ink, end in ((side, BEFORE, "front"), (side + 2, AFTER, "rear")):
                    axes.plot(time_s, 1e3 * centres[:, corner], color=ink, label=f"{end} wheel")
                axes.set_xlim(0.0, time_s[-1])
                axes.set_title(f"{name}, {drive.speed_kmph:g} km/h")
            line[0].set_ylabel("height, mm")
        for axes in grid[-1]:
            axes.set_xlabel("time, s")
        figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=3)
    write_picture(path, figure, dpi=130)
