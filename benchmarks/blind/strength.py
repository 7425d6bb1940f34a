"""How strong an effect is to a user: what the fitted baseline leaves on held-out runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, inf, log, sqrt
from pathlib import Path

from tests.truth.effect import Effect
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.diagnose import comparison_of, fit_baseline
from wheelhop.vehicle import read_vehicle

TRIALS = 9
LONGEST_STEP = log(8.0)
INVISIBLE = 0.03  # of the noise: less than that cannot be told from none


class Unreachable(Exception):
    """No amount of an effect shows as much as wanted on this car and these tracks."""


@dataclass(frozen=True)
class Hidden:
    """An effect as a function of an amount: 0 is absent, 1 is plainly visible on most vehicles."""

    at: Callable[[float], Effect]
    most: float = 20.0  # largest amount that makes sense
    by_severity: bool = False  # there or not: only rougher tracks show more of it


@dataclass(frozen=True)
class Wanted:
    """Held-out error of the fitted baseline over the noise floor: what to aim at, what will do."""

    aim: float
    low: float
    high: float


def baseline_over_floor(folder: Path) -> tuple[float, float]:
    """Error of the fitted baseline over that of the noise alone, held-out runs and fitted runs;
    infinite where the simulation ran away."""
    try:
        campaign = read_campaign(folder)
    except CampaignError:  # a number is missing
        return inf, inf
    vehicle = read_vehicle(campaign.vehicle_file)
    base = fit_baseline(campaign, vehicle, jobs=1, progress=lambda text: None)
    floor = comparison_of(base.workshop, base.rung).floor
    held_out = base.rung.error_validate / floor.error_validate
    return float(held_out), float(base.rung.error_fit / floor.error_fit)


def seek(
    measure: Callable[[float], float],
    wanted: Wanted,
    start: float,
    bounds: tuple[float, float],
) -> tuple[float, float]:
    """The amount at which `measure` gives the ratio wanted, and that ratio.

    Secant steps on the effect's own part of the residual, sqrt(ratio^2 - 1), against the amount,
    both logarithmic; halving where a step would leave the bracket. Raises Unreachable.
    """
    (least, most), slope = bounds, 1.0
    amount, below, above = min(start, most), least, most
    last: tuple[float, float] | None = None
    for _ in range(TRIALS):
        ratio = measure(amount)
        if wanted.low <= ratio <= wanted.high and ratio < inf:
            return amount, ratio
        part = log(own_part(ratio))
        if last is not None and abs(log(amount) - last[0]) > 1e-6:
            slope = min(max((part - last[1]) / (log(amount) - last[0]), 0.5), 5.0)
        last = (log(amount), part)
        missing = log(own_part(wanted.aim)) - part
        if missing > 0.0:
            below = max(below, amount)
        else:
            above = min(above, amount)
        step = min(max(missing / slope, -LONGEST_STEP), LONGEST_STEP)
        following = min(max(amount * exp(step), least), most)
        if not below < following < above:
            following = most if above == most else sqrt(below * above)
        if amount >= most and missing > 0.0:
            break
        amount = following
    raise Unreachable(f"{ratio:.3g} times the floor at the amount {amount:.3g}")


def own_part(ratio: float) -> float:
    """What an effect alone leaves over the floor, when it and the noise leave `ratio`."""
    return sqrt(max(ratio**2 - 1.0, INVISIBLE**2))
