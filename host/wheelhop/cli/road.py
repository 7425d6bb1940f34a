"""`wheelhop road`: how rough a track is, and a survey of it as a file."""

from __future__ import annotations

from argparse import Namespace
from dataclasses import asdict, replace
from math import inf, isfinite, isinf
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.cli.output import open_console, write_json
from wheelhop.files import check_new
from wheelhop.predict import read_drives
from wheelhop.track import Track, make_track
from wheelhop.track.rdf import write_rdf
from wheelhop.track.roughness import roughness
from wheelhop.track.surveyed import HIGHEST_M, SurveyedGrid, WheelPaths
from wheelhop.track.write import write_grid, write_opencrg, write_paths
from wheelhop.vehicle import read_vehicle

Array = NDArray[np.float64]

LENGTH_M, STEP_M, WIDTH_M = 200.0, 0.02, 1.2
GRID_M = 0.1  # across, of a grid that is written
MOST_STATIONS = 1_000_000
WRITERS = {".csv": write_grid, ".crg": write_opencrg, ".rdf": write_rdf}
"""Of grids, by the file's suffix."""


def run(arguments: Namespace) -> int:
    """Analyse a track and write it if wanted; raises CampaignError."""
    if arguments.out is not None:
        check_new(arguments.out, CampaignError)
    if arguments.figure is not None:
        _plot(arguments)
        if arguments.json is None and arguments.out is None:
            return 0
    (drive, *_) = read_drives([arguments.track], [1.0])
    track = make_track(drive.track)
    step = _own_step(track) if arguments.step is None else arguments.step
    x = _stations(arguments.length, step, track)
    width = WIDTH_M if arguments.width is None else arguments.width
    if not 0.0 < width < inf:
        raise CampaignError(f"--width {width:g}: must be above 0")
    half = width / 2
    across = _across(track, half)
    with np.errstate(all="ignore"):  # what overflows is refused
        height = np.stack([track.elevation(x, y) for y in across], axis=1)
    if not np.abs(height).max() <= HIGHEST_M:
        raise CampaignError(f"{arguments.track}: is higher than {HIGHEST_M:g} m: look at its units")
    console = open_console()
    try:
        found = roughness(height, step)
    except ValueError as error:
        raise CampaignError(f"{arguments.track}: {error}") from None
    low, high = (2 * np.pi / edge for edge in found.band_rad_m[::-1])
    console.print(
        f"C = {found.unevenness_m3:.3g} m³, w = {found.waviness:.3g} (ISO 8608, class"
        f" {found.road_class} at 1 rad/m), fitted to waves of {low:.2g} … {high:.2g} m;"
        f" {found.rms_m * 1e3:.3g} mm rms",
        markup=False,
    )
    if arguments.json:
        about = {"format": 1, "track": arguments.track, "road_class": found.road_class}
        write_json(arguments.json, {**about, **asdict(found)})
    if arguments.out is not None:
        y = np.linspace(-half, half, max(round(width / GRID_M), 1) + 1)
        if arguments.width is None and isinstance(track, SurveyedGrid):
            y = track.y_m
        _write(arguments.out, arguments.grid, track, x, y, half)
        console.print(f"{arguments.out}: {len(x)} stations", markup=False)
    return 0


def _plot(arguments: Namespace) -> None:
    """Draw what the wheels meet."""
    from wheelhop.report.road import WHEELS, RoadWheels, draw_ground

    wheels = WHEELS
    if arguments.vehicle is not None:
        wheels = RoadWheels.of(read_vehicle(arguments.vehicle).values)
    if arguments.width is not None:
        wheels = replace(wheels, apart_m=arguments.width)
    draw_ground(read_drives([arguments.track], arguments.speed), wheels, arguments.figure)
    open_console().print(f"figure: {arguments.figure}", markup=False)


def _own_step(track: Track) -> float:
    """How far apart the stations of a survey are, if they are evenly so."""
    if isinstance(track, (SurveyedGrid, WheelPaths)):
        apart = np.diff(track.x_m)
        if np.ptp(apart) < 1e-6 * apart.max():
            return float(track.end_m / len(apart))
    return STEP_M


def _stations(length: float | None, step: float, track: Track) -> Array:
    """Where heights are asked for: the whole of a track that ends, else `length` of it."""
    if length is None:
        length = LENGTH_M if isinf(track.end_m) else track.end_m
    for option, value in (("length", length), ("step", step)):
        if not (isfinite(value) and value > 0.0):
            raise CampaignError(f"--{option} {value:g}: must be above 0 m")
    count = int(length / step + 1e-9) + 1
    if not 64 <= count <= MOST_STATIONS:
        raise CampaignError(
            f"{count} stations: take 64 to {MOST_STATIONS} by another --length or --step"
        )
    return np.asarray(step * np.arange(count))


def _across(track: Track, half_m: float) -> list[float]:
    """The paths a spectrum is the mean of: those that were surveyed between the wheels, else the
    wheels' own."""
    surveyed = track.y_m if isinstance(track, SurveyedGrid) else np.empty(0)
    return [float(y) for y in surveyed if abs(y) <= half_m] or [-half_m, half_m]


def _write(file: Path, grid: bool, track: Track, x: Array, y: Array, half_m: float) -> None:
    suffix = file.suffix.lower()
    if suffix not in WRITERS:
        raise CampaignError(f"{file}: a survey is written as {', '.join(WRITERS)}")
    if suffix == ".csv" and not grid:
        write_paths(file, x, track.elevation(x, half_m), track.elevation(x, -half_m))
        return
    WRITERS[suffix](file, x, y, np.stack([track.elevation(x, place) for place in y], axis=1))
