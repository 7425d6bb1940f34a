"""A wheel on its way along a track: rigid, or with a tyre that averages what it rolls over."""

from __future__ import annotations

import math
from collections import OrderedDict
from dataclasses import dataclass, replace
from threading import Lock
from typing import Protocol

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike

from wheelhop.track.envelope import Envelope, wheel_envelope
from wheelhop.track.track import Array, Track

_NO_LENGTH_M = 1e-9  # an average over less than this is the value itself
_FEWEST, _ACROSS_M = 5, 0.01  # lines across a wheel's width: so many, and no farther apart


class WheelPath(Protocol):
    """The path of a wheel's centre, seen from its height on flat ground."""

    def height_and_slope(self, x: ArrayLike) -> tuple[Array, Array]:
        """Height, m, and its derivative along the track, at x, m."""


@dataclass(frozen=True)
class Wheel:
    """A wheel of a radius that rolls along y, its centre going from `low_m` to `high_m`.

    A wheel with a width rolls over the mean of the ground across it. Paths are tabulated once:
    equal wheels share their table.
    """

    track: Track
    y_m: float
    radius_m: float
    low_m: float
    high_m: float
    width_m: float = 0.0

    def rigid(self) -> Envelope:
        """The path of a rigid wheel."""
        ground = _MeanAcross(self.track, self.width_m) if self.width_m else self.track
        return _envelope(ground, self.y_m, self.radius_m, self.low_m, self.high_m)

    def averaged(self, length_m: float) -> WheelPath:
        """The path of a rigid wheel, averaged over a length centred on the wheel."""
        return MovingAverage(self._seen_from(length_m).rigid(), length_m)

    def on_footprint(self, length_m: float) -> WheelPath:
        """The ground itself, averaged over a length centred on the wheel."""
        return MovingAverage(self._seen_from(length_m).without_radius().rigid(), length_m)

    def rigid_changed_as_ground(self, length_m: float) -> WheelPath:
        """The path of a rigid wheel plus what an average over a length changes of the ground."""
        ground = self.without_radius().rigid()
        return _Sum(((1.0, self.rigid()), (1.0, self.on_footprint(length_m)), (-1.0, ground)))

    def over_averaged_ground(self, length_m: float) -> WheelPath:
        """The path of a rigid wheel over ground averaged over a length."""
        ground = _AveragedTrack(self, length_m)
        return _envelope(ground, self.y_m, self.radius_m, self.low_m, self.high_m)

    def without_radius(self) -> Wheel:
        """A point that follows the ground."""
        return replace(self, radius_m=0.0)

    def _seen_from(self, length_m: float) -> Wheel:
        """This wheel with a path long enough to be averaged; in whole metres, so that a
        slightly different length needs no other table."""
        reach = math.ceil(length_m / 2)
        return replace(self, low_m=self.low_m - reach, high_m=self.high_m + reach)


@dataclass(frozen=True)
class MovingAverage:
    """The mean of a path over a length centred on x, exact for the path's polynomials."""

    path: Envelope
    length_m: float

    def height_and_slope(self, x: ArrayLike) -> tuple[Array, Array]:
        """Height, m, and slope of the mean at x, m."""
        if self.length_m < _NO_LENGTH_M:
            return self.path.height_and_slope(x)
        x = np.asarray(x, dtype=np.float64)
        behind, area_behind = self.path.height_and_area(x - self.length_m / 2)
        ahead, area_ahead = self.path.height_and_area(x + self.length_m / 2)
        return (area_ahead - area_behind) / self.length_m, (ahead - behind) / self.length_m


@dataclass(frozen=True)
class _Sum:
    """Several paths, each by its factor."""

    parts: tuple[tuple[float, WheelPath], ...]

    def height_and_slope(self, x: ArrayLike) -> tuple[Array, Array]:
        """Height, m, and slope of the sum at x, m."""
        x = np.asarray(x, dtype=np.float64)
        height, slope = np.zeros_like(x), np.zeros_like(x)
        for factor, path in self.parts:
            one_height, one_slope = path.height_and_slope(x)
            height, slope = height + factor * one_height, slope + factor * one_slope
        return height, slope


@dataclass(frozen=True)
class _MeanAcross(Track):
    """A track averaged over a width across, about every y, by Gauss's quadrature."""

    track: Track
    width_m: float

    @property
    def period_m(self) -> float | None:
        return self.track.period_m

    @property
    def start_m(self) -> float:
        return self.track.start_m

    @property
    def end_m(self) -> float:
        return self.track.end_m

    @property
    def edges_m(self) -> tuple[float, ...]:
        return self.track.edges_m

    def _elevation(self, x: Array, y: Array) -> Array:
        places, weights = leggauss(max(_FEWEST, math.ceil(self.width_m / _ACROSS_M)))
        lines = (
            0.5 * weight * self.track.elevation(x, y + 0.5 * self.width_m * place)
            for place, weight in zip(places, weights, strict=True)
        )
        return np.asarray(sum(lines))


@dataclass(frozen=True)
class _AveragedTrack(Track):
    """The track under a wheel, averaged along x: known under that wheel only."""

    wheel: Wheel
    length_m: float

    @property
    def period_m(self) -> float | None:
        return self.wheel.track.period_m

    @property
    def start_m(self) -> float:
        return self.wheel.track.start_m - self.length_m / 2

    @property
    def end_m(self) -> float:
        return self.wheel.track.end_m + self.length_m / 2

    def _elevation(self, x: Array, y: Array) -> Array:
        wheel = self.wheel
        reach = 2 * wheel.radius_m  # the disc touches ground ahead of and behind its path
        wider = replace(wheel, low_m=wheel.low_m - reach, high_m=wheel.high_m + reach)
        height, _ = wider.on_footprint(self.length_m).height_and_slope(x)
        return np.broadcast_to(height, np.broadcast_shapes(x.shape, y.shape))


class PathTables:
    """Tables of paths, those asked for last: as many as take no more than `room` bytes."""

    def __init__(self, room: int) -> None:
        self.room = room
        self._kept: OrderedDict[tuple[object, ...], Envelope] = OrderedDict()
        self._taken = 0
        self._lock = Lock()

    def __call__(
        self, track: Track, y_m: float, radius_m: float, low_m: float, high_m: float
    ) -> Envelope:
        """`wheel_envelope`, made or kept."""
        key = (track, y_m, radius_m, low_m, high_m)
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        made = wheel_envelope(*key)
        with self._lock:
            if key not in self._kept:  # by another thread, meanwhile
                self._taken += made.nbytes
            self._kept[key] = made
            while self._taken > self.room:
                self._taken -= self._kept.popitem(last=False)[1].nbytes
        return made

    def kept(self) -> list[Envelope]:
        """The paths kept, the last asked for at the end."""
        with self._lock:
            return list(self._kept.values())


_envelope = PathTables(1 << 26)  # the wheels of eight runs of 50 m over random ground
