"""What a setting is judged by, and the rides that tell it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.effects.balance import share
from wheelhop.fit.bench import processors, run_up
from wheelhop.predict.case import Case, stands
from wheelhop.predict.ride import Ride, Rider
from wheelhop.simulate.lanes import LANES
from wheelhop.vehicle import axles

Array = NDArray[np.float64]
Values = Mapping[str, float]
STOP = "bump-stop"


@dataclass(frozen=True)
class Objective:
    """Something that shall be small. `of` takes the rides of all runs and the car's numbers."""

    name: str
    title: str
    unit: str
    of: Callable[[Sequence[Ride], Values], float]


def _rms(values: Sequence[float]) -> float:
    """Root of the mean square of what there is: runs are of one length (ISO 2631-1, B.3)."""
    return float(np.sqrt(np.nanmean(np.square(values))))


def _travel(rides: Sequence[Ride], values: Values) -> float:
    """Largest travel of a strut; of a car with stops, over the way to them."""
    largest = 0.0
    for end in axles(values):
        peak = max(getattr(ride, f"travel_{end}_peak_m") for ride in rides)
        own = {k.removeprefix(f"{STOP}."): v for k, v in values.items() if k.startswith(f"{STOP}.")}
        largest = max(
            largest, peak / (share(own, "clearance_m", "clearance_balance", end) if own else 1)
        )
    return largest


OBJECTIVES: Mapping[str, Objective] = {
    one.name: one
    for one in (
        Objective(
            "comfort",
            "weighted acceleration (ISO 2631-1, Wk)",
            "m/s²",
            lambda rides, _: _rms([ride.comfort_wk_rms_m_s2 for ride in rides]),
        ),
        Objective(
            "road-holding",
            "variation of the tyres' load, rms over static",
            "1",
            lambda rides, _: _rms(
                [x for ride in rides for x in (ride.dynamic_load_front, ride.dynamic_load_rear)]
            ),
        ),
        Objective("travel", "largest travel", "m", _travel),
        Objective(
            "roll",
            "roll of the body, rms",
            "rad",
            lambda rides, _: _rms([r.roll_rms_rad for r in rides]),
        ),
    )
}


class Judge:
    """Rides settings on the runs of a case, prepared once. `count` is how many it has ridden; every
    ride runs up until the slowest of the `extremes`, settings too, has forgotten its start."""

    def __init__(
        self, case: Case, objectives: Sequence[Objective], extremes: Sequence[Values] = ()
    ) -> None:
        self.case, self.objectives, self.count = case, objectives, 0
        models = [case.nominal.with_values(setting) for setting in extremes]
        systems = [model.system(case.channels, "road") for model in models]
        longest = max((run_up({"road": s}) for s in systems if stands(s)), default=0.0)
        self._riders = [Rider(case, number, longest) for number in range(len(case.drives))]
        self._threads = min(processors(), len(self._riders))

    def rides(self, settings: Sequence[Values]) -> list[list[Ride] | None]:
        """The rides of settings, each on all runs; None where a vehicle runs away."""
        self.count += len(settings)
        parts = [settings[i : i + LANES] for i in range(0, len(settings), LANES)]
        with ThreadPoolExecutor(self._threads) as pool:
            by_run = list(
                pool.map(lambda rider: [r for p in parts for r in rider.rides(p)], self._riders)
            )
        found: list[list[Ride] | None] = []
        for of_setting in zip(*by_run, strict=True):
            whole = [ride for ride in of_setting if ride is not None]
            found.append(whole if len(whole) == len(by_run) else None)
        return found

    def score(self, settings: Sequence[Values]) -> Array:
        """The objectives (settings, k); infinite where a vehicle runs away."""
        values = self.case.nominal.values
        return np.array(
            [
                [np.inf] * len(self.objectives)
                if rides is None
                else [o.of(rides, {**values, **s}) for o in self.objectives]
                for s, rides in zip(settings, self.rides(settings), strict=True)
            ]
        ).reshape(len(settings), len(self.objectives))


def read_objectives(names: Sequence[str]) -> tuple[Objective, ...]:
    """Objectives by name; raises CampaignError for one that there is not."""
    for name in names:
        if name not in OBJECTIVES:
            raise CampaignError(
                f"--objective {name}: there is none: choose from {', '.join(OBJECTIVES)}"
            )
    if not names:
        raise CampaignError(f"--objective: give one or more of {', '.join(OBJECTIVES)}")
    return tuple(OBJECTIVES[name] for name in dict.fromkeys(names))
