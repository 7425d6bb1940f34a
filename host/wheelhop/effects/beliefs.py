"""Beliefs as hypotheses: what the campaign says of track and sensors may itself be wrong.

A track higher than surveyed or a sensor elsewhere than stated looks like physics. It therefore
competes with physics, under its own name. Numbers of the vehicle need no such hypothesis: every fit
may move them, and the critic says which it moved too far.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from wheelhop.campaign import Campaign, Channel, ComponentCampaign, TrackSpec
from wheelhop.campaign.types import BODY_POINTS
from wheelhop.effects.base import Array, Effect, Parameter, RunSetting, Values
from wheelhop.vehicle import Vehicle, corner_position

HEIGHTS = ("amplitude_m", "height_m")
"""Numbers of a track that say how high it is."""


class TrackAmplitude(Effect):
    """All tracks of one kind are higher, or lower, than surveyed."""

    place = "track"
    equation = r"z = (1 + \epsilon)\, z_\text{surveyed}"
    source = "one template, one level, one mistake: tracks of a kind are surveyed together"
    needs_road = True
    is_belief = True

    def __init__(self, kind: str, runs: frozenset[str]) -> None:
        self.id = f"belief: amplitude of {kind} tracks"  # type: ignore[misc]
        self.title = f"{kind} tracks are higher or lower than surveyed"  # type: ignore[misc]
        self.kind, self.runs = kind, runs

    def acts_in(self, run: RunSetting) -> bool:
        """In the runs over such a track."""
        return run.run_id in self.runs

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The relative error of the survey."""
        meaning = "by how much the tracks are higher than surveyed, relative"
        return (Parameter("error", "1", meaning, 0.1, lower=-0.5, upper=1.0),)

    def surveyed(self, theta: Values, track: TrackSpec) -> TrackSpec:
        """The track as high as it is."""
        if track.kind != self.kind:
            return track
        error = theta["error"]
        higher = {k: float(v) * (1.0 + error) for k, v in track.values.items() if k in HEIGHTS}
        return replace(track, values={**track.values, **higher})

    def remedy(self, theta: Values) -> str:
        """What to correct in campaign.toml."""
        return f"the amplitudes of its {self.kind} tracks times {1.0 + theta['error']:.3g}"


class SensorPosition(Effect):
    """A sensor on the body sits ahead of the point it is said to sit at, or to the left of it."""

    place = "sensor"
    equation = r"y = a + d_x\, \partial a / \partial x + d_y\, \partial a / \partial y"
    source = "kinematics of a rigid body, small angles"
    is_belief = True

    def __init__(self, channel: str, corners: Sequence[str], slope: Array) -> None:
        self.id = f"belief: position of {channel}"  # type: ignore[misc]
        self.title = f"{channel} sits elsewhere than stated"  # type: ignore[misc]
        self.channel, self.corners, self.slope = channel, corners, slope

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """How far it is ahead and to the left of its point."""
        where = {"x_m": "ahead of its point", "y_m": "to the left of its point"}
        return tuple(
            Parameter(name, "m", f"how far the sensor sits {words}", 0.1, lower=-1.0, upper=1.0)
            for name, words in where.items()
        )

    def sense(
        self, theta: Values, acceleration: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """Add what pitch and roll, as the corners show them, make of the distance."""
        column = {c.name: i for i, c in enumerate(channels)}
        found = acceleration.copy()
        across = acceleration[:, [column[name] for name in self.corners]] @ self.slope.T
        found[:, column[self.channel]] += across @ [theta["x_m"], theta["y_m"]]
        return found

    def remedy(self, theta: Values) -> str:
        """What to correct in campaign.toml."""
        return (
            f"the place of {self.channel}: {theta['x_m']:+.2f} m ahead and {theta['y_m']:+.2f} m to"
            " the left of its point"
        )


def beliefs(campaign: Campaign, vehicle: Vehicle) -> Mapping[str, Effect]:
    """What a campaign over tracks believes and its records may refute, by id."""
    found: list[Effect] = []
    if isinstance(campaign, ComponentCampaign):
        return {}
    for kind in dict.fromkeys(run.track.kind for run in campaign.runs):
        runs = [run for run in campaign.runs if run.track.kind == kind]
        if any(key in run.track.values for run in runs for key in HEIGHTS):
            found.append(TrackAmplitude(kind, frozenset(run.id for run in runs)))
    corners = {c.name: c.corner for c in campaign.channels if c.point in BODY_POINTS}
    if len(corners) == len(BODY_POINTS):
        places = [
            (1.0, *corner_position(vehicle.values, i)) for i in corners.values() if i is not None
        ]
        slope = np.linalg.pinv(np.array(places))[1:]
        found += [SensorPosition(name, tuple(corners), slope) for name in corners]
    return {effect.id: effect for effect in found}
