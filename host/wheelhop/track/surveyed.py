"""Tracks that were measured: heights along two wheel paths (CSV) or on a grid (OpenCRG)."""

from __future__ import annotations

import csv
from abc import abstractmethod
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wheelhop.campaign import CampaignError
from wheelhop.track.opencrg import read_opencrg
from wheelhop.track.track import Array, Track

_COLUMNS = ("x_m", "right_m", "left_m")
_HIGHEST_M = 100.0  # no test track is higher, but damaged binary files are


def read_survey(file: str) -> Track:
    """The surveyed track in `file`: OpenCRG if it ends in .crg, else CSV (see `WheelPaths`).

    x = 0 is the first station, and the mean height there is z = 0. Raises `CampaignError` for a
    file that cannot be read or makes no sense.
    """
    path = Path(file)
    try:
        if path.suffix.lower() == ".crg":
            grid = read_opencrg(path)
            _refuse_absurd(grid.height_m, path, "damaged, probably by an end-of-line conversion")
            heights = _fill(grid.height_m, path)
            return SurveyedGrid(path, grid.u_m - grid.u_m[0], heights - heights[0].mean(), grid.v_m)
        x, heights = _read_csv(path)
        heights -= heights[0].mean()
        _refuse_absurd(heights, path, "heights must be in metres")
        return WheelPaths(path, x - x[0], heights)
    except OSError as error:
        raise CampaignError(f"{path}: {error.strerror}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise CampaignError(f"{path}: not a CSV file of text in UTF-8") from error


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
    if worst > _HIGHEST_M:
        raise CampaignError(f"{path}: a height of {worst:.3g} m: {reason}")


def _read_csv(path: Path) -> tuple[Array, Array]:
    """Stations (n,) and heights (n, 2), right and left."""
    with path.open(newline="", encoding="utf-8-sig") as lines:
        table = csv.reader(lines)
        header = [name.strip() for name in next(table, [])]
        missing = [name for name in _COLUMNS if name not in header]
        if missing:
            raise CampaignError(f"{path}: no column {missing[0]}; needed are x_m, left_m, right_m")
        columns = [header.index(name) for name in _COLUMNS]
        rows: list[list[float]] = []
        for row in table:
            try:
                values = [float(row[column]) for column in columns]
            except (ValueError, IndexError):
                values = [np.nan]
            if not np.isfinite(values).all():
                raise CampaignError(f"{path}: line {table.line_num} needs a number in each column")
            if rows and values[0] <= rows[-1][0]:
                raise CampaignError(f"{path}: line {table.line_num}: x_m must increase")
            rows.append(values)
    if len(rows) < 2:
        raise CampaignError(f"{path}: {len(rows)} stations; a profile needs at least two")
    data = np.array(rows)
    return data[:, 0], data[:, 1:]
