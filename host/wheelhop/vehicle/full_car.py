"""The baseline vehicle: linear, wheels in permanent contact.

The full car has seven degrees of freedom: heave, pitch and roll of a rigid sprung body, four
unsprung masses on vertical suspensions and tyres (thesis section 4.1.2, "simplified Adams model";
equations of motion of this kind are 2.1). What stands on mounts of its own is added, and the modes
of a frame. Half and quarter cars have those of the same parts that
their body's motions leave (`wheelhop.vehicle.layout`).
What is measured besides accelerations is read from the same motion: the travel of a strut and the
force in it, and the rates of pitch and roll of the rigid body.
The same parts also make the *axle-driven* vehicle: the axles' motion is imposed, and tyre, track
and speed no longer matter. Nor do they where the struts' *travel* is imposed: then the forces of
the struts are those that this travel makes of them, and move the body.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from wheelhop.campaign import Channel
from wheelhop.campaign.channel import ABOARD
from wheelhop.vehicle.aboard import add_aboard, sensor_on
from wheelhop.vehicle.assembly import Assembly, Body, Coordinate, Reading, Row, between
from wheelhop.vehicle.frame_modes import add_modes
from wheelhop.vehicle.layout import axle_name, corner_position, motions, wheels

Drive = Literal["road", "axles", "travel", "rig"]
"""What moves the model: the ground under the wheels, the measured motion of the axles, the measured
travel of the struts, or, of a component, the rig."""


def body_corner(values: Mapping[str, float], corner: int) -> Body:
    """The suspension-to-body attachment point B of a corner."""
    return Body(*corner_position(values, corner))


def axle(corner: int) -> Coordinate:
    """The wheel axle A of a corner."""
    return Coordinate(f"axle {corner + 1}")


def ground(corner: int) -> Coordinate:
    """The height of the wheel envelope at a corner."""
    return Coordinate(f"ground {corner + 1}")


def travel(corner: int) -> Coordinate:
    """The extension of a corner's suspension where it is imposed."""
    return Coordinate(f"travel {corner + 1}")


def suspension(values: Mapping[str, float], corner: int) -> Row:
    """Extension of a corner's suspension: body minus axle, positive in rebound."""
    return between(body_corner(values, corner), axle(corner))


def tyre(corner: int) -> Row:
    """Extension of a corner's tyre: axle minus ground, positive when the wheel is lifted."""
    return between(axle(corner), ground(corner))


def baseline(values: Mapping[str, float], channels: Sequence[Channel], drive: Drive) -> Assembly:
    """The parts of the baseline vehicle, with one output per channel.

    Parameters
    ----------
    values
        Numbers of vehicle.toml under their dotted keys, SI, modes of a frame included; for a
        channel on the body whose place is unknown also "channel.NAME.x_m" and "channel.NAME.y_m".
    channels
        Outputs in this order. Unless the drive is "road" those of the axles are not predicted, nor
        travel and force of the struts: what moves slower than the band is not known of measured
        axles, and travel shows it.
    drive
        Whether the ground's heights, the axles' or the struts' extensions are prescribed.
    """
    corners = wheels(values)
    imposed = {"road": ground, "axles": axle, "travel": travel}[drive]
    prescribed = [imposed(i) for i in corners]
    parts = Assembly(tuple(node.name for node in prescribed), motions(values))
    for i in corners:
        end = axle_name(i)
        parts.add_spring(
            suspension(values, i),
            values[f"suspension.{end}.stiffness_N_m"],
            values[f"suspension.{end}.damping_N_s_m"],
        )
        if drive == "travel":
            above = ((1.0, body_corner(values, i)), (-1.0, travel(i)))
            parts.add_carried(axle(i), above)
        if drive == "road":
            wheel = parts.add_coordinate(axle(i).name)
            parts.add_mass(((1.0, wheel),), values[f"wheel.{end}.unsprung_mass_kg"])
            parts.add_spring(
                tyre(i),
                values[f"wheel.{end}.tyre_stiffness_N_m"],
                values[f"wheel.{end}.tyre_damping_N_s_m"],
            )
    add_modes(parts, values)
    add_aboard(parts, values)
    for channel in channels:
        parts.add_output(_output(values, channel, drive))
    return parts


def _output(values: Mapping[str, float], channel: Channel, drive: Drive) -> Row | Reading | None:
    corner = channel.corner
    if drive != "road" and not channel.is_on_body:
        return None
    if corner is not None and channel.quantity == "travel":
        return Reading("displacement", suspension(values, corner), channel.per_wheel)
    if corner is not None and channel.quantity == "force":
        return Reading("force", suspension(values, corner), channel.per_wheel)
    if channel.quantity == "rate":
        return Reading("rate", ((1.0, Coordinate(channel.point)),))
    if corner is not None:
        if not channel.is_axle:
            return ((1.0, body_corner(values, corner)),)
        return ((1.0, axle(corner)),)
    if channel.point in ABOARD:
        return ((1.0, sensor_on(values, channel.point)),)
    if channel.x_m is not None and channel.y_m is not None:
        return ((1.0, Body(channel.x_m, channel.y_m)),)
    key = channel.key
    return ((1.0, Body(values[f"{key}.x_m"], values[f"{key}.y_m"])),)
