"""What a frame does as a rigid body: its mass, centre of gravity and inertia."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.frame.assemble import DOF, FiniteElements

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass, kg, centre of gravity (3,), m, and inertia (3, 3) about it, kg m², off-diagonal terms
    with the sign of a tensor: −∫ x y dm."""

    mass_kg: float
    centre_m: Array
    inertia_kg_m2: Array


def rigid_motions(position: Array, about: Array | None = None) -> Array:
    """Translations along x, y, z and small rotations about axes through a point (default: the
    origin): displacements (6n, 6) of points (n, 3)."""
    arm = position - (np.zeros(3) if about is None else about)
    motions = np.zeros((len(position), DOF, DOF))
    motions[:, :, :] = np.eye(DOF)
    x, y, z = arm.T
    zero = np.zeros_like(x)
    # u = θ × r: columns are θx, θy, θz.
    motions[:, :3, 3:] = np.stack(
        [
            np.stack([zero, z, -y], axis=1),
            np.stack([-z, zero, x], axis=1),
            np.stack([y, -x, zero], axis=1),
        ],
        axis=1,
    )
    return motions.reshape(-1, DOF)


def mass_properties(elements: FiniteElements) -> MassProperties:
    """From the kinetic energy of the six rigid motions, RᵀMR: its blocks are the mass, the first
    and the second moments."""
    motions = rigid_motions(elements.position)
    mass = float(motions[:, 0] @ (elements.mass @ motions[:, 0]))
    moments = motions.T @ (elements.mass @ motions)
    # The lower left block is m [r×]: its entries are the first moments.
    centre = np.array([moments[5, 1], moments[3, 2], moments[4, 0]]) / mass
    about = rigid_motions(elements.position, centre)
    inertia = (about.T @ (elements.mass @ about))[3:, 3:]
    return MassProperties(mass, centre, np.asarray((inertia + inertia.T) / 2))


def rigid_modes(elements: FiniteElements) -> Array:
    """The six rigid motions (6n, 6), orthonormal in the mass matrix: heave, pitch and roll among
    them, mixed."""
    about = rigid_motions(elements.position, mass_properties(elements).centre_m)
    factor = np.linalg.cholesky(about.T @ (elements.mass @ about))
    return np.asarray(np.linalg.solve(factor, about.T).T)
