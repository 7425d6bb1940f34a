"""Prescribed motion: what of a measured one is drift, and the path of a wheel over the track."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import interpolate

from wheelhop.simulate.model import Model
from wheelhop.track import Wheel, WheelPath

Array = NDArray[np.float64]


def slow_part(time_s: Array, height: Array, spacing_s: float) -> interpolate.BSpline:
    """Least-squares cubic spline with knots one period of the band's lower edge apart: it follows
    what drifts, constants of integration included, and leaves what lies in band. Unlike a filter
    it has no transient at the ends."""
    count = max(int((time_s[-1] - time_s[0]) / spacing_s), 1)
    inner = np.linspace(time_s[0], time_s[-1], count + 1)
    knots = np.concatenate([[inner[0]] * 3, inner, [inner[-1]] * 3])
    return interpolate.make_lsq_spline(time_s, height, knots, k=3)


def span(x: Array) -> tuple[float, float]:
    """A stretch of track around x whose ends stay put when x moves a little."""
    return math.floor(x.min() / 5.0 - 0.2) * 5.0, math.ceil(x.max() / 5.0 + 0.2) * 5.0


def wheel_path(model: Model, corner: int, wheel: Wheel) -> WheelPath:
    """What an effect makes of the wheel's path, else that of a rigid wheel."""
    for effect in model.effects:
        path = effect.wheel_path(model.theta(effect), corner, wheel)
        if path is not None:
            return path
    return wheel.rigid()
