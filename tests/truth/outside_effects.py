"""Physics, and a fault of the instrument, that the benchmark hides and no library is told about.

Not among the effects made by name: `write_campaign` takes them as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import mujoco
import numpy as np

from .body_effects import DriverSeat
from .effect import Effect, channel_index
from .model import Car, Drive
from .tracks import Array
from .vehicle import axle, tyre_static_load


@dataclass
class OrificeDamping(Effect):
    """Oil through a fixed orifice: c |v| v `share` / `rate_m_s` beside the linear damping."""

    id = "orifice-damping"
    share: float
    rate_m_s: float

    def start(self, drive: Drive) -> None:
        self._quadratic = self.share * drive.suspension_damping / self.rate_m_s

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        return force + self._quadratic * np.abs(rate) * rate


@dataclass
class DamperFade(Effect):
    """The oil warms up: damping falls by `fade` from the beginning to the end of every record."""

    id = "damper-fade"
    fade: float

    def start(self, drive: Drive) -> None:
        driven = np.clip(drive.time / drive.time[-1], 0.0, 1.0)
        self._lost = np.outer(self.fade * driven, drive.suspension_damping)
        self._step = 0

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        lost = self._lost[self._step]
        self._step += 1
        return force - lost * rate


@dataclass
class BypassDamping(Effect):
    """Ports open and close with the piston's place: damping is (1 + `share`) times what it is at
    rest, `travel_m` away from there, growing with the square of the travel.
    """

    id = "bypass-damping"
    share: float
    travel_m: float

    def start(self, drive: Drive) -> None:
        self._damping = drive.suspension_damping

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        growth = self.share * (compression / self.travel_m) ** 2
        return force + growth * self._damping * rate


@dataclass
class BoucWenSpring(Effect):
    """Smooth hysteresis beside the spring: F = f z, z' = v (1 - |z|^n (b sgn(v z) + 1 - b)) / x_y.

    Y.-K. Wen, Method for random vibration of hysteretic systems, J. Eng. Mech. Div. ASCE 102
    (1976) 249; n = 1 and a yield travel x_y that is much of the suspension's travel.
    """

    id = "bouc-wen-spring"
    force_N: float
    yield_m: float
    shape: float = 0.7

    def start(self, drive: Drive) -> None:
        self._z, self._last = np.zeros(4), np.zeros(4)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        dx = compression - self._last
        self._last = compression
        yielding = self.shape * np.sign(dx * self._z) + 1.0 - self.shape
        self._z = self._z + dx * (1.0 - np.abs(self._z) * yielding) / self.yield_m
        return force + self.force_N * self._z


@dataclass
class TyreHysteresis(Effect):
    """Rubber and cord slide on each other: a spring that slips at `share` of the static load."""

    id = "tyre-hysteresis"
    share: float
    stiffness_ratio: float  # of the sliding spring to the tyre's

    def start(self, drive: Drive) -> None:
        self._limit = self.share * tyre_static_load(drive.vehicle)
        self._stiffness = self.stiffness_ratio * drive.tyre_stiffness
        self._held, self._last = np.zeros(4), np.zeros(4)

    def tyre(self, force: Array, deflection: Array, rate: Array) -> Array:
        trial = self._held + self._stiffness * (deflection - self._last)
        self._held, self._last = np.clip(trial, -self._limit, self._limit), deflection
        return force + self._held


@dataclass
class OutOfRoundness(Effect):
    """One wheel is oval: its radius varies twice a turn by `oval_m`."""

    id = "out-of-roundness"
    oval_m: float
    corner: float  # 1..4

    def start(self, drive: Drive) -> None:
        i = int(self.corner) - 1
        angle = drive.path[:, i % 2] / drive.vehicle[f"wheel.{axle(i)}.radius_m"]
        height = self.oval_m * np.cos(2.0 * angle + drive.rng.uniform(0.0, 2.0 * pi))
        push = drive.tyre_stiffness[i] * height
        push += drive.tyre_damping[i] * np.gradient(height, drive.time)
        drive.push(f"A{i + 1}", push)


@dataclass
class FrameBending(Effect):
    """The frame's first bending mode: all four suspension points rise, the middle sinks."""

    id = "frame-bending"
    freq_hz: float
    zeta: float
    modal_mass_kg: float

    def build(self, car: Car) -> None:
        omega = 2.0 * pi * self.freq_hz
        mode = car.spec.worldbody.add_body(
            name="bending",
            ipos=[0.0, 0.0, 0.0],
            mass=self.modal_mass_kg,
            inertia=[1.0, 1.0, 1.0],
            explicitinertial=True,
        )
        bend = mode.add_joint(name="bend", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
        bend.stiffness = [self.modal_mass_kg * omega**2, 0.0, 0.0]
        bend.damping = [2.0 * self.zeta * self.modal_mass_kg * omega, 0.0, 0.0]
        for i in range(1, 5):
            car.lengths[f"B{i}"]["bend"] = 1.0
            car.lengths[f"S{i}"]["bend"] = -1.0


@dataclass
class UnlatchedPayload(DriverSeat):
    """A fuel tank or a box that sways on its straps, far behind and to one side."""

    id = "unlatched-payload"


@dataclass
class SensorNonlinearity(Effect):
    """One channel reads a + `quadratic_per_m_s2` a^2."""

    id = "sensor-nonlinearity"
    channel: str
    quadratic_per_m_s2: float

    def sense(self, samples: Array) -> Array:
        samples = samples.copy()
        column = samples[:, channel_index(self.channel)]
        samples[:, channel_index(self.channel)] = column + self.quadratic_per_m_s2 * column**2
        return samples
