"""Left and right wheels travel different distances."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, OwnValues, Probe, RunSetting, Values
from wheelhop.effects.history import History
from wheelhop.effects.parameters import Parameter
from wheelhop.effects.phase import shift_along

KNOTS_S = {"slow": 1.0, "fast": 0.15}
"""Spacing of the spline's knots: slip comes slowly, swerving does not."""

SIDES = (0, 2), (1, 3)
"""Corners on the left and on the right."""

EXPECTED = 0.01
"""Relative difference of the two sides' distance that a curve or slip makes."""


class LeftRightDrift(Effect):
    """The lead of the left wheels over the right ones is a spline in time, free in every run."""

    id = "left-right-drift"
    place = "speed"
    title = "left and right wheels travel different distances (no differential, slip, curved path)"
    equation = (
        r"x_\mathrm{left} - x_\mathrm{right} = \sum_j c_j B_j(t),"
        r"\quad B_j \text{ cubic B-splines, 1 s apart (slow) or 0.15 s (fast)}"
    )
    source = "thesis 4.4, points 4 and 5: no differential, tracks that are not straight"
    needs_motions = ("roll",)
    needs_road = True

    def __init__(self, form: str = "slow") -> None:
        self._knot_s = KNOTS_S[form]

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """How fast it may change."""
        return tuple(KNOTS_S)

    def with_choice(self, choice: str) -> LeftRightDrift:
        """Wheels that slip and curves that come slowly, or a driver who swerves."""
        return LeftRightDrift(choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """All of it differs from run to run."""
        return ()

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """The spline's coefficients, metres."""
        if not run.on_road or run.speed_m_s <= 0:
            return ()
        scale = EXPECTED * run.speed_m_s * (run.end_s - run.record_start_s) / 2
        return History(run, self._knot_s).parameters("m", "lead of the left wheels", scale)

    def travel(
        self, theta: Values, run: RunSetting, time_s: Array, position_m: Array, speed_m_s: float
    ) -> tuple[Array, Array] | None:
        """Half the lead to the left wheels, half taken from the right ones: the run's speed and
        start are the vehicle's."""
        lead = History(run, self._knot_s).at(theta, time_s)
        if lead is None:
            return None
        side = np.array([0.5, -0.5, 0.5, -0.5])
        return lead[0][:, None] * side, lead[1][:, None] * side

    def summary(self, runs: Sequence[OwnValues]) -> dict[str, float]:
        """Lead gained per metre driven, root mean square over the runs."""
        rates = []
        for run, theta, _ in runs:
            lead = History(run, self._knot_s).at(theta, np.array([run.record_start_s, run.end_s]))
            if lead is not None:
                driven = run.speed_m_s * (run.end_s - run.record_start_s)
                rates.append((lead[0][1] - lead[0][0]) / driven)
        return {"relative_rate": float(np.sqrt(np.mean(np.square(rates))))} if rates else {}

    def run_starts(self, probe: Probe, run: RunSetting, shapes: Values) -> Sequence[Values]:
        """Follow the phase of either side along the track; or place either side on it by itself,
        where the sides are so far apart that one speed is true of neither."""
        if not run.on_road or run.speed_m_s <= 0:
            return ({},)
        history = History(run, self._knot_s)
        time, (left, right) = shift_along(probe, run, *SIDES)
        followed = history.through(time, left - right)
        placed = [probe.placed(run.run_id, _axles(probe.channels, side)) for side in SIDES]
        if not all(placed):
            return (followed,)
        (left_v, left_x), (right_v, right_x) = ((p["speed_m_s"], p["start_m"]) for p in placed)
        middle = time.mean()
        apart = left_x - right_x + (left_v - right_v) * middle
        period = probe.period_m(run.run_id)
        if period is not None:  # whole waves cannot be told
            apart -= period * round(apart / period)
        lead = apart + (left_v - right_v) * (time - middle)
        speed = 0.5 * (left_v + right_v)
        start = right_x + right_v * middle + 0.5 * apart - speed * middle
        own = {"speed_m_s": speed, "start_m": start}
        return followed, own | history.through(time, lead)


def _axles(channels: Sequence[Channel], corners: Collection[int]) -> list[int]:
    """The channels at the axles of these corners, or at the body where there are none."""
    at = [i for i, c in enumerate(channels) if c.corner in corners]
    return [i for i in at if channels[i].is_axle] or at
