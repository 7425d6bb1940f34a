"""Are the records in m/s²? By the gravity they kept, and by what track and vehicle should cause."""

from __future__ import annotations

from collections.abc import Iterator
from math import log, pi

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign
from wheelhop.campaign.types import ACCELERATION
from wheelhop.files.units import SPELT, STANDARD_GRAVITY_M_S2
from wheelhop.gate.descriptions import OTHER_UNITS
from wheelhop.gate.drive import REACH, OnWaves
from wheelhop.gate.finding import FALSE_ALARM, Finding, needed
from wheelhop.gate.fixes import heights, scaled
from wheelhop.gate.runs import HEIGHT, Runs
from wheelhop.vehicle import Vehicle

Array = NDArray[np.float64]

KEPT = 0.03  # of 1 g: gains are that good, and sensors that upright
OFFSET = 0.3  # units, standard deviation of a channel's offset, any sensor's
OTHER_SPEEDS = {unit: 1 / SPELT[unit][1] for unit in ("km/h", "mph", "kn")}
"""What a channel of speed may be in, and its number over the same in m/s."""
SUSTAINED_M_S2 = 50.0
"""No vehicle holds a mean of 5 g: such a mean is no acceleration."""
OTHER = 0.2
"""Standard deviation, of the logarithm, by which effects the nominal vehicle lacks change how much
all runs move together; what is believed of its numbers comes on top."""


def gravity_findings(campaign: Campaign) -> Iterator[Finding]:
    """By the means of accelerations over all runs: of g, of codes."""
    felt = [i for i, c in enumerate(campaign.channels) if c.is_acceleration]
    if not felt:
        return
    mean = np.mean([run.record[:, felt].mean(axis=0) for run in campaign.runs], axis=0)
    names = ", ".join(campaign.channels[i].name for i in felt)
    if np.all(np.abs(mean) > SUSTAINED_M_S2):
        low, high = np.abs(mean).min(), np.abs(mean).max()
        yield Finding(
            "before",
            "units",
            f"units of {names}",
            f"The channels' means lie between {low:.0f} and {high:.0f}, as a converter's codes or"
            " mg do, and no vehicle holds 5 g.",
            "Give calibration.toml beside campaign.toml, or convert to m/s².",
            "certain",
        )
        return
    near = np.abs(np.abs(mean) - 1.0) < KEPT
    chance = 2 * KEPT * np.exp(-0.5 / OFFSET**2) / (OFFSET * np.sqrt(2 * pi)) * 2
    if near.all() and len(mean) * log(1 / chance) > log(1 / FALSE_ALARM):
        yield Finding(
            "before",
            "units",
            f"units of {names}",
            f"The channels' means are {mean.min():.2f} to {mean.max():.2f}: gravity in g, not in"
            " m/s².",
            f"Multiply the recordings by {STANDARD_GRAVITY_M_S2}.",
            "certain",
            fixes=(
                scaled(
                    campaign,
                    {c.name: STANDARD_GRAVITY_M_S2 for c in campaign.channels if c.is_acceleration},
                    "Convert the accelerations from g",
                ),
            ),
        )


def speed_findings(campaign: Campaign) -> Iterator[Finding]:
    """A channel of the vehicle's speed that shows other speeds than the runs state."""
    drives = [run.driven for run in campaign.runs if run.driven is not None]
    if not drives:
        return
    times = float(np.median([each.mean_m_s / each.stated_m_s for each in drives]))
    if abs(log(times)) <= log(1 + REACH):
        return
    name = drives[0].channel
    units = {unit: abs(log(times / factor)) for unit, factor in OTHER_SPEEDS.items()}
    unit = min(units, key=lambda each: units[each])
    seems = f": it seems to be in {unit}" if units[unit] < log(1 + REACH) else ""
    yield Finding(
        "before",
        "units",
        f"units of {name}",
        f"{name} shows {times:.3g} times the speeds that speed_kmph states{seems}.",
        f"Convert {name} to m/s, or correct speed_kmph.",
        fixes=(
            (scaled(campaign, {name: 1.0 / OTHER_SPEEDS[unit]}, f"Convert {name} from {unit}"),)
            if seems
            else ()
        ),
    )


