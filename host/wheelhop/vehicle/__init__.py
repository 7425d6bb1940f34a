"""Vehicles: their numbers and their equations of motion."""

from wheelhop.campaign.channel import ABOARD
from wheelhop.vehicle.aboard import node_of, on_mounts, place_of
from wheelhop.vehicle.assembly import (
    Assembly,
    Body,
    Coordinate,
    Law,
    Reading,
    System,
    between,
    kinetic_shares,
)
from wheelhop.vehicle.component import component, inputs_of, is_component
from wheelhop.vehicle.flexible_frame import car_on_frame, frame_values
from wheelhop.vehicle.full_car import (
    Drive,
    axle,
    baseline,
    body_corner,
    ground,
    suspension,
    tyre,
)
from wheelhop.vehicle.layout import (
    CORNERS,
    MODELS,
    axle_name,
    axles,
    behind_m,
    body_inertia,
    corner_position,
    motions,
    static_load,
    static_tyre_load,
    wheels,
)
from wheelhop.vehicle.measured import Measured
from wheelhop.vehicle.motion import Motion
from wheelhop.vehicle.mount import mounted
from wheelhop.vehicle.nominal import read_nominal
from wheelhop.vehicle.struts import COMPONENT, Strut, Usual, ends, pairs, strut_at, struts
from wheelhop.vehicle.vehicle import Vehicle, changed, read_vehicle, vehicle_in

__all__ = [
    "ABOARD",
    "COMPONENT",
    "CORNERS",
    "MODELS",
    "Assembly",
    "Body",
    "Coordinate",
    "Drive",
    "Law",
    "Measured",
    "Motion",
    "Reading",
    "Strut",
    "System",
    "Usual",
    "Vehicle",
    "axle",
    "axle_name",
    "axles",
    "baseline",
    "behind_m",
    "between",
    "body_corner",
    "body_inertia",
    "car_on_frame",
    "changed",
    "component",
    "corner_position",
    "ends",
    "frame_values",
    "ground",
    "inputs_of",
    "is_component",
    "kinetic_shares",
    "motions",
    "mounted",
    "node_of",
    "on_mounts",
    "pairs",
    "place_of",
    "read_nominal",
    "read_vehicle",
    "static_load",
    "static_tyre_load",
    "strut_at",
    "struts",
    "suspension",
    "tyre",
    "vehicle_in",
    "wheels",
]
