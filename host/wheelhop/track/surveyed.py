"""Tracks that were measured: heights along two wheel paths or on a grid; CSV, OpenCRG, Adams."""

from __future__ import annotations

import csv
from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np

from wheelhop.campaign import CampaignError
from wheelhop.files import read_text
from wheelhop.track.opencrg import read_opencrg
from wheelhop.track.rdf import read_rdf
from wheelhop.track.track import Array, Track

_COLUMNS = ("x_m", "right_m", "left_m")
HIGHEST_M = 100.0
"""No test track is higher, but damaged binary files are."""
NEAREST_M = 1e-6
"""Least distance of stations: as well as the path of a wheel is known."""


def read_survey(file: str) -> Track:
    """The surveyed track in `file`: OpenCRG if it ends in .crg, Adams road data if in .rdf, else
    CSV, whose header says whether it has two wheel paths or a grid.

    x = 0 is the first station, and the mean height there is z = 0. Raises `CampaignError` for a
    file that cannot be read or makes no sense.
    """
    path = Path(file)
    suffix, y = path.suffix.lower(), None
    if suffix == ".crg":
        grid = read_opencrg(path)
        x, heights, y = grid.u_m, grid.height_m, grid.v_m
        reason = "damaged, probably by an end-of-line conversion"
    elif suffix == ".rdf":
        x, heights, y = read_rdf(path)
        reason = "look at LENGTH in [UNITS]"
    else:
        x, heights, y = _read_csv(path)
        reason = "heights must be in metres"
    _refuse_absurd(heights, path, reason)
    with np.errstate(over="ignore"):  # to infinity, which is refused
        x = x - x[0]
    near = np.flatnonzero(~(np.diff(x) >= NEAREST_M))
    if len(near) or not np.isfinite(x[-1]):
        first = int(near[0]) + 2 if len(near) else len(x)
        raise CampaignError(
            f"{path}: station {first}: x, m, must increase by {NEAREST_M:g} at least"
        )
    heights = _fill(heights, path)
    heights = heights - heights[0].mean()
    if y is None:
        return WheelPaths(path, x, heights)
    return SurveyedGrid(path, x, heights, y)


@dataclass(frozen=True, eq=False)
class _Survey(Track):
    """Heights at stations along the track, held constant before the first and after the last.

    Between stations a monotone cubic (PCHIP) keeps slopes continuous and never overshoots: a kerb
    stays a kerb. It cannot know what the survey missed: stations should be no further apart than
    a quarter of the shortest wave that matters, and what is shorter than two must have been
    filtered out before sampling, or it appears as a longer wave.
    """

    file: Path
    x_m: Array  # (n,) stations, increasing from 0
    height_m: Array  # (n, k), one column per line along the track, the leftmost last

    @property
    def start_m(self) -> float:
        return 0.0

    @property
    def end_m(self) -> float:
        return float(self.x_m[-1])

    def _elevation(self, x: Array, y: Array) -> Array:
        from scipy.interpolate import PchipInterpolator  # a quarter of a second that few need

        x, y = np.broadcast_arrays(np.clip(x, 0.0, self.end_m), y)
        z = np.empty(x.shape)
        for path in np.unique(y):
            column, share = self._place(float(path))
            right, left = self.height_m[:, column], self.height_m[:, column + 1]
            heights = (1 - share) * right + share * left
            z[y == path] = PchipInterpolator(self.x_m, heights)(x[y == path])
        return z

    @abstractmethod
    def _place(self, y: float) -> tuple[int, float]:
        """The column to the right of y, and the share, 0 to 1, of the next one in the height."""


@dataclass(frozen=True, eq=False)
class WheelPaths(_Survey):
    """Two measured wheel paths, from a CSV file with the columns x_m, left_m and right_m.

    The left wheels (y > 0) run on `left_m`, the right ones on `right_m`, wherever exactly the
    vehicle's track width puts them; the centre line has their mean.
    """

    def _place(self, y: float) -> tuple[int, float]:
        return 0, 0.5 * (1.0 + float(np.sign(y)))


