"""Dampers that can be bought or turned: the force-velocity curve of every click."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError, Channel
from wheelhop.campaign.curves import FORCE, SPEED, read_curve
from wheelhop.effects import Amplitude, Effect, Parameter, law
from wheelhop.vehicle import Assembly, struts

Array = NDArray[np.float64]
Values = Mapping[str, float]
COLUMNS: Mapping[str, Mapping[str, float]] = {"click": {"": 1.0}, "velocity": SPEED, "force": FORCE}
FEWEST = 4
"""Rows: two clicks with two velocities each."""


@law
def interpolated(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """Straight lines through n = p[0] points, velocities p[1 … n] and forces behind them; the first
    and the last line go on."""
    n = int(p[0])
    i = 1
    while i < n - 1 and v > p[i + 1]:
        i += 1
    share = (v - p[i]) / (p[i + 1] - p[i])
    return p[n + i] + share * (p[n + i + 1] - p[n + i]), z


@dataclass(frozen=True, eq=False)
class Clicks:
    """A damper's curves: `force` (clicks, n), N, at `velocity` (n,), m/s, both at the wheel and
    positive in rebound; `now` is the click it stands at."""

    clicks: tuple[float, ...]
    velocity: Array
    force: Array
    now: float

    def difference(self, click: float) -> Array:
        """How much more than at the present click (n,), N."""
        of = self.force[self.clicks.index(click)]
        return np.asarray(of - self.force[self.clicks.index(self.now)])


class DamperCurve(Effect):
    """What turning a damper changes: the curve of its click less that of the click at which the
    car was driven. So all that was identified of it stays as it is."""

    id = "damper-curve"
    place = "suspension"
    title = "a damper on another click"
    equation = r"f = F_\mathrm{click}(\dot x) - F_\mathrm{now}(\dot x)"
    source = "difference of measured curves, straight lines between their points"

    def __init__(self, of: Mapping[str, Clicks]) -> None:
        self.of = of

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The click of each axle."""
        return tuple(
            Amplitude(click_key(end), "1", f"click of the {end} dampers", 1.0, absent=clicks.now)
            for end, clicks in self.of.items()
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the difference to each strut."""
        for strut in struts(vehicle):
            if strut.end in self.of:
                clicks = self.of[strut.end]
                more = clicks.difference(theta[click_key(strut.end)])
                numbers = (float(len(more)), *clicks.velocity.tolist(), *more.tolist())
                parts.add_law(strut.row, interpolated, numbers)


def click_key(end: str) -> str:
    """The name of an axle's click among the parameters."""
    return f"{end}_click"


def read_clicks(file: Path, now: float, ratio: float) -> Clicks:
    """Read the curves of all clicks: rows of click, velocity and force, as they are at the damper.

    With a motion `ratio`, damper travel over wheel travel, the wheel sees ratio · F(ratio · v).
    Raises CampaignError for a file that is wrong, a click with one velocity alone, and a click
    `now` that is not there.
    """
    table = read_curve(file, COLUMNS, FEWEST)
    clicks = tuple(np.unique(table["click"]).tolist())
    velocity = np.unique(table["velocity"])
    force = np.empty((len(clicks), len(velocity)))
    for i, click in enumerate(clicks):
        rows = np.flatnonzero(table["click"] == click)
        rows = rows[np.argsort(table["velocity"][rows], kind="stable")]
        at = table["velocity"][rows]
        if len(at) < 2 or not (np.diff(at) > 0.0).all():
            raise CampaignError(
                f"{file}: click {click:g}: give its force once at each of two velocities or more"
            )
        force[i] = _lines(velocity, at, table["force"][rows])
    if now not in clicks:
        there = ", ".join(f"{click:g}" for click in clicks)
        raise CampaignError(f"{file}: click {now:g}, at which the car is now, is none of {there}")
    return Clicks(clicks, velocity / ratio, ratio * force, now)


def _lines(v: Array, at: Array, force: Array) -> Array:
    """Straight lines through points, the first and the last of which go on."""
    i = np.clip(np.searchsorted(at, v) - 1, 0, len(at) - 2)
    slope = (force[i + 1] - force[i]) / (at[i + 1] - at[i])
    return np.asarray(force[i] + slope * (v - at[i]))
