"""Effects upstream of the axle: forward speed, tyre, wheel."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from .effect import Effect
from .model import Drive
from .tracks import Array
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
    """An eccentric mass on one wheel: vertical force m e W^2 cos(turned angle), W = v / radius."""

    id = "wheel-imbalance"
    imbalance_kg_m: float  # mass times eccentricity
    corner: float = 1  # 1..4

    def start(self, drive: Drive) -> None:
        corner = int(self.corner) - 1
        angle = drive.path[:, corner % 2] / drive.vehicle[f"wheel.{axle(corner)}.radius_m"]
        spin = np.gradient(angle, drive.time)
        phase = drive.rng.uniform(0.0, 2.0 * pi)
        drive.push(f"A{corner + 1}", self.imbalance_kg_m * spin**2 * np.cos(angle + phase))
