"""What the channels and roads of a campaign can show, before any diagnosis.

The derivatives of the records by the vehicle's numbers, by what every run leaves free and by every
effect's strength follow from the nominal vehicle, and the noise is stated or estimated: so the
detection limits of a diagnosis (`wheelhop.diagnose.verdict.limits`) are known beforehand, to first
order. Those with further channels follow likewise: these are simulated beside the channels there
are, and the equations are formed with them and without.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from math import inf, log
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from wheelhop.campaign import Campaign, CampaignError, Run
from wheelhop.compare import with_noise
from wheelhop.diagnose import Limit
from wheelhop.diagnose.baseline import check_comparable, started
from wheelhop.diagnose.confirm.validate import inexact
from wheelhop.diagnose.score import MATERIAL
from wheelhop.effects import Effect
from wheelhop.fit import Workshop, foreseen, initial_model, vehicle_parameters
from wheelhop.predict.additions import Addition, additions, with_channels
from wheelhop.predict.equations import Equations, shown_by
from wheelhop.predict.foresee import forms_of
from wheelhop.vehicle import Vehicle

Array = NDArray[np.float64]

MOST_RUNS, LONGEST_S = 6, 5.12
"""So many of the runs to fit are simulated, so long a piece of each; they stand for all of them."""
FURTHEST = 10.0
"""An effect that would be seen from less than a tenth on counts as one that is seen from a tenth:
no single one decides which channel to add."""


@dataclass(frozen=True)
class Told:
    """From where on an effect would be told from its `rival`, the effect most like it here ("" if
    there is no other), and how many `times` as strong it has to be for that as to be seen."""

    rival: str
    limit: Limit
    times: float


@dataclass(frozen=True)
class Added:
    """Channels that could be added, in words; from where on effects would be seen with them, and
    by which factor that is `less` than without."""

    channels: str
    limits: tuple[Limit, ...]
    less: Mapping[str, float]


@dataclass(frozen=True)
class Detectable:
    """What a campaign's channels and roads can show.

    `refused` is why nothing can be compared, with what would cure it; empty if something can.
    `limits` are the least strengths that would be seen, of each effect in its first form, with the
    `shapes` that `wheelhop simulate` gives it, and `told` those that would be told from what is
    most like it; `idle` the effects that do nothing on these roads.
    `best` is the channel, or the pair of channels, that would add most; None if none would add
    anything.
    """

    refused: str = ""
    limits: tuple[Limit, ...] = ()
    told: tuple[Told, ...] = ()
    shapes: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    idle: tuple[str, ...] = ()
    best: Added | None = None


def detectable(
    campaign: Campaign,
    vehicle: Vehicle,
    effects: Iterable[Effect],
    jobs: int | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> Detectable:
    """What a campaign of a vehicle can show of these effects, physics and not faults of sensors.

    It is as quick as few runs are simulated: `MOST_RUNS`. Raises nothing of its own.
    """
    try:
        check_comparable(campaign, vehicle)
        with threadpool_limits(1):
            return _detectable(campaign, vehicle, effects, jobs, progress)
    except CampaignError as error:
        return Detectable(refused=str(error))


def _detectable(
    campaign: Campaign,
    vehicle: Vehicle,
    effects: Iterable[Effect],
    jobs: int | None,
    progress: Callable[[str], None],
) -> Detectable:
    stated = with_noise(campaign)
    pieces = _representative(stated)
    few = replace(stated, runs=tuple(piece for piece, _ in pieces))
    numbers, model = tuple(vehicle_parameters(few, vehicle)), initial_model(few, vehicle)
    progress("what these channels can show: finding each run's start")
    placing = Workshop(few, model, measured=vehicle.measured, jobs=jobs)
    model = started(placing, model, numbers)
    offered = additions(stated, vehicle.values)
    wide = with_channels(few, tuple(channel for one in offered for channel in one.channels))
    workshop = Workshop(wide, model, measured=vehicle.measured, jobs=jobs)
    progress("what these channels can show: simulating each effect")
    base = foreseen(workshop, model, numbers, tuple(workshop.benches.values()))
    if not np.isfinite(base.precision).all():
        raise CampaignError(f"{campaign.vehicle_file}: a vehicle with these numbers runs away")
    physics = [e for e in effects if e.place != "sensor" and e.applies_to(vehicle.values)]
    variants = [form for effect in physics for form in forms_of(base, workshop, effect)[:1]]
    least = MATERIAL + inexact(workshop, base)()
    shown = shown_by(workshop, base, variants, [weight for _, weight in pieces])
    equations = Equations(base, variants, shown, least)
    now = equations.seen(range(len(campaign.channels)))
    strengths, rivals = now.strengths(campaign), now.rivals(campaign)
    names, told = [name for name, _ in rivals], [strength for _, strength in rivals]
    times = [
        least / seen if seen < inf else 1.0 for least, seen in zip(told, strengths, strict=True)
    ]
    return Detectable(
        limits=equations.limits(strengths),
        told=tuple(map(Told, names, equations.limits(told), times)),
        shapes={variant.effect.id: variant.shapes for variant in variants},
        idle=tuple(e.id for e in physics if not any(map(e.acts_in, equations.settings))),
        best=_best(equations, campaign, offered, strengths),
    )


def _representative(campaign: Campaign) -> list[tuple[Run, float]]:
    """Pieces of some of the runs to fit, and how many times as long what each of them stands for
    is: runs in the order of their tracks and of how much they move, each of so many groups by the
    middle one."""
    scale = campaign.noise_scale

    def moved(run: Run) -> float:
        return float(np.sum((run.record / scale).var(axis=0)))

    ordered = sorted(campaign.fit_runs, key=lambda run: (repr(run.track), moved(run)))
    groups = np.array_split(np.arange(len(ordered)), min(MOST_RUNS, len(ordered)))
    found = []
    for group in groups:
        piece = _piece(ordered[group[len(group) // 2]], campaign)
        samples = sum(len(ordered[i].time_s) for i in group)
        found.append((piece, samples / len(piece.time_s)))
    return found


def _piece(run: Run, campaign: Campaign) -> Run:
    """Of a long run the piece that moves as much as all of it, as nearly as any does."""
    rows, length = len(run.time_s), round(LONGEST_S * campaign.sample_rate_hz)
    if rows <= length:
        return run
    record = run.record / campaign.noise_scale
    power = np.append(0.0, np.cumsum(((record - record.mean(axis=0)) ** 2).sum(axis=1)))
    held = (power[length:] - power[:-length]) / length
    first = int(np.argmin(np.abs(held - power[-1] / rows)))
    part = slice(first, first + length)
    known = {name: values[part] for name, values in run.known.items()}
    return replace(run, time_s=run.time_s[part], record=run.record[part], known=known)


def _best(
    equations: Equations, campaign: Campaign, offered: Sequence[Addition], before: Sequence[float]
) -> Added | None:
    """The addition with which least is enough, by the product of how many times less it is over all
    effects that are seen then; None where nothing gains."""
    own = len(campaign.channels)
    first, best, most = own, None, 0.0
    for one in offered:
        kept = [*range(own), *range(first, first + len(one.channels))]
        first += len(one.channels)
        after = equations.seen(kept).strengths(campaign)
        limits = equations.limits(after)
        less = {
            seen.effect: float(min(was / now, FURTHEST))
            for was, now, seen in zip(before, after, limits, strict=True)
            if seen.shown
        }
        gained = sum(map(log, less.values()))
        if gained > most:
            most, best = gained, Added(one.words, limits, less)
    return best


def to_json(found: Detectable) -> dict[str, Any]:
    """As `check --json` writes it."""
    best, rows = found.best, zip(found.limits, found.told, strict=True)
    return {
        "refused": found.refused,
        "limits": [
            {
                **asdict(one),
                "shapes": dict(found.shapes[one.effect]),
                "rival": told.rival,
                "told_from": dict(told.limit.amplitudes) if told.limit.shown else None,
            }
            for one, told in rows
        ],
        "idle": list(found.idle),
        "best": None
        if best is None
        else {
            "channels": best.channels,
            "limits": [asdict(one) for one in best.limits],
            "less": dict(best.less),
        },
    }
