"""Beliefs as hypotheses: what the campaign says of track and sensors may itself be wrong.

A track higher than surveyed or a sensor elsewhere than stated looks like physics. It therefore
competes with physics, under its own name. Numbers of the vehicle need no such hypothesis: every fit
may move them, and the critic says which it moved too far.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wheelhop.campaign import Campaign, Channel, ComponentCampaign, TrackSpec
from wheelhop.campaign.channel import BODY_POINTS
from wheelhop.campaign.low_pass import LowPass
from wheelhop.effects.base import Array, Effect, RunSetting, Values
from wheelhop.effects.parameters import Amplitude, Parameter
from wheelhop.effects.special import Misstatement
from wheelhop.effects.transfer import transferred
from wheelhop.files import dotted
from wheelhop.vehicle import Vehicle, corner_position


@dataclass(frozen=True)
class Quantity:
    """A number of tracks that a survey may have wrong: `keys` are its names in `TrackSpec`, `scale`
    is a relative error that plainly shows; ``instead`` says what looks like the same error in all
    tracks, empty if that does not show at all. An error `along` a track lengthens all of it."""

    name: str
    keys: tuple[str, ...]
    title: str
    equation: str
    scale: float
    instead: str = ""
    along: bool = False


QUANTITIES = (
    Quantity(
        "amplitude",
        ("amplitude_m", "height_m"),
        "higher or lower than surveyed",
        r"z = (1 + \epsilon)\, z_\text{surveyed}",
        0.1,
        "all recordings",
    ),
    # Of all tracks no such error shows: longer waves under a longer vehicle are the same.
    Quantity(
        "wavelength",
        ("pitch_m",),
        "longer or shorter in their waves than surveyed",
        r"z = z_\text{surveyed}(x / (1 + \epsilon))",
        0.01,
        along=True,
    ),
)


ALL = "all"
"""In the place of a kind of track: whoever wrote a height from trough to crest did so each time."""


class TrackSurvey(Misstatement):
    """A number of all tracks of one kind, or of all tracks, is larger, or smaller, than
    surveyed."""

    place = "track"
    source = "one template, one level, one mistake: tracks of a kind are surveyed together"
    needs_road = True

    def __init__(self, kind: str, quantity: Quantity, runs: frozenset[str]) -> None:
        """`kind` may be "all"."""
        self.id = f"belief: {quantity.name} of {kind} tracks"  # type: ignore[misc]
        self.title = f"{kind} tracks are {quantity.title}"  # type: ignore[misc]
        self.equation = quantity.equation  # type: ignore[misc]
        self.kind, self.quantity, self.runs = kind, quantity, runs

    def acts_in(self, run: RunSetting) -> bool:
        """In the runs over such a track."""
        return run.run_id in self.runs

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The relative error of the survey."""
        meaning = f"by how much the {self.quantity.name} is larger than surveyed, relative"
        return (Amplitude("error", "1", meaning, self.quantity.scale, lower=-0.5, upper=1.0),)

    def surveyed(self, theta: Values, track: TrackSpec) -> TrackSpec:
        """The track as it is."""
        if self.kind not in (track.kind, ALL):
            return track
        factor = 1.0 + theta["error"]
        keys = self.quantity.keys
        true = {k: float(v) * factor for k, v in track.values.items() if k in keys}
        return replace(track, values={**track.values, **true})

    def stretch(self, theta: Values, run_id: str) -> float:
        """A run keeps to its waves, however long: what shows of their length is how the wheels
        follow one another."""
        along = self.quantity.along and run_id in self.runs
        return 1.0 + theta["error"] if along else 1.0

    def stated(self) -> Mapping[str, tuple[str, float]]:
        """The quantity over what was surveyed."""
        return {"error": (f"track.{self.kind}.{self.quantity.name}", 1.0)}

    def remedy(self, theta: Values) -> str:
        """What to correct in campaign.toml."""
        factor = 1.0 + theta["error"]
        quantity = self.quantity
        if self.kind == ALL:
            instead = f"or, which looks the same, {quantity.instead} times {1 / factor:.4g}"
            return f"the {quantity.name}s of all its tracks times {factor:.4g}, {instead}"
        return f"the {quantity.name}s of its {self.kind} tracks times {factor:.4g}"


