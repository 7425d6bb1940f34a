"""The baseline vehicle: seven degrees of freedom, linear, wheels in permanent contact.

Heave, pitch and roll of a rigid sprung body, four unsprung masses on vertical suspensions and
tyres (thesis section 4.1.2, "simplified Adams model"; equations of motion of this kind are 2.1).
The same parts also make the *axle-driven* vehicle: the axles' motion is imposed, and tyre, track
and speed no longer matter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from wheelhop.campaign import Channel
from wheelhop.vehicle.assembly import Assembly, Body, Coordinate, Row, between

Drive = Literal["road", "axles", "rig"]
"""What moves the model: the ground under the wheels, the measured motion of the axles, or, of a
component, the rig."""

CORNERS = (0, 1, 2, 3)
"""Front left, front right, rear left, rear right."""


def axle_name(corner: int) -> str:
    """Front or rear: the key under which vehicle.toml keeps a corner's numbers."""
    return "front" if corner < 2 else "rear"


def corner_position(values: Mapping[str, float], corner: int) -> tuple[float, float]:
    """(x, y), m, of a corner's attachment point, seen from the sprung body's centre of mass."""
    x = values["geometry.cg_to_front_axle_m"]
    if corner >= 2:
        x -= values["geometry.wheelbase_m"]
    half = values["geometry.track_width_m"] / 2
    return x, half if corner % 2 == 0 else -half


def body_corner(values: Mapping[str, float], corner: int) -> Body:
    """The suspension-to-body attachment point B of a corner."""
    return Body(*corner_position(values, corner))


def axle(corner: int) -> Coordinate:
    """The wheel axle A of a corner."""
    return Coordinate(f"axle {corner + 1}")


def ground(corner: int) -> Coordinate:
    """The height of the wheel envelope at a corner."""
    return Coordinate(f"ground {corner + 1}")


def suspension(values: Mapping[str, float], corner: int) -> Row:
    """Extension of a corner's suspension: body minus axle, positive in rebound."""
    return between(body_corner(values, corner), axle(corner))


def tyre(corner: int) -> Row:
    """Extension of a corner's tyre: axle minus ground, positive when the wheel is lifted."""
    return between(axle(corner), ground(corner))


def static_load(values: Mapping[str, float], corner: int, gravity: float = 9.80665) -> float:
    """Static load of the suspension spring at a corner, N, from the body's mass and its place."""
    front = 1 - values["geometry.cg_to_front_axle_m"] / values["geometry.wheelbase_m"]
    share = front if corner < 2 else 1 - front
    return values["body.mass_kg"] * gravity * share / 2


def static_tyre_load(values: Mapping[str, float], corner: int, gravity: float = 9.80665) -> float:
    """Static load under the wheel of a corner, N."""
    unsprung = values[f"wheel.{axle_name(corner)}.unsprung_mass_kg"]
    return static_load(values, corner, gravity) + unsprung * gravity


def baseline(values: Mapping[str, float], channels: Sequence[Channel], drive: Drive) -> Assembly:
    """The parts of the baseline vehicle, with one output per channel.

    Parameters
    ----------
    values
        Numbers of vehicle.toml under their dotted keys, SI; for a channel on the body whose place
        is unknown also "channel.NAME.x_m" and "channel.NAME.y_m".
    channels
        Outputs in this order. With the drive "axles" the axles' own channels are not predicted.
    drive
        Whether the ground heights or the axles' heights are prescribed.
    """
    prescribed = [ground(i) if drive == "road" else axle(i) for i in CORNERS]
    parts = Assembly(prescribed=tuple(node.name for node in prescribed))
    for i in CORNERS:
        end = axle_name(i)
        parts.add_spring(
            suspension(values, i),
            values[f"suspension.{end}.stiffness_N_m"],
            values[f"suspension.{end}.damping_N_s_m"],
        )
        if drive == "road":
            wheel = parts.add_coordinate(axle(i).name)
            parts.add_mass(((1.0, wheel),), values[f"wheel.{end}.unsprung_mass_kg"])
            parts.add_spring(
                tyre(i),
                values[f"wheel.{end}.tyre_stiffness_N_m"],
                values[f"wheel.{end}.tyre_damping_N_s_m"],
            )
    for channel in channels:
        parts.add_output(_output(values, channel, drive))
    return parts


def body_inertia(values: Mapping[str, float]) -> tuple[float, float, float]:
    """Mass, pitch and roll inertia of the sprung body, as :meth:`Assembly.system` wants them."""
    return (
        values["body.mass_kg"],
        values["body.pitch_inertia_kg_m2"],
        values["body.roll_inertia_kg_m2"],
    )


def _output(values: Mapping[str, float], channel: Channel, drive: Drive) -> Row | None:
    if channel.corner is not None:
        if not channel.is_axle:
            return ((1.0, body_corner(values, channel.corner)),)
        return ((1.0, axle(channel.corner)),) if drive == "road" else None
    if channel.x_m is not None and channel.y_m is not None:
        return ((1.0, Body(channel.x_m, channel.y_m)),)
    key = f"channel.{channel.name}"
    return ((1.0, Body(values[f"{key}.x_m"], values[f"{key}.y_m"])),)
