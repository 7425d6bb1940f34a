"""[channels] of campaign.toml: what each column of the recordings is, and how noisy it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wheelhop.campaign.channel import (
    ABOARD,
    ACCELERATION,
    AXLE_POINTS,
    BODY_POINTS,
    ROTATION,
    STRUT_POINTS,
    Channel,
)
from wheelhop.campaign.low_pass import LowPass, read_filters, read_low_pass
from wheelhop.campaign.rocker import read_rocker
from wheelhop.campaign.types import CampaignError
from wheelhop.files import Table
from wheelhop.files.words import ending_of

POINTS = (*AXLE_POINTS, *BODY_POINTS)
VERTICAL, ENGINE, WHEEL = "z", "engine", "wheel"


@dataclass(frozen=True)
class Quantity:
    """What a sensor measures: its unit, its keys in campaign.toml, the largest sample that is
    believed, and what else than a broken file exceeds that."""

    unit: str
    keys: tuple[str, ...]
    largest: float
    hint: str = ""


QUANTITIES: Mapping[str, Quantity] = {
    # A hundred thousand g: a broken file, and powers of it overflow.
    ACCELERATION: Quantity("m/s²", ("axis", "position", "on"), 1e6),
    "travel": Quantity("m", ("corner", "per_wheel"), 5.0, "is it in millimetres?"),
    "rate": Quantity("rad/s", ("axis",), 100.0, "is it in degrees per second?"),
    "force": Quantity("N", ("corner", "per_wheel"), 1e8),
    "speed": Quantity("m/s", ("of", "corner", "radius_m"), 1e3, "is it in another unit?"),
}
ACCELERATIONS = {"on": ("on",), "along": ("axis", "position")}
"""Words for accelerations that are not vertical ones of a point, and the keys that follow."""
Place = str | Sequence[float] | Mapping[str, str | float]
"""What stands behind a channel's name: a point, x and y, or a table."""
NOISE = "noise_rms"


def noise_key(unit: str) -> str:
    """Under which key campaign.toml states the noise of channels in this unit."""
    return f"{NOISE}{ending_of(unit)}"


NOISE_KEYS = tuple(noise_key(QUANTITIES[q].unit) for q in (ACCELERATION, "travel", "rate", "force"))
"""Of the quantities that are compared."""


def place_of(word: str) -> Place:
    """The table that a word such as "travel:1:0.65", "rate:pitch" or "speed:engine" stands for, the
    quantity and then its keys in order; "on:driver" and "along:x" are accelerations there and so,
    and any other word is itself.

    Raises CampaignError for more parts than the quantity has keys.
    """
    quantity, *parts = word.split(":")
    if quantity in ACCELERATIONS and parts:
        keys, quantity = ACCELERATIONS[quantity], ACCELERATION
    elif quantity in QUANTITIES and quantity != ACCELERATION:
        keys = QUANTITIES[quantity].keys
    else:
        return word
    if len(parts) > len(keys):
        raise CampaignError(f"{word}: {quantity} has only {' and '.join(keys)}")
    return {"quantity": quantity} | dict(zip(keys, map(_number_or_text, parts), strict=False))


def with_noise(place: Place, unit: str, rms: float) -> Place:
    """A channel's table with its noise, `rms` in its unit, unless it states one. A point, or x and
    y, has no room for it: the noise of such channels is stated for all together."""
    key = noise_key(unit)
    return {**place, key: rms} if isinstance(place, Mapping) and key not in place else place


def _number_or_text(part: str) -> str | float:
    try:
        return int(part) if part.isdecimal() else float(part)
    except ValueError:
        return part


def units_of(top: Table) -> dict[str, str]:
    """The unit of every channel that campaign.toml lists, by its name; of the eight points where
    it lists none."""
    said = read_channels(top)
    listed = said.compared or tuple(Channel(point, point) for point in POINTS)
    return {channel.name: channel.unit for channel in (*listed, *said.known)}


