"""Cobblestones: domed stones in rows, each at a height of its own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from wheelhop.track.track import Array, Track

ROWS, COLUMNS = 128, 64
"""Stones along and across after which the pavement repeats."""
ROUNDED = 0.2
"""Of a stone's length and width, from the joint to where it is flat."""
HIGHEST = 2.5
"""No stone is farther from the mean than so many times the rms."""


@dataclass(frozen=True)
class Cobblestone(Track):
    """Rows of stones across the track, every second one half a stone to the left (running bond).

    On a stone z = f (h + d) − d with d the depth of the joints, h the stone's height, normally
    distributed, and f = s(u) s(v), which rises smoothly from 0 at the joint in the middle between
    two stones to 1. The same seed gives the same pavement, everywhere and at every height.
    """

    height_m: float  # rms over the stones
    seed: float  # a whole number
    stone_length_m: float
    stone_width_m: float
    joint_m: float
    joint_depth_m: float

    @property
    def period_m(self) -> float:
        """Length of all rows."""
        return ROWS * self.stone_length_m

    def _elevation(self, x: Array, y: Array) -> Array:
        row, along = _within(x, self.stone_length_m)
        column, across = _within(y - 0.5 * self.stone_width_m * (row % 2), self.stone_width_m)
        stone = _stones(self.seed)[row % ROWS, column % COLUMNS] * self.height_m
        top = self._rise(along, self.stone_length_m) * self._rise(across, self.stone_width_m)
        return np.asarray(top * (stone + self.joint_depth_m) - self.joint_depth_m)

    def _rise(self, place: Array, size: float) -> Array:
        """s of a place 0 to 1 across a stone and half of the joints around it."""
        from_edge = size * np.minimum(place, 1.0 - place) - self.joint_m / 2
        t = np.clip(from_edge / (ROUNDED * size), 0.0, 1.0)
        return np.asarray(t**2 * (3 - 2 * t))


def _within(position: Array, size: float) -> tuple[NDArray[np.int64], Array]:
    """Which stone, and where on it, 0 to 1."""
    place = position / size
    number = np.floor(place)
    return number.astype(np.int64), place - number


@lru_cache(maxsize=8)
def _stones(seed: float) -> Array:
    """Heights of the stones, rms 1."""
    heights = np.random.default_rng(int(seed)).standard_normal((ROWS, COLUMNS))
    heights = np.clip(heights, -HIGHEST, HIGHEST)
    heights -= heights.mean()
    return np.asarray(heights / np.sqrt(np.mean(heights**2)))
