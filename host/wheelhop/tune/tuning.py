"""What tuning finds: the present setting, the front, the proposed one, and what effects cost."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from wheelhop.campaign import CampaignError
from wheelhop.effects import Amplitude, Switch
from wheelhop.predict.case import Case
from wheelhop.predict.drives import Chosen, Drive
from wheelhop.predict.known_car import KnownCar, parameters
from wheelhop.predict.ride import Ride
from wheelhop.tune.objectives import STOP, Judge, Objective
from wheelhop.tune.search import FRONT, LEVELS, Search, Tried, compromise, spread_out
from wheelhop.tune.variables import Freedom, Variable

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]
Values = Mapping[str, float]

DRAWS = 24
"""Cars drawn from what is known of it: their spread is known to 1/√46 = 15 %."""
SURE = 0.95
"""Share of the cars that an interval is to hold."""
SETTINGS = 800
"""Settings that the search rides: twenty generations. With 18 variables on 3 tracks all rides are
3600, of which a processor does about 130 a second: half a minute, and less on two."""


@dataclass(frozen=True)
class Gain:
    """By how much less an objective is than now; `half` of the interval's width that holds it for
    95 % of the cars the real one may be."""

    value: float
    half: float

    @property
    def is_sure(self) -> bool:
        """Whether it is more than what is not known of the car."""
        return self.value > self.half

    @property
    def is_loss(self) -> bool:
        """Whether it is surely a loss."""
        return -self.value > self.half


@dataclass(frozen=True, eq=False)
class Setting:
    """A setting: values by the variables' names, objectives, and gains against now."""

    values: Values
    scores: Array
    gains: tuple[Gain, ...]


@dataclass(frozen=True, eq=False)
class Cost:
    """What an effect costs: by how much less the objectives (k,) would be without it, and with half
    of it; `amplitudes` are those that were taken away, by their names."""

    effect: str
    amplitudes: Values
    whole: Array
    half: Array


@dataclass(frozen=True, eq=False)
class Tuning:
    """What was tried and found. `front` has the proposed setting first. `alone` (d, k) is the most
    that each variable gains by itself, `dampers` (k,) what the dampers do, where they are varied.
    `rides` are those of every run, now and proposed."""

    car: KnownCar
    drives: tuple[Drive, ...]
    objectives: tuple[Objective, ...]
    variables: tuple[Variable, ...]
    now: Setting
    front: tuple[Setting, ...]
    alone: Array
    dampers: Array | None
    costs: tuple[Cost, ...]
    rides: tuple[list[Ride], list[Ride]]
    tried: Array
    count: int

    def to_dataframe(self) -> DataFrame:
        """The settings as a table.

        Returns
        -------
        DataFrame
            The present setting and those of the front, the proposed or best compromise first after
            it: variables, objectives, and what they gain with half of the 95 % interval; SI.
        """
        import pandas

        rows = []
        for one in (self.now, *self.front):
            row = dict(one.values)
            for objective, score, gain in zip(self.objectives, one.scores, one.gains, strict=True):
                row[objective.name] = float(score)
                row[f"{objective.name} gain"], row[f"{objective.name} ±"] = gain.value, gain.half
            rows.append(row)
        return pandas.DataFrame(rows, index=["now", *range(1, len(rows))])

    @property
    def proposed(self) -> Setting | None:
        """The setting to take: the one whose least gain, over what the objective is now, is
        largest; None where no gain of it is more than what is not known of the car."""
        first = self.front[0]
        return first if any(gain.is_sure for gain in first.gains) else None


