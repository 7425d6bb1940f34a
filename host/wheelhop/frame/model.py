"""A tubular space frame as its file describes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from wheelhop.frame.section import Material, Section

CORNERS = ("FL", "FR", "RL", "RR")
"""Where the suspension meets the frame: front left, front right, rear left, rear right."""

ELEMENT_M = 0.1
"""Beam elements are no longer than this, unless the file says otherwise."""

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Tube:
    """A straight tube between two nodes, joined to them rigidly. `up` is the direction to which the
    section's z axis is nearest; a round tube does not care."""

    start: str
    end: str
    section: str
    up: Point | None = None


@dataclass(frozen=True)
class PointMass:
    """Something heavy fixed to a node, with its moments of inertia about the axes x, y, z there."""

    node: str
    mass_kg: float
    inertia_kg_m2: Point = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Frame:
    """Nodes, the tubes between them, and what they carry: x ahead, y to the left, z up, metres,
    from any origin. `interface` names nodes by what is fixed there; the four `CORNERS` are always
    among them."""

    name: str
    material: Material
    sections: Mapping[str, Section]
    nodes: Mapping[str, Point]
    tubes: tuple[Tube, ...]
    masses: tuple[PointMass, ...]
    interface: Mapping[str, str]
    element_m: float = ELEMENT_M