def with_filters(
    channels: Sequence[Channel], top: Table
) -> tuple[tuple[Channel, ...], LowPass | None]:
    """Channels with the filters that the top of campaign.toml states of their quantities, and the
    one of all channels, None if there is none. Without channels accelerations are measured.

    Raises CampaignError for a filter of a quantity that no channel measures.
    """
    if "filter" not in top:
        return tuple(channels), None
    stated = read_filters(top.table("filter"), [q for q in QUANTITIES if q != "speed"])
    measured = {c.quantity for c in channels} or {ACCELERATION}
    for quantity in stated:
        if quantity and quantity not in measured:
            raise top.error(f"filter.{quantity}: no channel measures that: delete it")
    found = (
        c if c.low_pass is not None else replace(c, low_pass=stated.get(c.quantity))
        for c in channels
    )
    return tuple(found), stated.get("", None if channels else stated.get(ACCELERATION))


@dataclass(frozen=True)
class Channels:
    """The channels that are `compared`, those that are only `known`, and the noise of one channel
    of the leading quantity (`Campaign.leading`), None if it is not stated."""

    compared: tuple[Channel, ...]
    known: tuple[Channel, ...]
    noise_rms: float | None


def read_channels(top: Table) -> Channels:
    """What campaign.toml says of its channels and their noise; without [channels] there are none.

    Raises `CampaignError` for a key or a value that is not known, and noise that is stated of a
    quantity that nothing measures.
    """
    stated = {key: top.number(key, above=0.0) for key in NOISE_KEYS if key in top}
    if "channels" not in top:
        _refuse_unmeasured(top, stated, (noise_key(QUANTITIES[ACCELERATION].unit),))
        return Channels((), (), next(iter(stated.values()), None))
    table = top.table("channels")
    if not table.values:
        raise table.error('is empty: name one channel or more (A1 = "A1"), or delete the table')
    every = [_channel(table, name) for name in table.values]
    compared = [channel for channel, is_known in every if not is_known]
    if not compared:
        raise table.error(
            "no channel can be compared with a model: add one of acceleration, travel, rate, force"
        )
    _refuse_unmeasured(top, stated, {noise_key(channel.unit) for channel in compared})
    leading = next((c for c in compared if c.is_acceleration), compared[0])
    noise = stated.get(noise_key(leading.unit))
    own = [c.noise_rms for c in compared if c.quantity == leading.quantity]
    if noise is None and all(rms is not None for rms in own):
        noise = float(np.sqrt(np.mean(np.square(np.array(own, float)))))
    return Channels(
        tuple(
            c
            if c.noise_rms is not None or c.quantity == leading.quantity
            else replace(c, noise_rms=stated.get(noise_key(c.unit)))
            for c in compared
        ),
        tuple(channel for channel, is_known in every if is_known),
        noise,
    )


def _refuse_unmeasured(
    top: Table, stated: Mapping[str, float], keys: Sequence[str] | set[str]
) -> None:
    for key in stated:
        if key not in keys:
            raise top.error(f"{key} is the noise of a quantity that no channel measures: delete it")


def _channel(table: Table, name: str) -> tuple[Channel, bool]:
    """A channel, and whether it is only known."""
    place = table.values[name]
    if not name.strip() or not name.isprintable() or name == "time_s":
        raise table.error(f"{name!r} cannot be the name of a channel")
    if isinstance(place, dict):
        return _measured(table.table(name), name)
    return _placed(table, name, name), False


def _placed(table: Table, key: str, name: str) -> Channel:
    """A vertical acceleration at the place that a key says."""
    place = table.values[key]
    if isinstance(place, list):
        x_m, y_m = table.pair(key)
        return Channel(name, "body-xy", x_m, y_m)
    if place in (*POINTS, "body"):
        return Channel(name, place)
    raise table.error(
        f'{key}: say where the sensor sits: "A1".."A4", "B1".."B4", "body" (unknown), or [x, y] '
        "in metres from the centre of mass; of another quantity than vertical acceleration say "
        '{ quantity = "travel", … }'
    )


