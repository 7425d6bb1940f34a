"""What may stand on a mount of its own: driver, engine, battery, payload.

All of it is part of the sprung body's mass and inertia. A mass whose mount is known is taken out of
the body where it stands, and is carried there by a spring and a damper, vertically.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from wheelhop.campaign.channel import ABOARD
from wheelhop.vehicle.assembly import Aboard, Assembly, Body, Coordinate, Node, between
from wheelhop.vehicle.layout import body_inertia, motions


def on_mounts(values: Mapping[str, float]) -> tuple[str, ...]:
    """Those of `ABOARD` whose mount is among a vehicle's numbers; each has a coordinate of its
    name."""
    return tuple(name for name in ABOARD if f"{name}.stiffness_N_m" in values)


def place_of(values: Mapping[str, float], name: str) -> Body:
    """The body's point on which one of `ABOARD` stands: its centre of mass if nothing is said."""
    return Body(values.get(f"{name}.x_m", 0.0), values.get(f"{name}.y_m", 0.0))


def node_of(values: Mapping[str, float], name: str) -> Node:
    """What moves with one of `ABOARD`: itself on its mount, or the body where it stands."""
    return Coordinate(name) if name in on_mounts(values) else place_of(values, name)


def sensor_on(values: Mapping[str, float], name: str) -> Aboard:
    """Where a sensor on one of `ABOARD` moves: with it on a mount, of the vehicle or of an effect,
    else with the body where it stands."""
    return Aboard(name, place_of(values, name))


def add_aboard(parts: Assembly, values: Mapping[str, float]) -> None:
    """Move the masses on mounts from the body onto their springs and dampers."""
    for name in on_mounts(values):
        mass, place = values[f"{name}.mass_kg"], place_of(values, name)
        carried = parts.add_coordinate(name)
        parts.add_mass(((1.0, place),), -mass)
        parts.add_mass(((1.0, carried),), mass)
        mount = values[f"{name}.stiffness_N_m"], values[f"{name}.damping_N_s_m"]
        parts.add_spring(between(carried, place), *mount)


def more_than_there_is(values: Mapping[str, float]) -> bool:
    """Whether the masses on mounts leave the body no mass, or no inertia, of its own."""
    parts = Assembly((), motions(values))
    add_aboard(parts, values)
    mass = parts.system(body_inertia(values)).mass
    return bool(np.linalg.eigvalsh(mass).min() <= 0.0)
