"""The car's equations written by hand and a force to shake it with, for the tests."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .effect import Effect
from .model import Car, Drive
from .presets import PRESETS
from .vehicle import Vehicle

ATV = dict(PRESETS["atv"].vehicle)


def travel_vectors(vehicle: Vehicle) -> np.ndarray:
    """Rows (4, 7) that give the suspensions' compressions from heave, pitch, roll, four wheels."""
    a, w = vehicle["geometry.cg_to_front_axle_m"], vehicle["geometry.track_width_m"] / 2.0
    b = vehicle["geometry.wheelbase_m"] - a
    body = np.array([[1, -a, w], [1, -a, -w], [1, b, w], [1, b, -w]])
    return np.hstack([-body, np.eye(4)])


def matrices(vehicle: Vehicle) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass, damping and stiffness of the full car by hand: heave, pitch, roll, four wheels."""
    mass = np.zeros((7, 7))
    body = ("mass_kg", "pitch_inertia_kg_m2", "roll_inertia_kg_m2")
    mass[:3, :3] = np.diag([vehicle[f"body.{key}"] for key in body])
    damping, stiffness = np.zeros((7, 7)), np.zeros((7, 7))
    for i, axle in enumerate(("front", "front", "rear", "rear")):
        travel = travel_vectors(vehicle)[i]
        stiffness += vehicle[f"suspension.{axle}.stiffness_N_m"] * np.outer(travel, travel)
        damping += vehicle[f"suspension.{axle}.damping_N_s_m"] * np.outer(travel, travel)
        mass[3 + i, 3 + i] = vehicle[f"wheel.{axle}.unsprung_mass_kg"]
        stiffness[3 + i, 3 + i] += vehicle[f"wheel.{axle}.tyre_stiffness_N_m"]
        damping[3 + i, 3 + i] += vehicle[f"wheel.{axle}.tyre_damping_N_s_m"]
    return mass, damping, stiffness


@dataclass
class Push(Effect):
    """A vertical force on the body at (x, y): a step, or a cosine from the start."""

    x: float
    y: float
    force_N: float
    freq_hz: float = 0.0

    def build(self, car: Car) -> None:
        car.add_body_point(f"push {self.x} {self.y}", self.x, self.y)

    def start(self, drive: Drive) -> None:
        wave = np.cos(2.0 * np.pi * self.freq_hz * drive.time)
        drive.push(f"push {self.x} {self.y}", self.force_N * wave)


def relative(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.linalg.norm(one - other) / np.linalg.norm(other))
