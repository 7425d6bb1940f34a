"""From a frame to sparse stiffness and mass matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from wheelhop.frame.beam import Beams, element_matrices, local_axes
from wheelhop.frame.model import CORNERS, Frame, Tube

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Matrix = Any
"""A sparse matrix of scipy, compressed by columns."""

DOF = 6
"""Coordinates of a node: three displacements, m, and three rotations, rad."""


@dataclass(frozen=True, eq=False)
class FiniteElements:
    """A frame cut into elements: n points with six coordinates each, point by point."""

    position: Array  #: (n, 3), m
    node: Mapping[str, int]  #: which point a node of the file is
    interface: Mapping[str, int]  #: which point carries what
    lines: tuple[Integers, ...]  #: the points along each tube
    stiffness: Matrix  #: (6n, 6n), N/m, N, N m
    mass: Matrix  #: (6n, 6n), kg, kg m, kg m²

    @property
    def corners(self) -> Integers:
        """The points of the four `CORNERS`."""
        return np.array([self.interface[corner] for corner in CORNERS])


def assemble(frame: Frame) -> FiniteElements:
    """Cut every tube into equal elements no longer than `element_m` and add them up."""
    position = [np.array(list(frame.nodes.values()), dtype=float)]
    node = {name: i for i, name in enumerate(frame.nodes)}
    lines, count = [], len(node)
    for tube in frame.tubes:
        start, end = (np.array(frame.nodes[name]) for name in (tube.start, tube.end))
        parts = max(1, ceil(float(np.linalg.norm(end - start)) / frame.element_m - 1e-9))
        share = np.arange(1, parts)[:, None] / parts
        position.append(start + share * (end - start))
        inner = np.arange(count, count + parts - 1)
        lines.append(np.array([node[tube.start], *inner, node[tube.end]], dtype=np.int64))
        count += parts - 1
    points = np.vstack(position)
    ends = np.vstack([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
    tubes = [
        tube for tube, line in zip(frame.tubes, lines, strict=True) for _ in range(len(line) - 1)
    ]
    along = points[ends[:, 1]] - points[ends[:, 0]]
    k, m = element_matrices(_beams(frame, tubes, np.linalg.norm(along, axis=1)))
    turn = np.zeros((len(along), 12, 12))
    axes = local_axes(along, _up(tubes, along))
    for i in range(0, 12, 3):
        turn[:, i : i + 3, i : i + 3] = axes
    back = turn.transpose(0, 2, 1)
    dofs = (DOF * ends[:, :, None] + np.arange(DOF)).reshape(-1, 12)
    stiffness = _add_up(back @ k @ turn, dofs, DOF * count)
    mass = _add_up(back @ m @ turn, dofs, DOF * count) + _carried(frame, node, DOF * count)
    interface = {name: node[at] for name, at in frame.interface.items()}
    return FiniteElements(points, node, interface, tuple(lines), stiffness, mass)


def dofs_of(points: Integers | Sequence[int], directions: Sequence[int] = range(DOF)) -> Integers:
    """Numbers of the coordinates of points, point by point; directions 0, 1, 2 are displacements
    along x, y, z and 3, 4, 5 rotations about them."""
    return np.asarray(
        (DOF * np.asarray(points)[:, None] + np.asarray(directions)).ravel(), dtype=np.int64
    )


def _beams(frame: Frame, tubes: Sequence[Tube], length: Array) -> Beams:
    material = frame.material
    sections = [frame.sections[tube.section] for tube in tubes]

    def each(name: str) -> Array:
        return np.array([getattr(section, name) for section in sections], dtype=float)

    area, second_y, second_z = each("area_m2"), each("Iy_m4"), each("Iz_m4")
    return Beams(
        length=length,
        axial=material.young_Pa * area,
        torsion=material.shear_Pa * each("J_m4"),
        bend_y=material.young_Pa * second_z,
        bend_z=material.young_Pa * second_y,
        shear=material.shear_Pa * area * each("shear_coefficient"),
        line_mass=material.density_kg_m3 * area,
        rotary_y=material.density_kg_m3 * second_y,
        rotary_z=material.density_kg_m3 * second_z,
    )


def _up(tubes: Sequence[Tube], along: Array) -> Array:
    """Where z of each section shall point: up, or ahead for upright tubes, if nothing is said."""
    upright = np.linalg.norm(along[:, :2], axis=1) < 1e-6 * np.linalg.norm(along, axis=1)
    usual = np.where(upright[:, None], (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    return np.array(
        [usual[i] if tube.up is None else tube.up for i, tube in enumerate(tubes)], dtype=float
    )


def _add_up(blocks: Array, dofs: Integers, size: int) -> Matrix:
    """The sparse matrix of element matrices (m, 12, 12), exactly symmetric."""
    rows = np.repeat(dofs, 12, axis=1).ravel()
    columns = np.tile(dofs, (1, 12)).ravel()
    whole = (blocks + blocks.transpose(0, 2, 1)) / 2
    return sparse.csc_matrix((whole.ravel(), (rows, columns)), shape=(size, size))


def _carried(frame: Frame, node: Mapping[str, int], size: int) -> Matrix:
    diagonal = np.zeros(size)
    for mass in frame.masses:
        first = DOF * node[mass.node]
        diagonal[first : first + DOF] += (*(mass.mass_kg,) * 3, *mass.inertia_kg_m2)
    return sparse.diags(diagonal, format="csc")