class SensorPosition(Misstatement):
    """A sensor on the body sits ahead of the point it is said to sit at, or to the left of it."""

    place = "sensor"
    equation = r"y = a + d_x\, \partial a / \partial x + d_y\, \partial a / \partial y"
    source = "kinematics of a rigid body, small angles"

    def __init__(
        self, channel: str, place: tuple[float, float], others: Sequence[str], slope: Array
    ) -> None:
        """`place` (x, y), m, is where it is said to sit; `slope` (2, c) makes of the records of
        `others` (c,) how the body's acceleration grows ahead and to the left."""
        self.id = f"belief: position of {dotted(channel)}"  # type: ignore[misc]
        self.title = f"{channel} sits elsewhere than stated"  # type: ignore[misc]
        self.channel, self.said, self.others, self.slope = channel, place, others, slope

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """How far it is ahead and to the left of its point."""
        where = {"x_m": "ahead of its point", "y_m": "to the left of its point"}
        return tuple(
            Amplitude(name, "m", f"how far the sensor sits {words}", 0.1, lower=-1.0, upper=1.0)
            for name, words in where.items()
        )

    def sense(
        self, theta: Values, acceleration: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """Add what pitch and roll, as the body's sensors show them, make of the distance."""
        column = {c.name: i for i, c in enumerate(channels)}
        found = acceleration.copy()
        across = acceleration[:, [column[name] for name in self.others]] @ self.slope.T
        found[:, column[self.channel]] += across @ [theta["x_m"], theta["y_m"]]
        return found

    def stated(self) -> Mapping[str, tuple[str, float]]:
        """Its place about the centre of mass."""
        return {
            axis: (f"channel.{dotted(self.channel)}.{axis}", said)
            for axis, said in zip(("x_m", "y_m"), self.said, strict=True)
        }

    def remedy(self, theta: Values) -> str:
        """What to correct in campaign.toml."""
        return (
            f"the place of {self.channel}: {theta['x_m']:+.2f} m ahead and {theta['y_m']:+.2f} m to"
            " the left of its point"
        )


class RecorderFilter(Misstatement):
    """The recorder has a low-pass filter that the campaign does not state: a Butterworth filter,
    of which the time 1/ω_c is 0 where there is none. That all comes later only places the runs
    elsewhere; what shows is that fast motion comes later still, and smaller."""

    id = "belief: filter of the recorder"
    place = "sensor"
    title = "the recorder has a low-pass filter that is not stated"
    equation = r"y = H a,\quad |H|^2 = 1 / (1 + (\omega \tau)^{2 n})"
    source = "S. Butterworth, On the theory of filter amplifiers, Wireless Engineer 7 (1930) 536"

    def __init__(self, highest_hz: float, order: int = 4) -> None:
        """`highest_hz` is the upper edge of the band that is compared."""
        self.highest_hz, self.order = highest_hz, order

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """Its orders."""
        return [f"order {order}" for order in FILTER_ORDERS]

    def with_choice(self, choice: str) -> RecorderFilter:
        """The filter of this order."""
        return RecorderFilter(self.highest_hz, int(choice.removeprefix("order ")))

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """1/ω_c: a corner at twice the highest frequency plainly shows."""
        shows = 1.0 / (2 * np.pi * 2.0 * self.highest_hz)
        meaning = "time constant 1/ω_c of the filter"
        return (Amplitude("time_s", "s", meaning, shows, lower=0.0, upper=4.0 * shows),)

    def sense(
        self, theta: Values, acceleration: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """What the filter lets through."""
        low_pass = self._filter(theta)
        if low_pass is None:
            return acceleration
        return transferred(acceleration, rate_hz, lambda hz: low_pass.response(hz)[:, None])

    def stated(self) -> Mapping[str, tuple[str, float]]:
        """That there is none."""
        return {"time_s": ("filter.time_constant_s", 0.0)}

    def remedy(self, theta: Values) -> str:
        """What to state in campaign.toml."""
        corner = 0.0 if (low_pass := self._filter(theta)) is None else low_pass.corner_hz
        return (
            f'filter = {{ kind = "butterworth", order = {self.order}, corner_hz = {corner:.3g} }}'
            " if the recorder has such a filter"
        )

    def _filter(self, theta: Values) -> LowPass | None:
        if theta["time_s"] <= 0.0:
            return None
        return LowPass("butterworth", self.order, 1.0 / (2 * np.pi * theta["time_s"]))


FILTER_ORDERS = (1, 2, 4, 8)
"""One of these, its corner and a delay fitted, follows a filter of any order to 0.4 % of the
signal, of the third to 0.8 %, where the true corner is 1.5 times the highest frequency."""


def beliefs(campaign: Campaign, vehicle: Vehicle) -> Mapping[str, Effect]:
    """What a campaign over tracks believes and its records may refute, by id."""
    found: list[Effect] = []
    if isinstance(campaign, ComponentCampaign):
        return {}
    for quantity in QUANTITIES:
        runs = defaultdict[str, list[str]](list)
        for run in campaign.runs:
            if set(quantity.keys) & set(run.track.values):
                runs[run.track.kind].append(run.id)
        if len(runs) > 1 and quantity.instead:
            runs[ALL] = [run_id for of_kind in runs.values() for run_id in of_kind]
        found += [TrackSurvey(kind, quantity, frozenset(ids)) for kind, ids in runs.items()]
    if not any(campaign.filters) and campaign.averaging_s == 0.0:
        found.append(RecorderFilter(campaign.band_hz[1]))
    places = {c.name: place for c in campaign.channels if (place := _place(c, vehicle))}
    fields = np.array([(1.0, *place) for place in places.values()])
    if len(places) > len(BODY_MODES) and np.linalg.matrix_rank(fields) == len(BODY_MODES):
        slope = np.linalg.pinv(fields)[1:]
        found += [SensorPosition(name, at, tuple(places), slope) for name, at in places.items()]
    return {effect.id: effect for effect in found}


BODY_MODES = ("heave", "pitch", "roll")
"""Of a rigid body: with no more sensors than these nothing tells that one is elsewhere."""


def _place(channel: Channel, vehicle: Vehicle) -> tuple[float, float] | None:
    """Where a sensor on the body is said to sit (x, y), m; None for any other, or if unknown."""
    if channel.point in BODY_POINTS and channel.corner is not None:
        return corner_position(vehicle.values, channel.corner)
    if channel.x_m is None or channel.y_m is None:
        return None
    return channel.x_m, channel.y_m
