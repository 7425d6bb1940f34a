"""The wheel envelope: the path of the centre of a rigid wheel that rolls over a track.

A wheel of radius R that rests on the profile z has its centre at

    h(x) = max over |s| ≤ R of  z(x + s) + √(R² - s²)  - R

above the height it has on flat ground: the dilation of the profile by a disc. Where the profile's
concave radius exceeds the wheel's, this is the path given by the contact ODE of the thesis
(4.5, 4.6, corrected); where it does not, the wheel rests on two points at once, the ODE has no
solution, and h has a kink between two smooth branches.

The wheel is a thin disc in its own vertical plane: it sees the cut of the track at one y.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wheelhop.track.table import highest, located, looked_up
from wheelhop.track.track import Array, Track

_FINE_M, _COARSE_M = 0.0005, 0.001  # spacing of the table: up to a metre of track, and beyond
_JUMP_STEPS = 2  # a contact that moves further than this while the wheel moves one has jumped
_MISS = 0.02  # by how much of its fall one branch's lead may miss zero at a cell's end
_TINY = 1e-12
# Coefficients of a cubic p(t), lowest first, to those of p(t + 1) and of p(t - 1).
_ONE_CELL_ON = np.array([[1, 1, 1, 1], [0, 1, 2, 3], [0, 0, 1, 3], [0, 0, 0, 1]])
_ONE_CELL_BACK = np.array([[1, -1, 1, -1], [0, 1, -2, 3], [0, 0, 1, -3], [0, 0, 0, 1]])


@dataclass(frozen=True, eq=False)
class Envelope:
    """Height h(x) of the wheel centre above its height on flat ground, and its slope dh/dx.

    A piecewise cubic on cells of equal width; a cell in which the contact jumps from one point to
    another holds two polynomials and the place where they cross, so that kinks stay sharp.
    Made by `wheel_envelope`.
    """

    x_min_m: float  # range asked for, within which h is known; infinite for periodic tracks
    x_max_m: float
    _origin_m: float
    _step_m: float
    _periodic: bool
    _cells: int
    _height: Array  # (cells + splits, 4) a polynomial per cell, then those right of the splits
    _split_cell: NDArray[np.intp]  # (splits,) the cells that change polynomial, in order
    _split_at: Array  # (splits,) and where they do, 0 to 1 across the cell

    @property
    def nbytes(self) -> int:
        """Memory its table takes, in bytes."""
        areas = 8 * len(self._height)  # should they be asked
        return self._height.nbytes + areas + self._split_cell.nbytes + self._split_at.nbytes

    def height(self, x: ArrayLike) -> Array:
        """h at x, both in metres, any shape. Raises ValueError outside the tabulated range."""
        return self.height_and_slope(x)[0]

    def slope(self, x: ArrayLike) -> Array:
        """dh/dx at x, dimensionless, any shape. Raises ValueError outside the tabulated range."""
        return self.height_and_slope(x)[1]

    def height_and_slope(self, x: ArrayLike) -> tuple[Array, Array]:
        """Both at once. Raises ValueError outside the tabulated range."""
        x = np.asarray(x, dtype=np.float64)
        height, slope, _ = looked_up(self._height, *self._locate(self._place(x)))
        return height.reshape(x.shape), slope.reshape(x.shape) / self._step_m

    def height_and_area(self, x: ArrayLike) -> tuple[Array, Array]:
        """h at x and ∫h dx up to there, m and m², from a point that is the same for every x."""
        x = np.asarray(x, dtype=np.float64)
        starts, whole = self._area
        place = self._place(x)
        row, t = self._locate(place)
        height, _, inside = looked_up(self._height, row, t)
        area = starts.take(row) + self._step_m * inside
        if self._periodic:
            area += np.floor(place / self._cells) * whole
        else:
            area += (place - np.clip(place, 0.0, self._cells)) * self._step_m * height
        return height.reshape(x.shape), area.reshape(x.shape)

    @cached_property
    def sharpest_kink(self) -> float:
        """Largest jump of the slope where the contact jumps from one point to another: within a
        cell, or between two (at the bottom of a symmetric trough, for one)."""
        slope = self._height[:, 1:] * (np.array([1.0, 2.0, 3.0]) / self._step_m)
        left, right = slope[: self._cells], slope[self._cells :]
        at_split = _at(left[self._split_cell], self._split_at)
        inside = np.abs(_at(right, self._split_at) - at_split)
        begins, ends = left[:, 0], left.sum(axis=1)
        ends[self._split_cell] = right.sum(axis=1)
        between = np.abs(np.roll(begins, -1) - ends)[: None if self._periodic else -1]
        return float(max(inside.max(initial=0.0), between.max(initial=0.0)))

    @cached_property
    def _area(self) -> tuple[Array, float]:
        """∫h dx from the origin of the table to where each polynomial's t is 0, (cells + splits,),
        and to the end of the table."""
        gain = self._height * (self._step_m / np.arange(1.0, 5.0))
        left, right = gain[: self._cells], gain[self._cells :]
        at_split = self._split_at[:, None] ** np.arange(1, 5)
        change = ((left[self._split_cell] - right) * at_split).sum(axis=1)
        across = left.sum(axis=1)
        across[self._split_cell] = change + right.sum(axis=1)
        start = np.concatenate([[0.0], np.cumsum(across)])
        return np.append(start[:-1], start[self._split_cell] + change), float(start[-1])

    def _place(self, x: Array) -> Array:
        """Cells from the table's origin to each x, (n,)."""
        if not self._periodic and x.size:
            low, high = x.min(), x.max()
            if not (low >= self.x_min_m and high <= self.x_max_m):
                raise ValueError(
                    f"x from {low:g} to {high:g} m leaves the tabulated envelope, "
                    f"{self.x_min_m:g} to {self.x_max_m:g} m"
                )
        return np.asarray((x.ravel() - self._origin_m) / self._step_m)

    def _locate(self, place: Array) -> tuple[NDArray[np.intp], Array]:
        """Row of the polynomial that holds at each place, and where in its cell that is."""
        return located(place, self._cells, self._periodic, self._split_cell, self._split_at)


