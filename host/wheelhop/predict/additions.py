"""Channels that a campaign could have besides those it has."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from wheelhop.campaign import Campaign, Channel
from wheelhop.campaign.channel import ACCELERATION
from wheelhop.campaign.channels import QUANTITIES
from wheelhop.vehicle import motions, wheels

USUAL_NOISE = {ACCELERATION: 0.1, "travel": 1e-4, "rate": 0.004}
"""In band, of a channel of a quantity of which the campaign has none: an accelerometer as the
logger's; a potentiometer of 100 mm in 10 bits, whose steps of 0.1 mm are not its only noise; a gyro
of an IMU of a car."""


@dataclass(frozen=True)
class Addition:
    """Channels that would be added together, and what they are, in words."""

    words: str
    channels: tuple[Channel, ...]


def additions(campaign: Campaign, values: Mapping[str, float]) -> list[Addition]:
    """What could be measured besides, a quantity and an axle at a time; on roads that are not known
    only what does not drive the model: there is one thing that drives it already."""
    is_road = all(run.track.kind != "unknown" for run in campaign.runs)
    there = {(c.quantity, c.point) for c in campaign.channels}
    found = []
    for words, quantity, points in _offered(values, is_road):
        new = [point for point in points if (quantity, point) not in there]
        if new:
            channels = tuple(_channel(campaign, quantity, point) for point in new)
            found.append(Addition(words, channels))
    return found


def _offered(values: Mapping[str, float], is_road: bool) -> Iterator[tuple[str, str, list[str]]]:
    rolling = set(wheels(values))
    for end, corners in (("front", (0, 1)), ("rear", (2, 3))):
        here = [corner + 1 for corner in corners if corner in rolling]
        if not here:
            continue
        if is_road:
            yield f"a potentiometer at each {end} corner", "travel", [f"S{i}" for i in here]
            yield f"an accelerometer on each {end} hub", ACCELERATION, [f"A{i}" for i in here]
        words = f"an accelerometer on the body above each {end} wheel"
        yield words, ACCELERATION, [f"B{i}" for i in here]
    for axis in ("pitch", "roll"):
        if axis in motions(values):
            yield f"a gyro of the {axis} rate", "rate", [axis]


def _channel(campaign: Campaign, quantity: str, point: str) -> Channel:
    """A channel as noisy, at the wheel, as the campaign's others of its quantity."""
    like = [c for c in campaign.channels if c.quantity == quantity]
    noise = [(c.noise_rms or 0.0) / abs(c.per_wheel) for c in like]
    rms = float(np.sqrt(np.mean(np.square(noise)))) if noise else USUAL_NOISE[quantity]
    name = f"added {quantity} {point}"
    return Channel(name, point, quantity=quantity, unit=QUANTITIES[quantity].unit, noise_rms=rms)


def with_channels(campaign: Campaign, channels: tuple[Channel, ...]) -> Campaign:
    """The campaign with further channels behind its own; nothing is recorded of them yet."""
    runs = tuple(
        replace(run, record=np.pad(run.record, ((0, 0), (0, len(channels)))))
        for run in campaign.runs
    )
    return replace(campaign, channels=(*campaign.channels, *channels), runs=runs)
