"""Displacements under constant loads: on given supports, or floating."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from wheelhop.frame.assemble import DOF, FiniteElements, Integers, Matrix
from wheelhop.frame.rigid import rigid_modes

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Static:
    """A static solution; columns as those of the loads."""

    displacement: Array  #: (6n,) or (6n, k), m and rad
    reaction: Array  #: the same shape, N and N m: what the supports exert, zero elsewhere


def factorised(matrix: Matrix) -> Callable[[Array], Array]:
    """Solve with a symmetric positive definite sparse matrix, factorised once.

    An ordering for symmetric patterns and no pivoting: SuperLU's advice for such matrices.
    """
    solve: Callable[[Array], Array] = splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    ).solve
    return solve


def split(size: int, held: Integers) -> tuple[Integers, Integers]:
    """Numbers of the free coordinates and of those held, both sorted."""
    free = np.ones(size, dtype=bool)
    free[held] = False
    return np.flatnonzero(free), np.flatnonzero(~free)


def solve_static(elements: FiniteElements, load: Array, held: Integers) -> Static:
    """The frame under loads (6n,) or (6n, k), N and N m, with the coordinates `held` at rest.

    Raises `ValueError` if the supports leave a rigid motion free.
    """
    free, fixed = split(len(load), held)
    motions = rigid_modes(elements)[fixed]
    if np.linalg.matrix_rank(motions) < DOF:
        raise ValueError("the supports leave the frame free to move as a rigid body")
    displacement = np.zeros_like(load, dtype=float)
    displacement[free] = factorised(elements.stiffness[free][:, free])(load[free].astype(float))
    reaction = np.zeros_like(displacement)
    reaction[fixed] = (elements.stiffness[fixed] @ displacement) - load[fixed]
    return Static(displacement, reaction)


def floating(elements: FiniteElements) -> Callable[[Array], Array]:
    """The elastic displacement of a frame that floats, under loads (6n,) or (6n, k).

    The load's rigid part accelerates the frame and is balanced by inertia; the elastic answer is
    orthogonal to the rigid modes in the mass matrix. That is P A Pᵀ with P = 1 − R RᵀM and A the
    flexibility with any one node held: which one does not matter (R. R. Craig, A. J. Kurdila,
    Fundamentals of Structural Dynamics, Wiley 2006: inertia relief).
    """
    rigid = rigid_modes(elements)
    moved = elements.mass @ rigid
    size = len(rigid)
    free, _ = split(size, np.arange(DOF))
    solve = factorised(elements.stiffness[free][:, free])

    def flexibility(load: Array) -> Array:
        balanced = load - moved @ (rigid.T @ load)
        answer = np.zeros_like(balanced)
        answer[free] = solve(balanced[free])
        return np.asarray(answer - rigid @ (moved.T @ answer))

    return flexibility
