"""Drivers and manoeuvres that obey other laws than the textbook's: see other_laws.py."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi

import mujoco
import numpy as np

from .body_effects import CorneringRoll, DriverRocking, LongitudinalPitch
from .model import Car, Drive
from .tracks import Array


@dataclass
class TwoLinkDriver(DriverRocking):
    """A human has a neck: the share `upper` of what sways sways once more on the rest."""

    upper: float = field(kw_only=True)
    upper_hz: float = 6.0
    upper_zeta: float = 0.2

    def build(self, car: Car) -> None:
        super().build(car)
        inertia, omega = self.upper * self.roll_inertia_kg_m2, 2.0 * pi * self.upper_hz
        trunk, rest = car.spec.body("rocking driver"), (1.0 - self.upper) * self.roll_inertia_kg_m2
        trunk.mass = 5e-4
        trunk.inertia = [rest, rest / 2.0, rest / 2.0]
        head = trunk.add_body(
            name="head",
            ipos=[0.0, 0.0, 0.0],
            mass=5e-4,
            inertia=[inertia, inertia / 2.0, inertia / 2.0],
            explicitinertial=True,
        )
        neck = head.add_joint(name="neck", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[1, 0, 0])
        neck.stiffness = [inertia * omega**2, 0.0, 0.0]
        neck.damping = [2.0 * self.upper_zeta * inertia * omega, 0.0, 0.0]


def pulses(drive: Drive, peak: float, every_s: float, length_s: float, rise_s: float) -> Array:
    """Accelerations (m + 1,) of either sign, each as long, that rise and fall within `rise_s`; one
    about every `every_s`."""
    found, begin = np.zeros_like(drive.time), float(drive.time[0])
    while (begin := begin + every_s * drive.rng.uniform(0.6, 1.4)) < drive.time[-1]:
        size = peak * drive.rng.uniform(0.4, 1.0) * drive.rng.choice([-1.0, 1.0])
        inside = np.minimum(drive.time - begin, begin + length_s - drive.time)
        found += size * np.clip(inside / rise_s, 0.0, 1.0)
    return found


@dataclass
class JackedPitch(LongitudinalPitch):
    """Pedals are pressed and let go, and anti-dive geometry carries the share `anti` of the moment
    past the springs: the links lift one axle by what they push down the other, and as the driven
    axle has more of it a tenth of that lifts the body."""

    anti: float = field(kw_only=True)
    every_s: float = 1.5
    length_s: float = 0.7
    rise_s: float = 0.15

    def build(self, car: Car) -> None:
        super().build(car)
        car.add_length("lifted", {"heave": 1.0})

    def start(self, drive: Drive) -> None:
        forward = pulses(drive, self.peak_m_s2, self.every_s, self.length_s, self.rise_s)
        moment = drive.vehicle["body.mass_kg"] * drive.vehicle["geometry.cg_height_m"] * forward
        drive.push("nose down", -(1.0 - self.anti) * moment)
        drive.push("lifted", 0.1 * self.anti * moment / drive.vehicle["geometry.wheelbase_m"])


@dataclass
class LinkedRoll(CorneringRoll):
    """The driver swerves and holds, and the roll axis lies above the road: the share `direct` of
    the moment goes through the links to the wheels, at once."""

    direct: float = field(kw_only=True)
    every_s: float = 1.5
    length_s: float = 0.9
    rise_s: float = 0.2

    def start(self, drive: Drive) -> None:
        left = pulses(drive, self.peak_m_s2, self.every_s, self.length_s, self.rise_s)
        moment = drive.vehicle["body.mass_kg"] * drive.vehicle["geometry.cg_height_m"] * left
        drive.push("right side down", (1.0 - self.direct) * moment)
        each = 0.5 * self.direct * moment / drive.vehicle["geometry.track_width_m"]
        for wheel, side in enumerate((1.0, -1.0, 1.0, -1.0), start=1):
            drive.push(f"A{wheel}", side * each)