def _measured(table: Table, name: str) -> tuple[Channel, bool]:
    """What a channel's own table says of it."""
    quantity = table.text("quantity", choices=tuple(QUANTITIES))
    about = QUANTITIES[quantity]
    turns = quantity == "speed" and "of" in table
    unit = ROTATION if turns else about.unit
    table.only(("quantity", *about.keys, noise_key(unit), "scale_uncertainty", "filter"))
    channel, is_known = Channel(name, "", quantity=quantity, unit=unit), True
    if quantity == "speed":
        channel = _speed(table, channel)
    elif "corner" in about.keys:
        point = STRUT_POINTS[_corner(table) - 1]
        channel = replace(channel, point=point, **_ratio(table))
        is_known = False
    elif quantity == "rate":
        channel = replace(channel, point=table.text("axis", choices=("pitch", "roll")))
        is_known = False
    elif quantity == ACCELERATION:
        channel, is_known = _acceleration(table, channel)
    if noise_key(unit) in table:
        channel = replace(channel, noise_rms=table.number(noise_key(unit), above=0.0))
    if "filter" in table:
        if is_known:
            raise table.error("filter: this channel is not compared with the model: delete it")
        channel = replace(channel, low_pass=read_low_pass(table.table("filter")))
    scale = table.number("scale_uncertainty", 0.0, at_least=0.0, below=1.0)
    return replace(channel, scale_uncertainty=scale, gain_uncertainty=scale), is_known


def _acceleration(table: Table, channel: Channel) -> tuple[Channel, bool]:
    """An acceleration: vertical on body, axle or what a mount carries it is compared; along x or y
    it is only known."""
    axis = table.text("axis", VERTICAL, choices=("x", "y", VERTICAL))
    if "on" in table:
        if "position" in table:
            raise table.error("on and position both say where the sensor sits: delete one")
        on = table.text("on", choices=ABOARD)
        return replace(channel, point=on, axis=axis), axis != VERTICAL
    if "position" not in table and axis != VERTICAL:
        return replace(channel, point="body", axis=axis), True
    if "position" not in table:
        raise table.error(
            f"'position' is missing: give position = [x, y] in metres from the centre of mass, a"
            f' point such as "B1", or on = "{ABOARD[0]}"'
        )
    placed = _placed(table, "position", channel.name)
    return replace(placed, axis=axis), axis != VERTICAL


def _speed(table: Table, channel: Channel) -> Channel:
    """The speed of the vehicle, of its engine, or of a wheel."""
    of = table.text("of", choices=(ENGINE, WHEEL)) if "of" in table else ""
    if of != WHEEL:
        for key in ("corner", "radius_m"):
            if key in table:
                raise table.error(f'{key} is of a wheel: add of = "{WHEEL}", or delete it')
        return replace(channel, point=of)
    radius = table.number("radius_m", above=0.0) if "radius_m" in table else 0.0
    return replace(channel, point=AXLE_POINTS[_corner(table) - 1], radius_m=radius)


def _corner(table: Table) -> int:
    corner = table.number("corner")
    if corner not in (1, 2, 3, 4):
        raise table.error(
            f"corner = {corner:g} must be 1 (front left), 2 (front right), 3 (rear left) or 4 (rear"
            " right)"
        )
    return int(corner)


def _ratio(table: Table) -> dict[str, Any]:
    """What the sensor shows per what the wheel does: a number, or of travel a curve."""
    if isinstance(table.values.get("per_wheel"), str):
        if table.values["quantity"] != "travel":
            raise table.error("per_wheel: a curve is of travel; of a force give a number")
        rocker = read_rocker(table, "per_wheel")
        return {"per_wheel": rocker.per_wheel, "rocker": rocker}
    ratio = table.number("per_wheel", 1.0)
    if ratio == 0.0:
        raise table.error(
            "per_wheel = 0 would show nothing: give what the sensor shows per what the wheel does,"
            " below 0 if it counts the other way"
        )
    return {"per_wheel": ratio}
