"""Where a force can act."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Literal

from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.vehicle import (
    CORNERS,
    Body,
    Coordinate,
    axle_name,
    between,
    is_component,
    on_mounts,
    place_of,
    strut_at,
    tyre,
    wheels,
)
from wheelhop.vehicle.assembly import Row

CORNER_NAMES = ("front left", "front right", "rear left", "rear right")

Kind = Literal["strut", "tyre", "mount"]
EVERY = "all"

SEAT = "driver-seat"
"""The effect that puts the driver on a mount where the vehicle's file has none."""
MOUNTS = {"driver": "driver's seat"}
USUAL_DRIVER_KG = 75.0


@dataclass(frozen=True)
class Where:
    """A place: the struts or tyres of these corners, which share one law; on a rig the component,
    corner 0; or the mount that carries `aboard`."""

    name: str
    kind: Kind
    corners: tuple[int, ...] = ()
    aboard: str = ""

    @property
    def in_words(self) -> str:
        """The name as a sentence has it."""
        return self.name if self.name.startswith(EVERY) else f"the {self.name}"

    def rows(self, vehicle: Mapping[str, float]) -> list[Row]:
        """The extensions along which the force acts."""
        if self.kind == "mount":
            if self.on_seat(vehicle) and not is_there(vehicle):
                return []
            return [between(Coordinate(self.aboard), self.foot(vehicle))]
        if self.kind == "tyre":
            return [tyre(i) for i in self.corners]
        return [strut_at(vehicle, i).row for i in self.corners]

    def ends(self) -> list[tuple[str, Where]]:
        """The axles of a place across both, each with the beginning of its numbers' names; else the
        place alone."""
        if len(self.corners) < len(CORNERS):
            return [("", self)]
        both = (("front", self.corners[:2]), ("rear", self.corners[2:]))
        return [(f"{end}_", Where(f"{end} {self.kind}s", self.kind, own)) for end, own in both]

    def foot(self, vehicle: Mapping[str, float]) -> Body:
        """The body's point on which the mount stands."""
        at = place_of(vehicle, self.aboard)
        return Body(vehicle.get(f"{SEAT}.x_m", 0.0), at.y_m) if self.on_seat(vehicle) else at

    def linear(self, vehicle: Mapping[str, float]) -> tuple[float, float]:
        """Stiffness, N/m, and damping, N s/m, that are there."""
        if self.on_seat(vehicle):
            mass, omega = vehicle[f"{SEAT}.mass_kg"], 2 * pi * vehicle[f"{SEAT}.freq_hz"]
            return mass * omega**2, 2 * vehicle[f"{SEAT}.zeta"] * mass * omega
        if self.kind == "strut":
            strut = strut_at(vehicle, self.corners[0])
            return strut.stiffness_N_m, strut.damping_N_s_m
        tyre = "" if self.kind == "mount" else f"wheel.{axle_name(self.corners[0])}.tyre_"
        key = tyre or f"{self.aboard}."
        return vehicle[f"{key}stiffness_N_m"], vehicle[f"{key}damping_N_s_m"]

    def load_N(self, vehicle: Mapping[str, float]) -> float:
        """The load that is usual for one part of the place."""
        if self.kind == "mount":
            mass = vehicle.get(f"{self.aboard}.mass_kg", USUAL_DRIVER_KG)
            return STANDARD_GRAVITY_M_S2 * vehicle.get(f"{SEAT}.mass_kg", mass)
        return strut_at(vehicle, self.corners[0]).usual.load_N

    def on_seat(self, vehicle: Mapping[str, float]) -> bool:
        """Whether an effect, not the vehicle's file, has the mount."""
        return self.kind == "mount" and self.aboard not in on_mounts(vehicle)


def places(vehicle: Mapping[str, float]) -> list[Where]:
    """Every place where a force can act, the simplest statement first."""
    if is_component(vehicle):
        return [Where("component", "strut", (0,))]
    every = wheels(vehicle)
    groups = {EVERY: every}
    if len(every) == len(CORNERS):
        groups |= {"front": every[:2], "rear": every[2:]}
    both: tuple[Kind, ...] = ("strut", "tyre")
    together = [Where(f"{which} {kind}s", kind, groups[which]) for kind in both for which in groups]
    carried = [*on_mounts(vehicle), *(["driver"] if f"{SEAT}.mass_kg" in vehicle else [])]
    mounts = [Where(MOUNTS.get(name, f"{name}'s mount"), "mount", (), name) for name in carried]
    if len(every) == 1:
        return [*together, *mounts]
    return [*together, *(_alone(corner) for corner in every), *mounts]


def of_axle(where: Where, vehicle: Mapping[str, float]) -> Where:
    """The place on the same axle, or axles, whose motion a law's knots follow."""
    if where.name == "component" or where.kind == "mount":
        return where
    axles = {axle_name(corner) for corner in where.corners}
    same = tuple(corner for corner in wheels(vehicle) if axle_name(corner) in axles)
    return Where(where.name, where.kind, same)


def parts_of(where: Where) -> list[Where]:
    """Axles of a place across both, struts of an axle, each of which is a place of its own; else
    the place as it is."""
    if where.kind == "strut" and len(where.corners) == 2:
        return [_alone(corner) for corner in where.corners]
    return [end for _, end in where.ends()]


def is_there(vehicle: Mapping[str, float]) -> bool:
    """Whether the driver's seat of the effect carries anything."""
    return vehicle[f"{SEAT}.mass_kg"] >= 1e-6 * vehicle["body.mass_kg"]


def _alone(corner: int) -> Where:
    return Where(f"{CORNER_NAMES[corner]} strut", "strut", (corner,))
