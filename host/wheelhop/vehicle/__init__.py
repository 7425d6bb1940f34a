"""Vehicles: their numbers and their equations of motion."""

from wheelhop.vehicle.assembly import Assembly, Body, Coordinate, Law, System, between
from wheelhop.vehicle.full_car import (
    CORNERS,
    Drive,
    axle,
    axle_name,
    baseline,
    body_corner,
    corner_position,
    ground,
    static_load,
    static_tyre_load,
    suspension,
    tyre,
)
from wheelhop.vehicle.struts import Strut, ends, struts
from wheelhop.vehicle.vehicle import Vehicle, read_vehicle

__all__ = [
    "CORNERS",
    "Assembly",
    "Body",
    "Coordinate",
    "Drive",
    "Law",
    "Strut",
    "System",
    "Vehicle",
    "axle",
    "axle_name",
    "baseline",
    "between",
    "body_corner",
    "corner_position",
    "ends",
    "ground",
    "read_vehicle",
    "static_load",
    "static_tyre_load",
    "struts",
    "suspension",
    "tyre",
]
