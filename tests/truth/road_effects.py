"""Effects upstream of the axle: forward speed, tyre, wheel."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, pi, sqrt

import numpy as np

from .effect import Effect
from .model import Drive
from .tracks import GRID_M, Array, Track, Wheel, WheelPath, elevation, roll_disc
from .vehicle import axle, tyre_static_load


@dataclass
class SpeedFluctuation(Effect):
    """v(t) = v (1 + three sines of random share, period and phase), amplitudes summing to fraction.

    So `fraction` is the largest deviation there can be; the long-time rms is 0.41 to 0.48 of it.
    """

    id = "speed-fluctuation"
    fraction: float
    period_min_s: float = 2.5
    period_max_s: float = 6.0

    def steer(self, drive: Drive) -> None:
        omega = 2.0 * pi / drive.rng.uniform(self.period_min_s, self.period_max_s, 3)
        phase = drive.rng.uniform(0.0, 2.0 * pi, 3)
        share = drive.rng.uniform(0.3, 1.0, 3)
        amplitude = self.fraction * drive.speed_m_s * share / share.sum()
        ahead = np.cos(phase) - np.cos(np.outer(drive.time, omega) + phase)
        drive.path += (ahead @ (amplitude / omega))[:, None]


@dataclass
class LeftRightDrift(Effect):
    """The right wheels travel further than the left: by a fraction of the way, and a slow wander.

    The vehicle's speed is the mean of its two sides'. The difference is zero at time 0.
    """

    id = "left-right-drift"
    rate: float  # extra way of the right wheels over the left, per way of the vehicle
    wander_m: float = 0.0  # amplitude
    wander_period_s: float = 8.0

    def steer(self, drive: Drive) -> None:
        middle = drive.path.mean(axis=1)
        phase = drive.rng.uniform(0.0, 2.0 * pi)
        wander = np.sin(2.0 * pi * drive.time / self.wander_period_s + phase) - np.sin(phase)
        travelled = middle - np.interp(0.0, drive.time, middle)
        lead = self.rate * travelled + self.wander_m * wander
        drive.path[:, 0] -= 0.5 * lead
        drive.path[:, 1] += 0.5 * lead


@dataclass
class TyreEnvelope(Effect):
    """The tyre averages over its contact length, evenly: the path of the rigid wheel's centre, the
    ground that a rigid wheel then rolls over, or the ground alone."""

    id = "tyre-envelope"
    front_m: float
    rear_m: float
    averages: str = "path"  # "path", "ground" or "footprint"

    def roll(self, wheel: Wheel) -> Array:
        length = self.front_m if wheel.corner < 2 else self.rear_m
        half, margin = ceil(length / GRID_M), ceil(wheel.radius / GRID_M)
        first = float(wheel.x.min()) - GRID_M * (half + margin)
        count = ceil(float(np.ptp(wheel.x)) / GRID_M) + 1 + 2 * (half + margin)
        z = elevation(wheel.track, first + GRID_M * np.arange(count), wheel.y)
        weight = self.pressure(GRID_M * np.abs(np.arange(-half, half + 1)), length)
        weight /= weight.sum()
        if self.averages == "path":
            height = np.convolve(roll_disc(z, wheel.radius), weight, mode="valid")
        else:
            height = np.convolve(z, weight, mode="valid")
            height = (
                roll_disc(height, wheel.radius) if self.averages == "ground" else height[margin:]
            )
        return WheelPath(float(wheel.x.min()), height)(wheel.x)

    def pressure(self, away: Array, length: float) -> Array:
        """How much a point of the grid counts, so far from the contact's middle: by how much of its
        cell lies under the contact."""
        return np.clip((length - 2.0 * away) / GRID_M + 1.0, 0.0, 2.0)


@dataclass
class SmallScaleRoughness(Effect):
    """A random height on top of the track, of spectral density C W^-w per rad/m, W in rad/m.

    Every run has its own; `likeness` is the coherence of the left and the right path. The ground
    carries waves from 0.05 to 10 cycles/m, and the wheel rolls over it as over the track.
    """

    id = "small-scale-roughness"
    unevenness_m3: float
    waviness: float = 2.0
    likeness: float = 0.0

    def pave(self, track: Track, drive: Drive) -> Track:
        margin = 1.0 + drive.vehicle["geometry.wheelbase_m"]
        start = float(drive.path.min()) - margin
        length = float(drive.path.max()) + margin - start
        wave = 2.0 * pi * np.arange(ceil(0.05 * length), ceil(10.0 * length)) / length
        size = np.sqrt(2.0 * self.unevenness_m3 * wave**-self.waviness * 2.0 * pi / length)
        common, left, right = drive.rng.normal(size=(3, len(wave), 2)) @ [1.0, 1.0j] / sqrt(2.0)
        alone = sqrt(1.0 - self.likeness)
        points = 128 * len(wave)
        station = start + length / points * np.arange(points)
        waves = np.zeros((2, points // 2 + 1), dtype=complex)
        first = ceil(0.05 * length)
        for path, own in zip(waves, (left, right), strict=True):
            path[first : first + len(wave)] = size * (sqrt(self.likeness) * common + alone * own)
        height = np.fft.irfft(waves, points) * points / 2.0

        def unevenness(x: Array, y: float) -> Array:
            return np.interp(x, station, height[0 if y > 0.0 else 1])

        return replace(track, unevenness=unevenness)


@dataclass
class TyreLiftOff(Effect):
    """The tyre cannot pull: its total force, static load included, is never negative."""

    id = "tyre-lift-off"

    def start(self, drive: Drive) -> None:
        self._load = tyre_static_load(drive.vehicle)

    def tyre(self, force: Array, deflection: Array, rate: Array) -> Array:
        return np.maximum(force, -self._load)


@dataclass
class ProgressiveTyre(Effect):
    """Tyre stiffness k (1 + growth x) at deflection x from rest, never below zero."""

    id = "progressive-tyre"
    growth_per_m: float

    def start(self, drive: Drive) -> None:
        self._stiffness = drive.tyre_stiffness

    def tyre(self, force: Array, deflection: Array, rate: Array) -> Array:
        soft = np.minimum(deflection + 1.0 / self.growth_per_m, 0.0)  # beyond zero stiffness
        bend = 0.5 * self.growth_per_m * (deflection**2 - soft**2)
        return force + self._stiffness * bend


@dataclass
class WheelImbalance(Effect):
    """An eccentric mass on one wheel: vertical force m e W^2 cos(turned angle), W = v / radius, the
    latter what the wheel rolls on, less than its radius by a loaded tyre's give."""

    id = "wheel-imbalance"
    imbalance_kg_m: float  # mass times eccentricity
    corner: float = 1  # 1..4
    rolling: float = 1.0  # the radius it rolls on, over the wheel's

    def start(self, drive: Drive) -> None:
        corner = int(self.corner) - 1
        radius = self.rolling * drive.vehicle[f"wheel.{axle(corner)}.radius_m"]
        angle = drive.path[:, corner % 2] / radius
        spin = np.gradient(angle, drive.time)
        phase = drive.rng.uniform(0.0, 2.0 * pi)
        drive.push(f"A{corner + 1}", self.imbalance_kg_m * spin**2 * np.cos(angle + phase))