@dataclass(frozen=True, eq=False)
class SurveyedGrid(_Survey):
    """A measured surface: heights on a grid, linear across the track between its columns."""

    y_m: Array  # (k,) where the columns lie, increasing, positive to the left

    def _place(self, y: float) -> tuple[int, float]:
        if not self.y_m[0] <= y <= self.y_m[-1]:
            raise CampaignError(
                f"{self.file}: the wheel path at y = {y:.2f} m leaves the surveyed strip, "
                f"{self.y_m[0]:.2f} to {self.y_m[-1]:.2f} m; survey a wider one"
            )
        column = min(int(np.searchsorted(self.y_m, y, side="right")), len(self.y_m) - 1) - 1
        width = float(self.y_m[column + 1] - self.y_m[column])
        return column, (y - float(self.y_m[column])) / width


def _fill(height: Array, path: Path) -> Array:
    """Missing heights taken from the neighbours in the same row, beyond the edges from the last.

    That is OpenCRG's own default: wheels that leave the surveyed strip see its edge go on.
    """
    filled = height.copy()
    columns = np.arange(height.shape[1])
    for row in np.flatnonzero(np.isnan(height).any(axis=1)):
        known = np.isfinite(height[row])
        if not known.any():
            raise CampaignError(f"{path}: grid row {row + 1} has no height at all; cut it off")
        filled[row] = np.interp(columns, columns[known], height[row, known])
    return filled


def _refuse_absurd(height: Array, path: Path, reason: str) -> None:
    worst = float(np.nanmax(np.abs(height), initial=0.0))
    if worst > HIGHEST_M:
        raise CampaignError(f"{path}: a height of {worst:.3g} m: {reason}")


def _read_csv(path: Path) -> tuple[Array, Array, Array | None]:
    """Stations (n,), heights (n, k), and the places (k,) of a grid's columns; without places they
    are right and left. In a grid an empty cell is a height nobody measured, NaN."""
    table = _rows(path)
    header = [name.strip() for name in next(table, (1, []))[1]]
    places = _places(header, path)
    names = _COLUMNS if places is None else header
    missing = [name for name in names if name not in header]
    if missing:
        raise CampaignError(
            f"{path}: no column {missing[0]}; needed are x_m, left_m, right_m, or, for a grid,"
            " x_m and the y of each column in metres"
        )
    columns = [header.index(name) for name in names]
    rows: list[list[float]] = []
    for line, row in table:
        try:
            values = [
                np.nan if places is not None and column and not row[column].strip()
                else float(row[column]) for column in columns
            ]  # fmt: skip
        except (ValueError, IndexError):
            values = [np.inf]
        known = [value for value in values if places is None or not np.isnan(value)]
        if not np.isfinite(known).all() or len(known) < 2:
            raise CampaignError(f"{path}: line {line} needs a number in each column")
        if rows and values[0] <= rows[-1][0]:
            raise CampaignError(f"{path}: line {line}: x_m must increase")
        rows.append(values)
    if len(rows) < 2:
        raise CampaignError(f"{path}: {len(rows)} stations; a profile needs at least two")
    data = np.array(rows)
    if places is None:
        return data[:, 0], data[:, 1:], None
    order = np.argsort(places)
    return data[:, 0], data[:, 1:][:, order], places[order]


def _rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    """The rows of a CSV file, each with the line where it ends."""
    table = csv.reader(StringIO(read_text(path, CampaignError), newline=""))
    try:
        for row in table:
            yield table.line_num, row
    except csv.Error as error:
        raise CampaignError(f"{path}: line {table.line_num}: {error}") from None


def _places(header: list[str], path: Path) -> Array | None:
    """Where the columns of a grid lie; None for wheel paths, which have names."""
    try:
        places = np.array([float(name) for name in header[1:]])
    except ValueError:
        return None
    if header[:1] != ["x_m"] or len(places) < 2:
        return None
    if not np.isfinite(places).all() or len(set(places.tolist())) < len(places):
        raise CampaignError(f"{path}: the y of two columns must differ: {', '.join(header[1:])}")
    return places
