"""Effects on the sprung body."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import mujoco
import numpy as np

from .effect import Effect
from .model import Car, Drive
from .tracks import Array
from .vehicle import corner_positions


@dataclass
class DriverSeat(Effect):
    """The driver is a point mass on a vertical spring and damper.

    His mass and what it contributes to the inertias are taken from the sprung body, whose own
    centre of mass moves accordingly: with the seat locked the car is the one of vehicle.toml.
    """

    id = "driver-seat"
    mass_kg: float
    freq_hz: float  # of the mass on the seat, the body held
    zeta: float
    x_m: float  # ahead of the centre of mass of the body with its driver
    y_m: float = 0.0

    def build(self, car: Car) -> None:
        car.take_from_body(self.mass_kg, self.x_m, self.y_m)
        driver = car.body.add_body(
            name="driver",
            pos=[self.x_m, self.y_m, 0.0],
            ipos=[0.0, 0.0, 0.0],
            mass=self.mass_kg,
            inertia=[1e-9, 1e-9, 1e-9],
            explicitinertial=True,
        )
        seat = driver.add_joint(name="seat", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
        omega = 2.0 * pi * self.freq_hz
        seat.stiffness = [self.mass_kg * omega**2, 0.0, 0.0]
        seat.damping = [2.0 * self.zeta * self.mass_kg * omega, 0.0, 0.0]


@dataclass
class DriverRocking(Effect):
    """Part of the body's roll inertia, the driver's upper body, rolls on a spring and damper."""

    id = "driver-rocking"
    roll_inertia_kg_m2: float
    freq_hz: float  # of the driver, the body held
    zeta: float

    def build(self, car: Car) -> None:
        mass = 1e-3  # MuJoCo wants one; it stays at the body's centre of mass
        inertia = self.roll_inertia_kg_m2
        car.take_from_body(mass, 0.0, 0.0)
        car.roll_inertia -= inertia
        car.pitch_inertia -= (
            inertia / 2.0
        )  # a rod's worth, so that the driver is an admissible body
        driver = car.body.add_body(
            name="rocking driver",
            ipos=[0.0, 0.0, 0.0],
            mass=mass,
            inertia=[inertia, inertia / 2.0, inertia / 2.0],
            explicitinertial=True,
        )
        waist = driver.add_joint(name="waist", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[1, 0, 0])
        omega = 2.0 * pi * self.freq_hz
        waist.stiffness = [inertia * omega**2, 0.0, 0.0]
        waist.damping = [2.0 * self.zeta * inertia * omega, 0.0, 0.0]


@dataclass
class FrameTwist(Effect):
    """The frame's first torsional mode: B1 and B4 rise by the modal coordinate, B2 and B3 fall.

    The default modal mass is that of two halves of the body, equal in roll inertia, turning
    against each other: I_roll / (track width / 2)^2.
    """

    id = "frame-twist"
    freq_hz: float  # of the free frame
    zeta: float
    modal_mass_kg: float = 0.0  # 0: the default

    def build(self, car: Car) -> None:
        half_width = car.vehicle["geometry.track_width_m"] / 2.0
        mass = self.modal_mass_kg or car.vehicle["body.roll_inertia_kg_m2"] / half_width**2
        omega = 2.0 * pi * self.freq_hz
        mode = car.spec.worldbody.add_body(
            name="twist",
            ipos=[0.0, 0.0, 0.0],
            mass=mass,
            inertia=[1.0, 1.0, 1.0],
            explicitinertial=True,
        )
        twist = mode.add_joint(name="twist", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
        twist.stiffness = [mass * omega**2, 0.0, 0.0]
        twist.damping = [2.0 * self.zeta * mass * omega, 0.0, 0.0]
        for i, (x, y) in enumerate(corner_positions(car.vehicle), start=1):
            share = float(np.sign(x * y))
            car.lengths[f"B{i}"]["twist"] = share
            car.lengths[f"S{i}"]["twist"] = -share


@dataclass
class EngineVibration(Effect):
    """A vertical force of fixed frequency at the engine, its phase random in each run."""

    id = "engine-vibration"
    force_N: float
    freq_hz: float
    x_m: float
    y_m: float = 0.0

    def build(self, car: Car) -> None:
        car.add_body_point("engine", self.x_m, self.y_m)

    def start(self, drive: Drive) -> None:
        phase = drive.rng.uniform(0.0, 2.0 * pi)
        drive.push("engine", self.force_N * np.sin(2.0 * pi * self.freq_hz * drive.time + phase))


@dataclass
class Sway:
    """An acceleration of three sines, random in share, period and phase, amplitudes summing to
    `peak`: with the velocity and the way that belong to it, the latter zero at time 0."""

    peak: float
    period_min_s: float
    period_max_s: float

    def histories(self, drive: Drive) -> tuple[Array, Array, Array]:
        """Acceleration, velocity and way (m + 1,)."""
        omega = 2.0 * pi / drive.rng.uniform(self.period_min_s, self.period_max_s, 3)
        phase = drive.rng.uniform(0.0, 2.0 * pi, 3)
        share = drive.rng.uniform(0.3, 1.0, 3)
        amplitude = self.peak * share / share.sum()
        angle = np.outer(drive.time, omega) + phase
        way = (np.sin(phase) - np.sin(angle)) @ (amplitude / omega**2)
        return np.sin(angle) @ amplitude, -np.cos(angle) @ (amplitude / omega), way


@dataclass
class LongitudinalPitch(Effect):
    """Inertia m a at the body's height pitches it; the speed follows a, or is held all the same."""

    id = "longitudinal-pitch"
    peak_m_s2: float
    period_min_s: float = 0.7
    period_max_s: float = 2.0
    speed_follows: float = 0.0  # 1: it does

    def build(self, car: Car) -> None:
        car.add_length("nose down", {"pitch": 1.0})

    def steer(self, drive: Drive) -> None:
        sway = Sway(self.peak_m_s2, self.period_min_s, self.period_max_s)
        self._forward, _, way = sway.histories(drive)
        drive.path += self.speed_follows * way[:, None]

    def start(self, drive: Drive) -> None:
        inertia = drive.vehicle["body.mass_kg"] * self._forward
        drive.push("nose down", -drive.vehicle["geometry.cg_height_m"] * inertia)


@dataclass
class CorneringRoll(Effect):
    """Lateral acceleration rolls the body; the wheels follow the curve, or run straight on."""

    id = "cornering-roll"
    peak_m_s2: float
    period_min_s: float = 0.7
    period_max_s: float = 2.0
    path_follows: float = 0.0  # 1: the outer wheels travel further

    def build(self, car: Car) -> None:
        car.add_length("right side down", {"roll": 1.0})

    def steer(self, drive: Drive) -> None:
        sway = Sway(self.peak_m_s2, self.period_min_s, self.period_max_s)
        self._left, across, _ = sway.histories(drive)
        # yaw rate a / v, so the heading is the lateral velocity over v
        turned = self.path_follows * (across - np.interp(0.0, drive.time, across))
        lead = turned / drive.speed_m_s * drive.vehicle["geometry.track_width_m"]
        drive.path[:, 0] -= 0.5 * lead
        drive.path[:, 1] += 0.5 * lead

    def start(self, drive: Drive) -> None:
        inertia = drive.vehicle["body.mass_kg"] * self._left
        drive.push("right side down", drive.vehicle["geometry.cg_height_m"] * inertia)
