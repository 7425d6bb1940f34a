"""Proving-ground tracks and the path of a rigid wheel's centre over them.

The elevation formulas are those of the campaign format. The wheel is a rigid disc: its centre
follows the dilation of the profile by the disc, computed by brute force on a fine grid.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import ceil, pi, radians, sqrt, tan
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]

GRID_M = 5e-4  # of the profile; a disc of 0.28 m is then placed to better than 1 µm


@dataclass(frozen=True)
class Track:
    """A track of the campaign format: its kind and its keys, units as there (mm, degrees)."""

    kind: str
    keys: dict[str, float | str] = field(default_factory=dict)

    def metres(self, key: str) -> float:
        """A length given in millimetres under `key`, in metres."""
        return float(self.keys[key + "_mm"]) / 1000.0


def elevation(track: Track, x: Array, y: float) -> Array:
    """Ground height in metres at positions `x` (n,) along the line `y` (left positive)."""
    shape = _SHAPES.get(track.kind)
    if shape is None:
        raise ValueError(f"no track kind {track.kind!r}; known: {', '.join(_SHAPES)}")
    return np.where(x > 0.0, shape(track, x, y), 0.0)


def wheel_path(track: Track, y: float, radius: float, start: float, end: float) -> WheelPath:
    """Height of a rigid wheel's centre above its height on flat ground, from `start` to `end`.

    h(x) = max over |s| <= R of z(x + s) + sqrt(R^2 - s^2) - R.
    """
    n = ceil((end - start) / GRID_M) + 1
    if track.kind == "flat":
        return WheelPath(start, np.zeros(n))
    margin = ceil(radius / GRID_M)
    z = elevation(track, start + GRID_M * np.arange(-margin, n + margin), y)
    # no point further off than this can carry the wheel, the ground being only so high and deep
    reach = margin - 1
    if (relief := float(np.ptp(z))) < radius:
        reach = min(reach, ceil(sqrt(2.0 * radius * relief - relief**2) / GRID_M) + 1)
    height = np.full(n, -np.inf)
    for k in range(-reach, reach + 1):
        cap = sqrt(max(radius**2 - (k * GRID_M) ** 2, 0.0)) - radius
        np.maximum(height, z[margin + k : margin + k + n] + cap, out=height)
    return WheelPath(start, height)


@dataclass(frozen=True)
class WheelPath:
    """Tabulated height (n,) of the wheel centre, metres, every GRID_M from `start`."""

    start: float
    height: Array

    def __call__(self, x: Array) -> Array:
        """Height at positions `x` of the wheel centre; linear between grid points."""
        return np.interp((x - self.start) / GRID_M, np.arange(self.height.size), self.height)


def _sine(track: Track, x: Array) -> Array:
    return track.metres("amplitude") * np.sin(2.0 * pi * x / track.metres("pitch"))


def _washboard(track: Track, x: Array, y: float) -> Array:
    return _sine(track, x)


def _one_sided_washboard(track: Track, x: Array, y: float) -> Array:
    return _sine(track, x) if y > 0.0 else np.zeros_like(x)


def _herringbone(track: Track, x: Array, y: float) -> Array:
    return _sine(track, x - y * tan(radians(float(track.keys.get("angle_deg", 20.0)))))


def _chassis_twist(track: Track, x: Array, y: float) -> Array:
    width = float(track.keys.get("width_mm", 4000.0)) / 1000.0
    offset = float(track.keys.get("lateral_offset_mm", 0.0)) / 1000.0
    return 2.0 * (y + offset) / width * _sine(track, x)


def _sine_sweep(track: Track, x: Array, y: float) -> Array:
    length, first = track.metres("length"), track.metres("pitch_start")
    growth = (track.metres("pitch_end") - first) / length
    inside = np.clip(x, 0.0, length)
    # dphi/dx = 2 pi / (first + growth x)
    turns = np.log1p(growth * inside / first) / growth if growth else inside / first
    return np.where(x < length, track.metres("amplitude") * np.sin(2.0 * pi * turns), 0.0)


def _on_side(track: Track, y: float) -> bool:
    side = track.keys.get("side", "both")
    return side == "both" or (side == "left") == (y > 0.0)


def _half_sine_bump(track: Track, x: Array, y: float) -> Array:
    length = track.metres("length")
    bump = track.metres("amplitude") * np.sin(pi * x / length)
    return np.where((x < length) & _on_side(track, y), bump, 0.0)


def _step_bump(track: Track, x: Array, y: float) -> Array:
    on_it = (x < track.metres("width")) & _on_side(track, y)
    return np.where(on_it, track.metres("height"), 0.0)


_SHAPES: dict[str, Callable[[Track, Array, float], Array]] = {
    "washboard": _washboard,
    "one-sided-washboard": _one_sided_washboard,
    "herringbone": _herringbone,
    "chassis-twist": _chassis_twist,
    "sine-sweep": _sine_sweep,
    "half-sine-bump": _half_sine_bump,
    "step-bump": _step_bump,
    "flat": lambda track, x, y: np.zeros_like(x),
}