def tune_car(
    car: KnownCar,
    drives: tuple[Drive, ...],
    objectives: Sequence[Objective],
    freedom: Freedom,
    *,
    seconds: float,
    settings: int = SETTINGS,
    seed: int = 0,
    progress: Callable[[str], None] = lambda text: None,
) -> Tuning:
    """Search the settings of a car on the tracks it drives.

    Raises
    ------
    CampaignError
        The car as it is does not stay in its place, or an objective of it is 0.
    """
    chosen = car.effects
    if freedom.curves is not None:
        standing = {p.name: p.start for p in parameters(freedom.curves, car.vehicle.values)}
        chosen = (*chosen, Chosen(freedom.curves, standing))
    progress(f"preparing {len(drives)} runs")
    ends = [freedom.changes([share] * len(freedom.variables)) for share in (0.0, 1.0)]
    judge = Judge(Case(car.vehicle, chosen, drives, seconds, seed), objectives, ends)
    search = Search(judge, freedom)
    now = judge.score([{}])[0]
    for objective, score in zip(objectives, now, strict=True):
        if not (np.isfinite(score) and score > 0.0):
            raise CampaignError(
                f"--objective {objective.name}: is {score:g} for the car as it is: leave it out"
            )
    progress("each variable alone")
    alone = search.alone()
    dampers = search.dampers()
    tried = search.whole(search.known(alone, dampers), settings, progress)
    places = tried.front
    best = compromise(tried.scores[places], now)
    picked = places[spread_out(tried.scores[places], [best], FRONT)]
    progress("what is not known of the car")
    present, front = _with_gains(car, judge, freedom, now, tried, picked, seed)
    each = alone.scores.reshape(len(freedom.variables), LEVELS, len(now))
    both = judge.rides([{}, freedom.changes(tried.shares[picked[0]])])
    assert both[0] is not None and both[1] is not None  # they have been ridden before
    return Tuning(
        car,
        drives,
        tuple(_in_unit(o, car.values) for o in objectives),
        freedom.variables,
        present,
        front,
        now - each.min(axis=1),
        None if dampers is None else now - dampers.scores.min(axis=0),
        tuple(_costs(car, judge, now)),
        (both[0], both[1]),
        tried.scores,
        judge.count,
    )


def _in_unit(objective: Objective, values: Values) -> Objective:
    """Travel of a car with stops is over the way to them."""
    if objective.name == "travel" and any(name.startswith(f"{STOP}.") for name in values):
        return replace(objective, title="largest travel over the way to the stops", unit="1")
    return objective


def _with_gains(
    car: KnownCar,
    judge: Judge,
    freedom: Freedom,
    now: Array,
    tried: Tried,
    picked: NDArray[np.int64],
    seed: int,
) -> tuple[Setting, tuple[Setting, ...]]:
    """The present setting and those picked, each with what it gains.

    A drawn car rides both settings; what a setting changes is added to the drawn car's own number,
    as turning a valve does. So whatever both have in common falls out of a gain. The mean square by
    which the cars' gains differ from the one stated, and the square of what the model is wrong by
    in the records (E times the objective now), make the interval, by Student's t.
    """
    middle, cars = car.values, car.draws(DRAWS, np.random.default_rng([seed, 2]))
    settings = [freedom.changes(tried.shares[i]) for i in picked]
    moved = [{k: v - middle[k] for k, v in s.items() if k in middle} for s in settings]
    rows: list[Values] = []
    for one in cars:
        rows.append(one)
        for setting, more in zip(settings, moved, strict=True):
            turned = {k: one.get(k, middle[k]) + v for k, v in more.items()}
            rows.append({**setting, **one, **car.bounded(turned)})
    scores = judge.score(rows).reshape(len(cars), 1 + len(settings), len(now))
    gains = scores[:, :1] - scores[:, 1:]
    stays = np.isfinite(gains).all(axis=(1, 2))
    wide = float(stats.t.ppf(0.5 + SURE / 2, max(int(stays.sum()) - 1, 1)))
    stated_gain = now - tried.scores[picked]
    away = np.inf if not stays.any() else ((gains[stays] - stated_gain) ** 2).mean(axis=0)
    half = wide * np.sqrt(away + (car.misfit * now) ** 2)
    keys = {v.key: v.name for v in freedom.variables}
    front = tuple(
        Setting(
            {keys[k]: v for k, v in setting.items()},
            tried.scores[i],
            tuple(map(Gain, (now - tried.scores[i]).tolist(), of.tolist())),
        )
        for i, setting, of in zip(picked, settings, half, strict=True)
    )
    at = {v.name: v.now for v in freedom.variables}
    return Setting(at, now, tuple(Gain(0.0, 0.0) for _ in now)), front


def _costs(car: KnownCar, judge: Judge, now: Array) -> list[Cost]:
    """Of every effect of the car that can be there more or less."""
    found, settings = list[tuple[str, dict[str, float]]](), list[Values]()
    for one in car.effects:
        own = [p for p in parameters(one.effect, car.vehicle.values) if isinstance(p, Amplitude)]
        there = {
            p.name: one.values[p.name]
            for p in own
            if not isinstance(p, Switch) and one.values[p.name] != p.absent
        }
        absent = {p.name: p.absent for p in own}
        if there:
            found.append((one.effect.id, there))
            for left in (0.0, 0.5):
                settings.append(
                    {
                        f"{one.effect.id}.{k}": absent[k] + left * (v - absent[k])
                        for k, v in there.items()
                    }
                )
    scores = judge.score(settings) if settings else np.zeros((0, len(now)))
    return [
        Cost(id_, there, now - scores[2 * i], now - scores[2 * i + 1])
        for i, (id_, there) in enumerate(found)
    ]