def _at(polynomials: Array, t: Array | float) -> Array:
    """Values of polynomials (cells, k), the constant first, at t in each."""
    powers = np.power.outer(t, np.arange(polynomials.shape[1]))
    return np.asarray((polynomials * powers).sum(axis=1))


class CannotClimb(ValueError):
    """The ground rises at once by as much as the radius of a rigid wheel, or more."""


def wheel_envelope(
    track: Track, y_m: float, radius_m: float, x_min_m: float, x_max_m: float
) -> Envelope:
    """Envelope of the wheel of radius `radius_m` on the path at `y_m`, for x_min_m ≤ x ≤ x_max_m.

    A track that repeats within this range is tabulated for one period and known for every x.
    Heights are good to 1e-6 m, to 1e-5 m on ground as rough as cobbles and in troughs just as tight
    as the wheel; slopes to 1e-5, but for
    the few cells (of 0.5 mm on washboards) where two contacts are about to become one: 3e-3.
    A wheel without radius is a point that follows the ground.
    Raises CannotClimb if a step is as high as the radius.
    """
    period = track.period_m
    if period is not None and period < x_max_m - x_min_m:
        origin, length, periodic = 0.0, period, True
        x_min_m, x_max_m = -math.inf, math.inf
    else:  # out of a finite track's reach the ground is flat, and the ends of the table hold
        reach = 1.01 * radius_m + 10 * _COARSE_M
        origin = min(max(x_min_m, track.start_m - reach), x_max_m)
        end = max(min(x_max_m, track.end_m + reach), origin)
        length, periodic = max(end - origin, _FINE_M), False
    cells = math.ceil(length / (_FINE_M if length < 1 else _COARSE_M))
    step = length / cells
    x = origin + step * np.arange(-1, cells + 2, dtype=np.float64)  # one cell more at either end
    height, split_cell, split_at = _interpolate(_roll(track, y_m, radius_m, x), step)
    return Envelope(x_min_m, x_max_m, origin, step, periodic, cells, height, split_cell, split_at)


@dataclass(frozen=True, eq=False)
class _Contact:
    """Where the wheel touches when its centre is at x, one entry per x."""

    offset: Array  # s, the contact ahead of the wheel centre, m
    height: Array  # h, m
    slope: Array  # h'


