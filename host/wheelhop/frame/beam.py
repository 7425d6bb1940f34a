"""The straight beam element in space, with shear and rotary inertia, many at a time.

Shear-flexible, two nodes, six coordinates each: displacements (u, v, w) along the local axes x, y,
z, and rotations about them. Its shape functions solve Timoshenko's static equations of an unloaded
beam exactly (Z. Friedman, J. B. Kosmatka, "An improved two-node Timoshenko beam finite element",
Comput. Struct. 47 (1993) 473): nodal displacements under nodal loads are exact, however
long the element, and nothing locks. With Φ = 12 EI / (κ G A L²) → 0 it is Euler–Bernoulli's beam.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)
"""Gauss's rule on (−1, 1), exact for the squares of the cubic shape functions."""

BEND_Y = (1, 5, 7, 11)
"""v₁, θz₁, v₂, θz₂: bending in the plane x–y."""
BEND_Z = (2, 4, 8, 10)
"""w₁, θy₁, w₂, θy₂: bending in the plane x–z, where θy = −dw/dx."""
MIRROR = np.array([1.0, -1.0, 1.0, -1.0])


@dataclass(frozen=True, eq=False)
class Beams:
    """The constants of m elements, each (m,), SI."""

    length: Array  #: L, m
    axial: Array  #: EA, N
    torsion: Array  #: GJ, N m²
    bend_y: Array  #: EIz, N m²: bending in the plane x–y
    bend_z: Array  #: EIy, N m²: bending in the plane x–z
    shear: Array  #: κGA, N
    line_mass: Array  #: ρA, kg/m
    rotary_y: Array  #: ρIy, kg m
    rotary_z: Array  #: ρIz, kg m


def element_matrices(beams: Beams) -> tuple[Array, Array]:
    """Stiffness and consistent mass in the local axes, both (m, 12, 12).

    K = ∫ BᵀDB dx and M = ∫ NᵀRN dx with D = diag(EA, κGA, κGA, GJ, EIy, EIz) and
    R = diag(ρA, ρA, ρA, ρ(Iy + Iz), ρIy, ρIz).
    """
    stiff = np.stack(
        [beams.axial, beams.shear, beams.shear, beams.torsion, beams.bend_z, beams.bend_y], axis=1
    )
    heavy = np.stack(
        [
            *(beams.line_mass,) * 3,
            beams.rotary_y + beams.rotary_z,
            beams.rotary_y,
            beams.rotary_z,
        ],
        axis=1,
    )
    k = np.zeros((len(beams.length), 12, 12))
    m = np.zeros_like(k)
    for point, weight in zip(POINTS.tolist(), WEIGHTS.tolist(), strict=True):
        shape, strain = _shapes(beams, (point + 1) / 2)
        dx = (weight / 2 * beams.length)[:, None, None]
        k += dx * (strain.transpose(0, 2, 1) @ (stiff[:, :, None] * strain))
        m += dx * (shape.transpose(0, 2, 1) @ (heavy[:, :, None] * shape))
    return k, m


def _shapes(beams: Beams, s: float) -> tuple[Array, Array]:
    """At x = sL: displacements and rotations (u, v, w, θx, θy, θz), and strains (u′, γxy, γxz, θx′,
    θy′, θz′), from the nodal coordinates; both (m, 6, 12)."""
    length = beams.length
    shape = np.zeros((len(length), 6, 12))
    strain = np.zeros_like(shape)
    for row in (0, 3):
        shape[:, row, row], shape[:, row, row + 6] = 1 - s, s
        strain[:, row, row], strain[:, row, row + 6] = -1 / length, 1 / length
    for stiffness, (v, theta), columns, sign in (
        (beams.bend_y, (1, 5), BEND_Y, 1.0),
        (beams.bend_z, (2, 4), BEND_Z, -1.0),
    ):
        phi = 12 * stiffness / (beams.shear * length**2)
        deflection, slope, curvature, shear = _bending(length, phi, s)
        mirrored = MIRROR if sign < 0 else np.ones(4)
        shape[:, v, columns] = deflection * mirrored
        shape[:, theta, columns] = sign * slope * mirrored
        strain[:, v, columns] = shear * mirrored
        strain[:, theta, columns] = sign * curvature * mirrored
    return shape, strain


def _bending(length: Array, phi: Array, s: float) -> tuple[Array, Array, Array, Array]:
    """Deflection v, slope θ, curvature θ′ and shear strain v′ − θ from (v₁, θ₁, v₂, θ₂), each
    (m, 4)."""
    one = np.ones_like(length)
    mu = (1 / (1 + phi))[:, None]
    rise = 2 * s**3 - 3 * s**2 - phi * s
    deflection = np.stack(
        [
            rise + 1 + phi,
            length * (s**3 - (2 + phi / 2) * s**2 + (1 + phi / 2) * s),
            -rise,
            length * (s**3 - (1 - phi / 2) * s**2 - phi / 2 * s),
        ],
        axis=1,
    )
    bow = 6 * (s**2 - s) / length
    slope = np.stack(
        [bow, 3 * s**2 - (4 + phi) * s + 1 + phi, -bow, 3 * s**2 - (2 - phi) * s], axis=1
    )
    bend = 6 * (2 * s - 1) / length
    curvature = np.stack([bend, 6 * s - 4 - phi, -bend, 6 * s - 2 + phi], axis=1) / length[:, None]
    shear = -phi[:, None] * np.stack([1 / length, one / 2, -1 / length, one / 2], axis=1)
    return mu * deflection, mu * slope, mu * curvature, mu * shear


def local_axes(along: Array, up: Array) -> Array:
    """Unit vectors x, y, z of each element as rows, (m, 3, 3): x along the tube (m, 3), z as near
    to `up` (m, 3) as it can be."""
    x = along / np.linalg.norm(along, axis=1)[:, None]
    y = np.cross(up, x)
    y /= np.linalg.norm(y, axis=1)[:, None]
    return np.stack([x, y, np.cross(x, y)], axis=1)
