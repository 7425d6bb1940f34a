"""Reduction to the interface points: R. R. Craig, M. C. C. Bampton, "Coupling of substructures for
dynamic analyses", AIAA J. 6 (1968) 1313."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.frame.assemble import DOF, FiniteElements, dofs_of
from wheelhop.frame.modes import held_modes
from wheelhop.frame.statics import factorised, split

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Reduced:
    """A frame in b interface coordinates (six for each point) followed by k fixed-interface modes.

    x = [[1, 0], [Ψ, Φ]] q, Ψ = −Kᵢᵢ⁻¹Kᵢ_b. Stiffness is exact for loads on the interface: its
    coordinates and the modes are not coupled there.
    """

    interface: Mapping[str, int]  #: first of the six coordinates of each point in q
    stiffness: Array  #: (b + k, b + k)
    mass: Array  #: (b + k, b + k)
    basis: Array  #: (6n, b + k): displacements of the whole frame from q

    def free_modes(self) -> tuple[Array, Array]:
        """Frequencies, Hz, and mass-normalised modes (b + k, b + k − 6) without supports."""
        squares, shape = linalg.eigh(self.stiffness, self.mass)
        return np.sqrt(squares[DOF:]) / (2 * np.pi), shape[:, DOF:]


def reduce(elements: FiniteElements, modes: int) -> Reduced:
    """Craig and Bampton's reduction with so many fixed-interface modes."""
    points = list(dict.fromkeys(elements.interface.values()))
    boundary = dofs_of(points)
    inner, _ = split(elements.mass.shape[0], boundary)
    k, m = elements.stiffness, elements.mass
    k_inner = k[inner][:, inner]
    found = held_modes(k_inner, m[inner][:, inner], modes)
    basis = np.zeros((m.shape[0], len(boundary) + len(found.frequency_hz)))
    basis[boundary, : len(boundary)] = np.eye(len(boundary))
    if len(inner):
        static = factorised(k_inner)(k[inner][:, boundary].toarray())
        basis[inner, : len(boundary)] = -static
    basis[inner, len(boundary) :] = found.shape
    stiffness = np.diag(
        np.concatenate([np.zeros(len(boundary)), (2 * np.pi * found.frequency_hz) ** 2])
    )
    # Only interface loads strain the static shapes: K_bb + K_biΨ, without the cancelling terms.
    stiffness[: len(boundary), : len(boundary)] = _symmetric(
        k[boundary] @ basis[:, : len(boundary)]
    )
    interface = {name: DOF * points.index(at) for name, at in elements.interface.items()}
    return Reduced(interface, stiffness, _symmetric(basis.T @ (m @ basis)), basis)


def _symmetric(matrix: Array) -> Array:
    return np.asarray((matrix + matrix.T) / 2)
