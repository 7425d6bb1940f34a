"""A vehicle that stands for the thesis's racing car, whose finite-element frame is not published.

A body of 548 kg with heave, pitch and roll on the struts of Table 2.2, and one twisting mode of its
frame. Where its centre of mass lies, its two radii of gyration and how stiffly, heavily and with
what loss the frame twists are not printed: six numbers, chosen so that the sinusoids fitted to its
step responses come nearest to the twelve numbers of Table 2.1, and G₁₁(0) to the printed 0.76. What
else the tables hold, the guesses of Table A.2, wheel hop and the poles of G_red, is then no choice
any more.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from wheelhop.identify import published
from wheelhop.identify.quarter_car import Struts, Wheels, inertia_at_points, on_wheels
from wheelhop.identify.statespace import StateSpace
from wheelhop.identify.steps import refine

Array = NDArray[np.float64]

FIRST = np.array([0.5, 0.5, 0.55, 2.5, 30.0, 0.05])
LEAST = np.array([0.35, 0.3, 0.3, 1.3, 15.0, 0.005])
MOST = np.array([0.65, 1.2, 1.2, 20.0, 200.0, 0.5])

STEP_TIME_S: Array = np.arange(76, dtype=float) * 0.02  # footnote 9 of chapter 2
STEP_FORCE_N = 1000.0
WEIGHTS = np.array([5.0] + [1.0] * 12)
"""Of the `differences`. G₁₁(0) counts five times: modes that ours lacks do not bear on it."""


@dataclass(frozen=True)
class EquivalentVehicle:
    """The six numbers, as parts of half the wheelbase and half the track: the front axle's distance
    from the centre of mass over the wheelbase; radii of gyration in pitch (over the wheelbase) and
    roll (over the track); the twisting stiffness over the struts' own against warp, the frequency,
    rad/s, and the damping ratio of the twist."""

    front: float
    pitch_radius: float
    roll_radius: float
    twist_stiffness: float
    twist_omega: float
    twist_zeta: float

    def body(self) -> StateSpace:
        """S: forces at the four points to their displacements, the wheels held, N to m."""
        struts, stiffness = Struts(*published.TABLE_2_2["old"]), self._twist_N_m
        shape, inertia = self._motions, self._inertia
        m = np.diag(inertia)
        k = shape.T @ np.diag(struts.stiffness) @ shape + np.diag([0, 0, 0, stiffness])
        loss = 2 * self.twist_zeta * self.twist_omega * inertia[3]
        c = shape.T @ np.diag(struts.damping) @ shape + np.diag([0, 0, 0, loss])
        inverse = np.linalg.inv(m)
        a = np.block([[np.zeros((4, 4)), np.eye(4)], [-inverse @ k, -inverse @ c]])
        b = np.vstack([np.zeros((4, 4)), inverse @ shape.T])
        return StateSpace(a, b, np.hstack([shape, np.zeros((4, 4))]), np.zeros((4, 4)))

    def sprung_kg(self) -> Array:
        """The body's inertia at the four points (4, 4)."""
        return inertia_at_points(self._motions, self._inertia)

    @property
    def _motions(self) -> Array:
        """Heave, pitch, roll and twist of the four points (4, 4)."""
        x, y = np.repeat([self.front, self.front - 1.0], 2), np.array([0.5, -0.5, 0.5, -0.5])
        return np.column_stack([np.ones(4), x, y, [1, -1, -1, 1]])

    @property
    def _inertia(self) -> Array:
        """Of these motions (4,)."""
        mass, modal = published.SPRUNG_MASS_KG, self._twist_N_m / self.twist_omega**2
        return np.array([mass, mass * self.pitch_radius**2, mass * self.roll_radius**2, modal])

    @property
    def _twist_N_m(self) -> float:
        """The frame's stiffness against twist."""
        struts = Struts(*published.TABLE_2_2["old"])
        return self.twist_stiffness * float(struts.stiffness.sum())


def step_responses(body: StateSpace) -> Array:
    """Motion (4 forces, 4 points, 76), m, after each force steps up by 1 kN, as in 2.4."""
    return STEP_FORCE_N * body.step(STEP_TIME_S).transpose(2, 1, 0)


def wheels(front_mass_kg: float | None = None) -> Wheels:
    """Table 2.3, with another front unsprung mass if wanted."""
    front, rear = published.TABLE_2_3["front"], published.TABLE_2_3["rear"]
    return Wheels((front_mass_kg or front[0], rear[0]), (front[1], rear[1]), (front[2], rear[2]))


def ground_to_body(body: StateSpace, front_mass_kg: float | None = None) -> StateSpace:
    """G(s) of the car on the new struts of Table 2.2."""
    old, new = (Struts(*published.TABLE_2_2[key]) for key in ("old", "new"))
    return on_wheels(body, old, new, wheels(front_mass_kg))


def differences(vehicle: EquivalentVehicle) -> Array:
    """From the printed numbers, relative (13,): G₁₁(0), then the twelve of Table 2.1."""
    body = vehicle.body()
    responses = step_responses(body)
    static = published.G_11_STATIC[0] / published.G_11_STATIC[1]
    found = [np.array([ground_to_body(body).static()[0, 0] / static - 1.0])]
    for printed in map(np.array, published.TABLE_2_1.values()):
        fitted = refine(STEP_TIME_S, responses, *printed.T, starts_at_rest=False)
        found.append((np.column_stack([fitted.sigma, fitted.omega]) / printed - 1.0).ravel())
    return np.concatenate(found)


@cache
def equivalent_vehicle() -> EquivalentVehicle:
    """The vehicle nearest to the printed numbers, by least squares of the `differences`."""

    def off(numbers: Array) -> Array:
        return WEIGHTS * differences(EquivalentVehicle(*numbers.tolist()))

    found = optimize.least_squares(off, FIRST, bounds=(LEAST, MOST), diff_step=1e-4)
    return EquivalentVehicle(*found.x.tolist())
