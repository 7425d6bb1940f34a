"""Natural modes of a frame that floats."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg
from scipy.sparse.linalg import LinearOperator, eigsh

from wheelhop.frame.assemble import DOF, FiniteElements, Matrix
from wheelhop.frame.rigid import rigid_modes
from wheelhop.frame.statics import factorised, floating

Array = NDArray[np.float64]

LANCZOS_SHARE = 4
"""Lanczos is asked for at most this fraction of all modes; beyond it a dense solver is faster."""


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes in ascending order, normalised to a modal mass of 1 kg."""

    frequency_hz: Array  #: (k,)
    shape: Array  #: (6n, k), 1/√kg for displacements


def free_modes(elements: FiniteElements, count: int) -> Modes:
    """The lowest `count` elastic modes without supports; fewer if the frame has no more.

    The six rigid modes are known beforehand and taken out of the flexibility matrix that Lanczos's
    method is applied to (`statics.floating`): they can neither be missed nor take an elastic mode's
    place, and no shift is to be chosen.
    """
    size = elements.mass.shape[0]
    count = min(count, size - DOF)
    if LANCZOS_SHARE * (count + DOF) > size:
        squares, shape = linalg.eigh(elements.stiffness.toarray(), elements.mass.toarray())
        squares, shape = squares[DOF : DOF + count], shape[:, DOF : DOF + count]
        rigid = rigid_modes(elements)
        shape = shape - rigid @ (rigid.T @ (elements.mass @ shape))
    else:
        flexibility = floating(elements)
        squares, shape = _lanczos(elements.stiffness, elements.mass, flexibility, count)
    return Modes(np.sqrt(squares) / (2 * np.pi), shape)


def held_modes(stiffness: Matrix, mass: Matrix, count: int) -> Modes:
    """The lowest modes of a structure whose supports have been struck out of its matrices."""
    size = mass.shape[0]
    count = min(count, size)
    if count == 0:
        return Modes(np.zeros(0), np.zeros((size, 0)))
    if LANCZOS_SHARE * count > size:
        squares, shape = linalg.eigh(
            stiffness.toarray(), mass.toarray(), subset_by_index=(0, count - 1)
        )
    else:
        squares, shape = _lanczos(stiffness, mass, factorised(stiffness), count)
    return Modes(np.sqrt(squares) / (2 * np.pi), shape)


def _lanczos(
    stiffness: Matrix, mass: Matrix, flexibility: Callable[[Array], Array], count: int
) -> tuple[Array, Array]:
    """Eigenvalues and mass-normalised vectors, by ARPACK's shift and invert about 0."""
    inverse = LinearOperator(mass.shape, matvec=flexibility, dtype=float)
    # A fixed start makes the result the same every time.
    start = np.random.default_rng(0).standard_normal(mass.shape[0])
    squares, shape = eigsh(
        stiffness, count, mass, sigma=0.0, OPinv=inverse, v0=flexibility(mass @ start)
    )
    order = np.argsort(squares)
    return squares[order], shape[:, order]