def _roll(track: Track, y: float, radius: float, x: Array) -> _Contact:
    """The wheel's contact at equally spaced x."""
    step = float(x[1] - x[0])
    if radius == 0.0:
        ground = track.elevation(x, y)
        return _Contact(np.zeros_like(x), ground, np.gradient(ground, step))
    z, disc = _within_reach(track, y, radius, x, step)
    index, centre, behind, ahead = _highest(z, disc, len(x))
    # The parabola through the three samples about the highest gives the contact between them.
    bend = np.minimum(behind - 2 * centre + ahead, -_TINY)
    sampled = step * (index - len(disc) // 2)
    s = sampled + step * np.clip(0.5 * (behind - ahead) / bend, -1.0, 1.0)
    height = track.elevation(x + s, y) + _disc(s, radius)
    worse = height < centre  # no parabola: a sharp edge
    s = np.where(worse, sampled, s)
    height = np.where(worse, centre, height)
    for edge in track.edges_m:
        to_edge = edge - x
        top = track.elevation([edge - _TINY, edge + _TINY], y).max()
        on_edge = np.where(np.abs(to_edge) < radius, top + _disc(to_edge, radius), -np.inf)
        s = np.where(on_edge > height, to_edge, s)
        height = np.maximum(on_edge, height)
    return _Contact(s, height, s / np.sqrt(radius**2 - s**2))  # the disc is tangent, or pivots


def _within_reach(
    track: Track, y: float, radius: float, x: Array, step: float
) -> tuple[Array, Array]:
    """Elevations about all x and the disc, both sampled at `step`, as far as contact can occur."""
    reach = math.floor(0.999 * radius / step) - 1
    u = x[0] + step * np.arange(-reach, len(x) + reach)
    z = track.elevation(u, y)
    rise = np.abs(np.diff(z))
    if rise.max() >= radius:
        raise CannotClimb(f"a step of {rise.max():.3g} m is too high for a wheel of {radius:.3g} m")
    for edge in track.edges_m:  # a step's face touches the wheel with nothing but its edge
        rise[np.abs(u[:-1] + step / 2 - edge) < step] = 0.0
    # At the contact the disc is as steep as the profile: the steepest place bounds |s|.
    steepest = rise.max() / step
    bound = min(reach, math.ceil(radius * steepest / math.hypot(1, steepest) / step) + 2)
    z = z[reach - bound : len(z) - reach + bound]
    return z, _disc(step * np.arange(-bound, bound + 1), radius)


def _disc(s: Array, radius: float) -> Array:
    """√(R² - s²) - R: how much lower the centre may be when the wheel touches at s."""
    return np.sqrt(np.maximum(radius**2 - s**2, 0.0)) - radius


def _highest(z: Array, disc: Array, n: int) -> tuple[NDArray[np.intp], Array, Array, Array]:
    """For each of n points the index of the largest z + disc, its value and its neighbours'."""
    index = highest(z, disc, n)
    index = np.clip(index, 1, len(disc) - 2)
    at = np.arange(n) + index
    return index, z[at] + disc[index], z[at - 1] + disc[index - 1], z[at + 1] + disc[index + 1]


def _interpolate(contact: _Contact, step: float) -> tuple[Array, NDArray[np.intp], Array]:
    """Polynomials (cells + splits, 4) in t, 0 to 1 across a cell, those right of a split behind the
    others; which cells split, and where.

    The contacts reach one cell further than the result at either end.
    """
    h0, h1 = contact.height[:-1], contact.height[1:]
    d0, d1 = contact.slope[:-1] * step, contact.slope[1:] * step
    rise = h1 - h0
    cubic = np.stack([h0, d0, 3 * rise - 2 * d0 - d1, d0 + d1 - 2 * rise], axis=1)
    # h is the highest of all branches. Where the contact jumps, the branch of the cell on the left
    # goes on until that of the cell on the right rises above it; beside a larger jump, a smaller
    # one is but a contact that moves fast.
    move = np.diff(contact.offset)
    largest = (move[1:-1] >= move[:-2]) & (move[1:-1] > move[2:])
    jump = np.flatnonzero(largest & (move[1:-1] > (_JUMP_STEPS - 1) * step))
    left, right = cubic[jump] @ _ONE_CELL_ON.T, cubic[jump + 2] @ _ONE_CELL_BACK.T
    crossing = _crossing(left - right)
    sharp = np.isfinite(crossing)
    polynomials = cubic[1:-1].copy()
    polynomials[jump[sharp]] = left[sharp]
    return np.concatenate([polynomials, right[sharp]]), jump[sharp], crossing[sharp]


def _crossing(lead: Array) -> Array:
    """Where in 0 to 1 the cubics `lead` (n, 4), from positive to negative, cross zero.

    NaN for those that miss it by more than a small part of their fall, as when three branches
    meet within one cell: a plain cubic then smooths them.
    """
    first, last = lead[:, 0], lead.sum(axis=1)
    fall = first - last
    with np.errstate(invalid="ignore", divide="ignore"):
        root = first / fall
        for _ in range(3):  # Newton: the lead is nearly straight
            value = ((lead[:, 3] * root + lead[:, 2]) * root + lead[:, 1]) * root + first
            root -= value / ((3 * lead[:, 3] * root + 2 * lead[:, 2]) * root + lead[:, 1])
    return np.where((first > -_MISS * fall) & (last < _MISS * fall), np.clip(root, 0, 1), np.nan)
