"""What longitudinal pitch and cornering roll share: a moment on the body from its acceleration in
the plane of the road."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, OwnValues, RunSetting, Values
from wheelhop.effects.history import History
from wheelhop.effects.parameters import Parameter
from wheelhop.vehicle import Assembly
from wheelhop.vehicle.assembly import Row

KNOT_S = 0.15
"""Spacing of the spline's knots: a sine of 0.7 s period is followed to 1 %. Of faster ones the body
shows less, of what a coarser spline misses another effect would make its own."""

EXPECTED_M_S2 = 1.0
"""Size of the acceleration believed of a driver who corrects speed and path."""


class AccelerationMoment(Effect):
    """Mass × height × acceleration acts on the body; the acceleration is a cubic spline in time,
    free in every run.

    Where the model has a speed history already, the acceleration could follow from it. It does
    not: what is fast enough to be seen in band is lost in two derivatives of a spline that was
    fitted to the way.
    """

    place = "body"
    direction: ClassVar[str]
    """Where a positive acceleration points."""
    turns: ClassVar[Row]
    """The body's coordinate that its moment drives, with its sign."""

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """All of it differs from run to run."""
        return ()

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """The spline's coefficients, m/s²."""
        if run.speed_m_s <= 0:
            return ()
        meaning = f"acceleration {self.direction}"
        return _history(run).parameters("m/s²", meaning, EXPECTED_M_S2)

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """A moment about the centre of mass, per acceleration."""
        lever = vehicle["body.mass_kg"] * vehicle["geometry.cg_height_m"]
        parts.add_force(tuple((lever * sign, coordinate) for sign, coordinate in self.turns))

    def forces(
        self, theta: Values, run: RunSetting, time_s: Array, way_m: Array, speed_m_s: Array
    ) -> Sequence[Array]:
        """The acceleration."""
        found = _history(run).at(theta, time_s)
        return (np.zeros_like(time_s) if found is None else found[0],)

    def summary(self, runs: Sequence[OwnValues]) -> dict[str, float]:
        """Size of the acceleration, root mean square over the runs."""
        power = []
        for run, theta, _ in runs:
            found = _history(run).at(theta, np.linspace(run.record_start_s, run.end_s, 400))
            if found is not None:
                power.append(np.mean(found[0] ** 2))
        return {"rms_m_s2": float(np.sqrt(np.mean(power)))} if power else {}


def _history(run: RunSetting) -> History:
    return History(run, KNOT_S, "m_s2")
