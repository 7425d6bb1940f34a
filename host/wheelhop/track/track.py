"""What every track is: an elevation z(x, y) in metres."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class Track(ABC):
    """The shape of the ground, x forward, y to the left, z up, in metres.

    A track of finite length is flat before `start_m` and after `end_m`.
    """

    def elevation(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Elevation, m, at the points (x, y), m; x and y broadcast against each other."""
        return self._elevation(np.asarray(x, np.float64), np.asarray(y, np.float64))

    @property
    def period_m(self) -> float | None:
        """Longitudinal period of a track that repeats for ever, both ways; else None."""
        return None

    @property
    def start_m(self) -> float:
        """Where the track begins, -inf for one without end."""
        return -math.inf

    @property
    def end_m(self) -> float:
        """Where the track ends, inf for one without end."""
        return math.inf

    @property
    def edges_m(self) -> tuple[float, ...]:
        """Places x of the sharp edges of the profile, on which a wheel can pivot.

        The wheel envelope samples the profile; these are the points it must not miss.
        """
        return ()

    @abstractmethod
    def _elevation(self, x: Array, y: Array) -> Array:
        """`elevation`, for arrays."""
