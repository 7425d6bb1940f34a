"""What driving does to the body, along the road: measured, and as the vehicle's speed changes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_lsq_spline

from wheelhop.campaign import Campaign, Run
from wheelhop.campaign.known import known_of
from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.gate.finding import Finding

Array = NDArray[np.float64]

KNOT_S = 0.6
"""Spacing of the knots through a speed: ten samples of a GPS give a knot its noise, and pedals are
slower."""
ALIKE = 0.7
"""Correlation from which on the two show the same motion, upside down or in another unit or not."""
RIGHT = 2.0
"""A gain within this factor of 1 is right: speeds lag, and bodies tilt."""


def driving_findings(campaign: Campaign) -> Iterator[Finding]:
    """Of a channel along x beside one of the vehicle's speed: the sensor's sign, and its unit."""
    speed = next((c for c in campaign.known if c.quantity == "speed" and not c.is_turning), None)
    felt = next((c for c in campaign.known if c.axis == "x" and c.is_acceleration), None)
    if speed is None or felt is None:
        return
    pairs = [_both(campaign, run, speed.name) for run in campaign.runs]
    shown, changed = (np.concatenate(part) for part in zip(*pairs, strict=True))
    size = float(np.linalg.norm(shown) * np.linalg.norm(changed))
    alike = float(shown @ changed) / size if size > 0.0 else 0.0
    if abs(alike) < ALIKE:
        return
    gain = abs(alike) * float(np.linalg.norm(shown) / np.linalg.norm(changed))
    evidence = f"{felt.name} is {np.sign(alike) * gain:.2g} times what {speed.name} changes by"
    if alike < 0.0:
        yield Finding(
            "before",
            "polarity",
            f"channels {felt.name}",
            f"{felt.name} seems to point backwards: {evidence}.",
            "Turn the sensor round, or change the sign of its column: x points forward.",
            "certain",
        )
    unit = 1.0 / STANDARD_GRAVITY_M_S2
    if unit / RIGHT < gain < unit * RIGHT:
        yield Finding(
            "before",
            "units",
            f"units of {felt.name}",
            f"{felt.name} seems to be in g: {evidence}.",
            f"Convert {felt.name} to m/s².",
            "certain",
        )


def _both(campaign: Campaign, run: Run, speed: str) -> tuple[Array, Array]:
    """The acceleration (n,) that a run's channel shows, and by how much its speed changes."""
    pushed = known_of(campaign, run).pushed.get("x")
    if pushed is None:
        return np.zeros(0), np.zeros(0)
    first, last = float(run.time_s[0]), float(run.time_s[-1])
    inner = np.linspace(first, last, max(int((last - first) / KNOT_S), 1) + 1)
    knots = np.concatenate([[first] * 3, inner, [last] * 3])
    changed = make_lsq_spline(run.time_s, run.known[speed], knots, k=3)(run.time_s, 1)
    return pushed.at(run.time_s), np.asarray(changed - changed.mean())
