"""What a run's recording tells of what acts on the vehicle: how fast engine and wheels turned, and
what driving does to the body. None of it is compared with the model: it is put in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import interpolate

from wheelhop.campaign.channel import ABOARD, AXLE_POINTS, Channel
from wheelhop.campaign.driven import Driven
from wheelhop.campaign.types import Campaign, Run

Array = NDArray[np.float64]

KNOT_S = 0.15
"""Spacing of the knots through a measured acceleration: a sine of 0.7 s period is followed to 1 %.
What is faster is the body's own shaking, which the sensor shows as well."""


@dataclass(frozen=True, eq=False)
class Pushed:
    """An acceleration along the road (n,), m/s², at times (n,), s, as a channel shows it."""

    time_s: Array
    acceleration_m_s2: Array

    def at(self, time_s: Array) -> Array:
        """What driving does (T,), about its mean in the run: without the body's own shaking, and
        beyond the record as it was at its ends."""
        return np.asarray(self._spline(np.clip(time_s, self.time_s[0], self.time_s[-1])))

    @cached_property
    def noise_rms(self) -> float:
        """What of the channel is noise and the body's shaking, m/s²: what `at` leaves of it."""
        shown = self.at(self.time_s)
        return float(np.std(self.acceleration_m_s2 - shown))

    @cached_property
    def _spline(self) -> interpolate.BSpline:
        first, last = float(self.time_s[0]), float(self.time_s[-1])
        inner = np.linspace(first, last, max(int((last - first) / KNOT_S), 1) + 1)
        knots = np.concatenate([[first] * 3, inner, [last] * 3])
        about = self.acceleration_m_s2 - self.acceleration_m_s2.mean()
        return interpolate.make_lsq_spline(self.time_s, about, knots, k=3)


@dataclass(frozen=True, eq=False)
class Known:
    """What is known of a run beside what is compared: how the `engine` turned, rad/s, with its mean
    in all runs as what is stated; how `wheels` did, by their corners; and how driving accelerated
    the body along "x", forward, and "y", to the left."""

    engine: Driven | None = None
    wheels: Mapping[int, Driven] = field(default_factory=dict)
    pushed: Mapping[str, Pushed] = field(default_factory=dict)


NOTHING = Known()


def asked_by(channel: Channel) -> str:
    """The effect that asks for a channel that is only known; "" if none does."""
    if channel.is_turning:
        return "engine-vibration" if channel.corner is None else "wheel-imbalance"
    if not channel.is_acceleration or channel.point in (*AXLE_POINTS, *ABOARD):
        return ""
    return {"x": "longitudinal-pitch", "y": "cornering-roll"}.get(channel.axis, "")


def known_of(campaign: Campaign, run: Run) -> Known:
    """What the campaign's channels that are only known tell of a run; of several that tell the same
    the first counts. An engine that stands, or a wheel, tells nothing."""
    engine, wheels, pushed = None, dict[int, Driven](), dict[str, Pushed]()
    for channel in campaign.known:
        values = run.known[channel.name]
        if channel.is_acceleration and asked_by(channel):
            pushed.setdefault(channel.axis, Pushed(run.time_s, values))
        if not channel.is_turning or values.mean() <= 0.0 or values.min() < 0.0:
            continue
        turned = Driven(channel.name, run.time_s, values, channel.mean)
        if channel.corner is None:
            engine = engine or turned
        else:
            wheels.setdefault(channel.corner, turned)
    return Known(engine, wheels, pushed)
