"""Bounce, pitch and roll of a rigid body on its springs, without damping (thesis D.1 to D.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wheelhop.identify import published
from wheelhop.vehicle import kinetic_shares


@dataclass(frozen=True)
class ComponentStiffness:
    """Of the vehicle of chapters 4 and 5 on its components' springs, about the centre of mass:
    against heave, N/m, between heave and pitch, N, and against pitch and roll, N·m."""

    heave_N_m: float
    coupling_N: float
    pitch_N_m: float
    roll_N_m: float


@dataclass(frozen=True)
class BodyMode:
    """A mode of the body. It is named by its shape: by "bounce", "pitch" or "roll", whichever has
    most of its kinetic energy, the share `share`."""

    name: str
    frequency_hz: float
    share: float


def component_stiffness() -> ComponentStiffness:
    """From the published numbers. A spring at half the track from the middle resists roll by
    k (w/2)²; D.4's K_s w² is twice the sum of these if K_s is of one side, else four times."""
    car = published.ATV
    front, rear = 2 * car["front_N_m"], 2 * car["rear_N_m"]
    ahead, behind = car["cg_to_front_axle_m"], car["wheelbase_m"] - car["cg_to_front_axle_m"]
    return ComponentStiffness(
        front + rear,
        rear * behind - front * ahead,
        front * ahead**2 + rear * behind**2,
        (front + rear) * (car["track_width_m"] / 2) ** 2,
    )


def simple_modes(
    mass_kg: float, pitch_inertia_kg_m2: float, roll_inertia_kg_m2: float
) -> tuple[BodyMode, BodyMode, BodyMode]:
    """The lower and the higher mode of heave and pitch (D.2, whose roots are D.3), then roll.

    The thesis calls the higher one bounce. That holds only where heave alone is faster than pitch
    alone.
    """
    on = component_stiffness()
    mass = np.diag([mass_kg, pitch_inertia_kg_m2])
    stiffness = np.array([[on.heave_N_m, on.coupling_N], [on.coupling_N, on.pitch_N_m]])
    squares, shape = np.linalg.eig(np.linalg.solve(mass, stiffness))
    share = kinetic_shares(shape.T, mass)
    lower, higher = (
        BodyMode(
            ("bounce", "pitch")[share[k].argmax()],
            float(np.sqrt(squares[k]) / (2 * np.pi)),
            float(share[k].max()),
        )
        for k in np.argsort(squares)
    )
    roll_hz = float(np.sqrt(on.roll_N_m / roll_inertia_kg_m2) / (2 * np.pi))
    return lower, higher, BodyMode("roll", roll_hz, 1.0)


def implied_body() -> tuple[float, float, float]:
    """Mass, kg, inertia in pitch and in roll, kg m², that have the frequencies of Table D.1:
    `simple_modes` solved for them, the heavier of two bodies.

    The lighter one, in which the higher mode is bounce, has 94 kg: the vehicle has 220.
    """
    on = component_stiffness()
    squares = {k: (2 * np.pi * published.TABLE_D_1[k]) ** 2 for k in ("pitch", "bounce", "roll")}
    # α + γ = ω₁² + ω₂² and α γ - β² M/I = ω₁² ω₂², with α = heave/M and γ = pitch/I.
    product = squares["pitch"] * squares["bounce"]
    both = (on.heave_N_m * on.pitch_N_m - on.coupling_N**2) / product  # M · I
    total = squares["pitch"] + squares["bounce"]
    mass = float(np.roots([on.pitch_N_m / both, -total, on.heave_N_m]).real.max())
    return mass, both / mass, on.roll_N_m / squares["roll"]
