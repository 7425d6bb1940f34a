"""Vehicles: their numbers and their equations of motion."""

from wheelhop.vehicle.assembly import Assembly, Body, Coordinate, Law, System, between
from wheelhop.vehicle.component import component, is_component
from wheelhop.vehicle.flexible_frame import add_frame, car_on_frame, frame_values
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
from wheelhop.vehicle.motion import Motion
from wheelhop.vehicle.mount import mounted
from wheelhop.vehicle.nominal import read_nominal
from wheelhop.vehicle.struts import COMPONENT, Strut, Usual, ends, pairs, struts
from wheelhop.vehicle.vehicle import Vehicle, changed, read_vehicle

__all__ = [
    "COMPONENT",
    "CORNERS",
    "Assembly",
    "Body",
    "Coordinate",
    "Drive",
    "Law",
    "Motion",
    "Strut",
    "System",
    "Usual",
    "Vehicle",
    "add_frame",
    "axle",
    "axle_name",
    "baseline",
    "between",
    "body_corner",
    "car_on_frame",
    "changed",
    "component",
    "corner_position",
    "ends",
    "frame_values",
    "ground",
    "is_component",
    "mounted",
    "pairs",
    "read_nominal",
    "read_vehicle",
    "static_load",
    "static_tyre_load",
    "struts",
    "suspension",
    "tyre",
]
