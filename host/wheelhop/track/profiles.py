"""The tracks a campaign can name, one class per kind, and `make_track` that builds them.

Kinds, keys and equations are those of the campaign format. Amplitudes are zero-to-peak.
Left is y > 0; on the centre line, y = 0, a one-sided track is flat.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from wheelhop.campaign import TrackSpec
from wheelhop.track.cobblestone import Cobblestone
from wheelhop.track.random_road import RandomRoad
from wheelhop.track.surveyed import read_survey
from wheelhop.track.track import Array, Track

Side = Literal["both", "left", "right"]


def make_track(spec: TrackSpec) -> Track:
    """The track that a campaign describes.

    Raises `ValueError` for the kind "unknown", which has no shape, and `CampaignError` when the
    file of a surveyed profile cannot be used.
    """
    if spec.kind not in _KINDS:
        raise ValueError(f"a track of kind {spec.kind!r} has no known shape")
    return _KINDS[spec.kind](**spec.values)


@dataclass(frozen=True)
class Flat(Track):
    """z = 0."""

    def _elevation(self, x: Array, y: Array) -> Array:
        return np.zeros(np.broadcast_shapes(x.shape, y.shape))


@dataclass(frozen=True)
class _Waves(Track):
    """Waves of one pitch, without beginning or end."""

    amplitude_m: float
    pitch_m: float

    @property
    def period_m(self) -> float:
        return self.pitch_m


@dataclass(frozen=True)
class Washboard(_Waves):
    """z = A sin(2πx/L), under the wheels of one side or both."""

    side: Side = "both"

    def _elevation(self, x: Array, y: Array) -> Array:
        return self.amplitude_m * np.sin(2 * np.pi * x / self.pitch_m) * _under(self.side, y)


@dataclass(frozen=True)
class Herringbone(_Waves):
    """z = A sin(2π(x - y tan angle)/L): the right side, y < 0, meets each crest earlier."""

    angle_rad: float

    def _elevation(self, x: Array, y: Array) -> Array:
        along = x - y * math.tan(self.angle_rad)
        return self.amplitude_m * np.sin(2 * np.pi * along / self.pitch_m)


@dataclass(frozen=True)
class ChassisTwist(_Waves):
    """z = A · 2(y + offset)/width · sin(2πx/L): the edges in antiphase, straight lines between."""

    width_m: float
    lateral_offset_m: float

    def _elevation(self, x: Array, y: Array) -> Array:
        across = 2 * (y + self.lateral_offset_m) / self.width_m
        return self.amplitude_m * across * np.sin(2 * np.pi * x / self.pitch_m)


@dataclass(frozen=True)
class _Finite(Track):
    """A track of some length, from x = 0."""

    @property
    def start_m(self) -> float:
        return 0.0


@dataclass(frozen=True)
class SineSweep(_Finite):
    """z = A sin φ(x), dφ/dx = 2π/p(x), the pitch p = p₀ + (p₁ - p₀) x/D over the length D.

    Hence φ = 2π D/(p₁ - p₀) · ln(p(x)/p₀). If the last wave is not complete, the track ends with
    a step.
    """

    amplitude_m: float
    pitch_start_m: float
    pitch_end_m: float
    length_m: float

    @property
    def end_m(self) -> float:
        """The length."""
        return self.length_m

    @property
    def edges_m(self) -> tuple[float, ...]:
        """The step at the end."""
        return (self.length_m,)

    def _elevation(self, x: Array, y: Array) -> Array:
        inside = np.clip(x, 0.0, self.length_m)
        stretch = (self.pitch_end_m - self.pitch_start_m) / self.length_m
        waves = inside / self.pitch_start_m
        if stretch:
            waves = np.log1p(stretch * waves) / stretch
        wave = self.amplitude_m * np.sin(2 * np.pi * waves)
        return np.where(inside == x, wave, 0.0) * _under("both", y)


@dataclass(frozen=True)
class HalfSineBump(_Finite):
    """z = A sin(πx/D) for 0 ≤ x ≤ D, under the wheels of one side or both."""

    amplitude_m: float
    length_m: float
    side: Side = "both"

    @property
    def end_m(self) -> float:
        """The length."""
        return self.length_m

    def _elevation(self, x: Array, y: Array) -> Array:
        inside = np.clip(x, 0.0, self.length_m)
        return self.amplitude_m * np.sin(np.pi * inside / self.length_m) * _under(self.side, y)


@dataclass(frozen=True)
class StepBump(_Finite):
    """z = H for 0 ≤ x ≤ W: a rectangular step, W long in the direction of travel."""

    height_m: float
    width_m: float
    side: Side = "both"

    @property
    def end_m(self) -> float:
        """The width."""
        return self.width_m

    @property
    def edges_m(self) -> tuple[float, ...]:
        """The step up and the step down."""
        return (0.0, self.width_m)

    def _elevation(self, x: Array, y: Array) -> Array:
        on_top = (x >= 0.0) & (x <= self.width_m)
        return np.where(on_top, self.height_m, 0.0) * _under(self.side, y)


def _under(side: Side, y: Array) -> Array:
    """1 where the track lies under the wheel path y, else 0."""
    if side == "both":
        return np.ones_like(y)
    return np.where(y > 0.0 if side == "left" else y < 0.0, 1.0, 0.0)


_KINDS: dict[str, Callable[..., Track]] = {  # called with the keys of the campaign, in SI
    "flat": Flat,
    "washboard": Washboard,
    "one-sided-washboard": partial(Washboard, side="left"),
    "herringbone": Herringbone,
    "chassis-twist": ChassisTwist,
    "sine-sweep": SineSweep,
    "half-sine-bump": HalfSineBump,
    "step-bump": StepBump,
    "iso8608": RandomRoad,
    "cobblestone": Cobblestone,
    "profile": read_survey,
}
