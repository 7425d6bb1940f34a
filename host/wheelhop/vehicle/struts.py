"""Struts: what a suspension effect acts on, whether four of them carry a car or one is on a rig."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from wheelhop.vehicle.assembly import Row
from wheelhop.vehicle.full_car import CORNERS, axle_name, static_load, suspension


@dataclass(frozen=True)
class Strut:
    """A spring and damper between two nodes, acting vertically at the wheel.

    ``end`` ("front", "rear") names the parameters it shares with its mirror image; ``row`` is its
    extension, positive in rebound; ``static_load_N`` the weight it carries.
    """

    end: str
    row: Row
    stiffness_N_m: float
    damping_N_s_m: float
    static_load_N: float


def struts(values: Mapping[str, float]) -> tuple[Strut, ...]:
    """The struts of a vehicle, in the order of its corners."""
    return tuple(_corner_strut(values, corner) for corner in CORNERS)


def ends(values: Mapping[str, float]) -> tuple[str, ...]:
    """The names under which struts keep their numbers, each once."""
    return tuple(dict.fromkeys(strut.end for strut in struts(values)))


def _corner_strut(values: Mapping[str, float], corner: int) -> Strut:
    end = axle_name(corner)
    return Strut(
        end,
        suspension(values, corner),
        values[f"suspension.{end}.stiffness_N_m"],
        values[f"suspension.{end}.damping_N_s_m"],
        static_load(values, corner),
    )
