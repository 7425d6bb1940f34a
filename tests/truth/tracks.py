"""Proving-ground tracks and the path of a rigid wheel's centre over them.

The elevation formulas are those of the campaign format. The wheel is a rigid disc: its centre
follows the dilation of the profile by the disc, computed by brute force on a fine grid.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from math import ceil, pi, radians, sqrt, tan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Array = NDArray[np.floating[Any]]

ROAD_M = 1024.0  # after which a random road repeats
GRID_M = 5e-4  # of the profile; a disc of 0.28 m is then placed to better than 1 µm


@dataclass(frozen=True)
class Track:
    """A track of the campaign format: its kind and its keys, units as there (mm, degrees)."""

    kind: str
    keys: dict[str, float | str] = field(default_factory=dict)
    unevenness: Callable[[Array, float], Array] | None = None  # m at x (n,) along y, on top of it

    def metres(self, key: str) -> float:
        """A length given in millimetres under `key`, in metres."""
        return float(self.keys[key + "_mm"]) / 1000.0


def elevation(track: Track, x: Array, y: float) -> Array:
    """Ground height in metres at positions `x` (n,) along the line `y` (left positive)."""
    shape = _SHAPES.get(track.kind)
    if shape is None:
        raise ValueError(f"no track kind {track.kind!r}; known: {', '.join(_SHAPES)}")
    ground = np.where(x > 0.0, shape(track, x, y), 0.0)
    return ground if track.unevenness is None else ground + track.unevenness(x, y)


def wheel_path(track: Track, y: float, radius: float, start: float, end: float) -> WheelPath:
    """Height of a rigid wheel's centre above its height on flat ground, from `start` to `end`.

    h(x) = max over |s| <= R of z(x + s) + sqrt(R^2 - s^2) - R.
    """
    n = ceil((end - start) / GRID_M) + 1
    if track.kind == "flat" and track.unevenness is None:
        return WheelPath(start, np.zeros(n))
    margin = ceil(radius / GRID_M)
    z = elevation(track, start + GRID_M * np.arange(-margin, n + margin), y)
    return WheelPath(start, _rolled(z.tobytes(), radius))


@lru_cache(maxsize=32)  # the wheel paths of a short campaign
def _rolled(ground: bytes, radius: float) -> Array:
    return roll_disc(np.frombuffer(ground), radius)


def roll_disc(z: Array, radius: float) -> Array:
    """Height of a rigid wheel's centre over ground sampled every GRID_M; ends of the ground that
    are one radius long are needed and left out."""
    margin = ceil(radius / GRID_M)
    n = len(z) - 2 * margin
    # no point further off than this can carry the wheel, the ground being only so high and deep
    reach = margin - 1
    if (relief := float(np.ptp(z))) < radius:
        reach = min(reach, ceil(sqrt(2.0 * radius * relief - relief**2) / GRID_M) + 1)
    height = np.full(n, -np.inf)
    for k in range(-reach, reach + 1):
        cap = sqrt(max(radius**2 - (k * GRID_M) ** 2, 0.0)) - radius
        np.maximum(height, z[margin + k : margin + k + n] + cap, out=height)
    return height


@dataclass(frozen=True)
class Wheel:
    """A wheel of some radius on the line `y`, at positions `x` (n,) of its centre, metres."""

    track: Track
    corner: int  # 0..3
    y: float
    radius: float
    x: Array

    def rigid(self) -> Array:
        """Height (n,) of a rigid wheel's centre."""
        low, high = float(self.x.min()), float(self.x.max())
        return wheel_path(self.track, self.y, self.radius, low, high)(self.x)


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


def _iso8608(track: Track, x: Array, y: float) -> Array:
    roughness, waviness = float(track.keys["unevenness_m3"]), float(track.keys["waviness"])
    return np.interp(x % ROAD_M, *_random_road(roughness, waviness, int(track.keys["seed"]), y))


@lru_cache(maxsize=8)
def _random_road(roughness: float, waviness: float, seed: int, y: float) -> tuple[Array, Array]:
    """One period of the road of this seed and its stations.

    The recipe of the campaign format's implementation: 1/1024 cycles/m apart, from 0.01 to 10
    cycles/m, each a plane wave whose phase and, after all phases, slant are drawn in this order.
    """
    line = np.arange(ceil(0.01 * ROAD_M), ceil(10.0 * ROAD_M) + 1)
    wave = 2.0 * pi * line / ROAD_M
    rng = np.random.default_rng(seed)
    phase = rng.uniform(0.0, 2.0 * pi, len(line))
    slant = rng.standard_t(waviness, len(line)) / sqrt(waviness)
    amplitude = np.sqrt(2.0 * roughness * wave**-waviness * (2.0 * pi / ROAD_M))
    points = 1 << 21  # half a millimetre apart
    spectrum = np.zeros(points // 2 + 1, dtype=complex)
    spectrum[line] = 0.5 * points * amplitude * np.exp(1j * (phase + wave * slant * y))
    z = np.fft.irfft(spectrum)
    return ROAD_M / points * np.arange(points + 1), np.append(z, z[0])


def _profile(track: Track, x: Array, y: float) -> Array:
    station, left, right = _survey(str(track.keys["file"]))
    height = left if y > 0.0 else right
    return np.asarray(height(np.clip(x, 0.0, station[-1])))


@lru_cache(maxsize=8)
def _survey(file: str) -> tuple[Array, CubicSpline, CubicSpline]:
    """Stations from 0 and the two wheel paths about their mean height there."""
    with Path(file).open() as lines:
        column = next(lines).strip().split(",").index
        table = np.loadtxt(lines, delimiter=",")
    station = table[:, column("x_m")] - table[0, column("x_m")]
    paths = table[:, [column("left_m"), column("right_m")]]
    paths = paths - paths[0].mean()
    return station, CubicSpline(station, paths[:, 0]), CubicSpline(station, paths[:, 1])


_SHAPES: dict[str, Callable[[Track, Array, float], Array]] = {
    "washboard": _washboard,
    "one-sided-washboard": _one_sided_washboard,
    "herringbone": _herringbone,
    "chassis-twist": _chassis_twist,
    "sine-sweep": _sine_sweep,
    "half-sine-bump": _half_sine_bump,
    "step-bump": _step_bump,
    "iso8608": _iso8608,
    "profile": _profile,
    "flat": lambda track, x, y: np.zeros_like(x),
}