def unit_findings(campaign: Campaign, vehicle: Vehicle, runs: Runs) -> Iterator[Finding]:
    """By how much more, or less, the runs move than the nominal vehicle would on their tracks."""
    told = [
        (d, m)
        for d, m in zip(runs.drives, runs.found, strict=True)
        if m.has_gain and isinstance(d, OnWaves)
    ]
    if not told:
        return
    gains = np.log([m.gain for _, m in told])
    hertz = np.array([m.speed_m_s / d.pitch_m for d, m in told])
    spread = float(np.hypot(OTHER, _believed(vehicle)))
    # Of several quantities each may be in another unit: `descriptions` has them one by one.
    quantity, several = campaign.leading.quantity, len(campaign.quantities) > 1
    other = {} if several else OTHER_UNITS[quantity]
    candidates = {unit: np.full(len(gains), log(value)) for unit, value in other.items()}
    if quantity == ACCELERATION and not several:
        candidates["m/s"] = -np.log(2 * pi * hertz)
    as_stated = float(np.mean(gains**2))
    left = {unit: float(np.mean((gains - log_gain) ** 2)) for unit, log_gain in candidates.items()}
    unit = min(left, key=lambda name: left[name], default="")
    common = float(np.median(gains))
    if left and (as_stated - left[unit]) / (2 * spread**2) > needed(len(left)):
        si = campaign.unit
        what = "velocities, m/s" if unit == "m/s" else f"recordings in {unit}, not {si}"
        high = {n: f for n, f in HEIGHT.items() if abs(abs(common) - log(f)) < spread}
        also = [f" (or track heights {_too(common, name)})" for name in high]
        in_si = {c.name: 1.0 / other[unit] for c in campaign.channels} if unit in other else {}
        yield Finding(
            "before",
            "units",
            f"units of {', '.join(c.name for c in campaign.channels)}",
            f"All runs together hold {_times(common)} the motion that the nominal vehicle has on"
            f" their tracks: {what}{''.join(also[:1])}.",
            f"Convert the recordings to {si} (wheelhop convert), and look at the tracks' heights.",
            fixes=(
                *([scaled(campaign, in_si, f"Convert all columns from {unit}")] if in_si else []),
                *(
                    heights(
                        campaign.runs,
                        factor if common > 0 else 1 / factor,
                        f"all tracks, {_too(common, name)},",
                    )
                    for name, factor in high.items()
                ),
            ),
        )
        return
    height = min(
        (s * log(f) for f in HEIGHT.values() for s in (-1, 1)), key=lambda x: abs(common - x)
    )
    if (common**2 - (common - height) ** 2) / (2 * spread**2) > needed(2 * len(HEIGHT)):
        yield Finding(
            "before",
            "heights",
            "track.amplitude_mm of all runs",
            f"All runs together hold {_times(common)} the motion that tracks of the"
            " stated heights cause.",
            "Look at the tracks' heights: keys ending in _mm take millimetres, from the middle to"
            " the crest.",
            fixes=(heights(campaign.runs, float(np.exp(height)), "all tracks"),),
        )
        return


def _too(log_gain: float, name: str) -> str:
    return f"in {name}" if log_gain > 0 else "too large by as much"


def _believed(vehicle: Vehicle) -> float:
    """Mean relative uncertainty of what decides how much a vehicle moves."""
    keys = [k for k in vehicle.values if k.startswith(("body", "suspension", "wheel"))]
    return float(np.mean([vehicle.uncertainty[k] / max(vehicle[k], 1e-12) for k in keys]))


def _times(log_gain: float) -> str:
    gain = float(np.exp(abs(log_gain)))
    return f"{gain:.3g} times" if log_gain >= 0 else f"1/{gain:.3g} of"
