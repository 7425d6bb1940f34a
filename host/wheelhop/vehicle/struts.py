"""Struts: what a suspension effect acts on, whether four of them carry a car or one is on a rig."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from wheelhop.vehicle.assembly import Row
from wheelhop.vehicle.component import EXTENSION, is_component
from wheelhop.vehicle.full_car import suspension
from wheelhop.vehicle.layout import axle_name, static_load, wheels

COMPONENT = "strut"
"""The end of the one strut of a component."""


@dataclass(frozen=True)
class Usual:
    """What is usual for a strut: effects take the scales of their parameters from it.

    Those of a car come from its nominal numbers; those of a component from what was recorded, as
    nothing need be known of it beforehand.
    """

    stiffness_N_m: float
    damping_N_s_m: float
    load_N: float
    travel_m: float = 0.05
    speed_m_s: float = 0.2


@dataclass(frozen=True)
class Strut:
    """A spring and damper between two nodes, acting vertically at the wheel.

    ``end`` ("front", "rear"; on a rig "strut") names the parameters it shares with its mirror
    image; ``row`` is its extension, positive in rebound; ``static_load_N`` the weight it carries
    where that extension is 0. On a rig that imposes displacement that is a guess: a force need not
    be measured from zero.
    """

    end: str
    row: Row
    stiffness_N_m: float
    damping_N_s_m: float
    static_load_N: float
    usual: Usual
    load_is_known: bool = True

    @property
    def name(self) -> str:
        """What a parameter of it belongs to, in words."""
        return "the component" if self.end == COMPONENT else f"a {self.end} strut, at the wheel"


def struts(values: Mapping[str, float]) -> tuple[Strut, ...]:
    """The struts of a vehicle, in the order of its corners, or the one of a component."""
    if is_component(values):
        return (_component_strut(values),)
    return tuple(_corner_strut(values, corner) for corner in wheels(values))


def strut_at(values: Mapping[str, float], corner: int) -> Strut:
    """The strut of a corner that has a wheel; corner 0 is the one of a component."""
    if is_component(values):
        return _component_strut(values)
    return _corner_strut(values, corner)


def ends(values: Mapping[str, float]) -> dict[str, Strut]:
    """The names under which struts keep their numbers, each with one of its struts."""
    found: dict[str, Strut] = {}
    for strut in struts(values):
        found.setdefault(strut.end, strut)
    return found


def pairs(values: Mapping[str, float]) -> dict[str, tuple[Strut, Strut]]:
    """Left and right strut of each axle; a component has no mirror image, nor has a wheel of a car
    that does not roll."""
    every = struts(values)
    both = {end: [strut for strut in every if strut.end == end] for end in ends(values)}
    return {end: (found[0], found[1]) for end, found in both.items() if len(found) == 2}


def _corner_strut(values: Mapping[str, float], corner: int) -> Strut:
    end = axle_name(corner)
    stiffness = values[f"suspension.{end}.stiffness_N_m"]
    damping = values[f"suspension.{end}.damping_N_s_m"]
    load = static_load(values, corner)
    return Strut(
        end,
        suspension(values, corner),
        stiffness,
        damping,
        load,
        Usual(stiffness, damping, load),
    )


def _component_strut(values: Mapping[str, float]) -> Strut:
    force, travel, speed = (values[f"rig.{k}"] for k in ("force_N", "travel_m", "speed_m_s"))
    return Strut(
        COMPONENT,
        ((1.0, EXTENSION),),
        values["component.stiffness_N_m"],
        values["component.damping_N_s_m"],
        values.get("rig.static_load_N", 0.0),
        Usual(force / travel, force / speed, force, travel, speed),
        load_is_known="rig.static_load_N" not in values,
    )
