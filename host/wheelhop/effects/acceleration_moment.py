"""What longitudinal pitch and cornering roll share: a moment on the body from its acceleration in
the plane of the road."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, OwnValues, RunSetting, Values
from wheelhop.effects.history import History
from wheelhop.effects.parameters import Amplitude, Parameter
from wheelhop.vehicle import Assembly
from wheelhop.vehicle.assembly import Row

KNOT_S = 0.15
"""Spacing of the spline's knots: a sine of 0.7 s period is followed to 1 %. Of faster ones the body
shows less, of what a coarser spline misses another effect would make its own."""

EXPECTED_M_S2 = 1.0
"""Size of the acceleration believed of a driver who corrects speed and path."""


SHARE = "share"


class AccelerationMoment(Effect):
    """Mass × height × acceleration acts on the body; the acceleration is a cubic spline in time,
    free in every run. Where a channel on the body shows the acceleration, that times a share, free
    in every run, stands before the spline, which is then as small as the channel's noise.

    A share is 1 if height and scale are right. The sensor also shows the body's pitch or roll, by
    gravity and by its height over the centre of mass: part of a few per cent at low frequency.

    Where the model has a speed history already, the acceleration could follow from it. It does
    not: what is fast enough to be seen in band is lost in two derivatives of a spline that was
    fitted to the way.
    """

    place = "body"
    direction: ClassVar[str]
    """Where a positive acceleration points."""
    axis: ClassVar[str]
    """Along which a channel shows it."""
    turns: ClassVar[Row]
    """The body's coordinate that its moment drives, with its sign."""

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """All of it differs from run to run."""
        return ()

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """The spline's coefficients, m/s². Where a channel shows the acceleration: the share of it,
        and what is to be added, in the record as little as the sensor's noise."""
        meaning = f"acceleration {self.direction}"
        spline = _history(run).parameters("m/s²", meaning, EXPECTED_M_S2)
        if self.axis in run.known.pushed:
            noise = min(run.known.pushed[self.axis].noise_rms, EXPECTED_M_S2)
            added = (
                each if each.span_s[0] < run.record_start_s else replace(each, scale=noise)
                for each in spline
            )
            share = f"what acts of the {meaning} that is recorded, relative"
            return (Amplitude(SHARE, "1", share, 1.0), *added)
        return spline if run.speed_m_s > 0 else ()

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """A moment about the centre of mass, per acceleration."""
        lever = vehicle["body.mass_kg"] * vehicle["geometry.cg_height_m"]
        parts.add_force(tuple((lever * sign, coordinate) for sign, coordinate in self.turns))

    def forces(
        self, theta: Values, run: RunSetting, time_s: Array, way_m: Array, speed_m_s: Array
    ) -> Sequence[Array]:
        """The acceleration."""
        return (self._acceleration(theta, run, time_s),)

    def summary(self, runs: Sequence[OwnValues]) -> dict[str, float]:
        """Size of the acceleration, root mean square over the runs."""
        power = []
        for run, theta, _ in runs:
            time = np.linspace(run.record_start_s, run.end_s, 400)
            found = self._acceleration(theta, run, time)
            if found.any():
                power.append(np.mean(found**2))
        return {"rms_m_s2": float(np.sqrt(np.mean(power)))} if power else {}

    def _acceleration(self, theta: Values, run: RunSetting, time_s: Array) -> Array:
        found = _history(run).at(theta, time_s)
        free = np.zeros_like(time_s) if found is None else found[0]
        if self.axis not in run.known.pushed:
            return free
        return np.asarray(free + theta.get(SHARE, 0.0) * run.known.pushed[self.axis].at(time_s))


def _history(run: RunSetting) -> History:
    return History(run, KNOT_S, "m_s2")
