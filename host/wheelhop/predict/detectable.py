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
from math import log
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from wheelhop.campaign import Campaign, CampaignError, Run
from wheelhop.compare import with_noise
from wheelhop.compare.band import InBand
from wheelhop.diagnose import Limit
from wheelhop.diagnose.baseline import check_comparable, started
from wheelhop.diagnose.confirm.validate import inexact
from wheelhop.diagnose.score import MATERIAL
from wheelhop.diagnose.screen.signatures import Variant, prepare, signatures
from wheelhop.diagnose.screen.table import Columns
from wheelhop.diagnose.verdict.limits import drop_needed, least_strength, limit
from wheelhop.effects import Effect, RunSetting
from wheelhop.fit import Fit, RunFit, Workshop, foreseen, initial_model, vehicle_parameters
from wheelhop.predict.additions import Addition, additions, with_channels
from wheelhop.predict.foresee import forms_of
from wheelhop.vehicle import Vehicle

Array = NDArray[np.float64]

MOST_RUNS, LONGEST_S = 6, 5.12
"""So many of the runs to fit are simulated, so long a piece of each; they stand for all of them."""
TINY = 1e-9
"""Precision, in units of the prior's, that keeps the equations of idle numbers regular."""
FURTHEST = 10.0
"""An effect that would be seen from less than a tenth on counts as one that is seen from a tenth:
no single one decides which channel to add."""


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
    `shapes` that `wheelhop simulate` gives it; `idle` the effects that do nothing on these roads.
    `best` is the channel, or the pair of channels, that would add most; None if none would add
    anything.
    """

    refused: str = ""
    limits: tuple[Limit, ...] = ()
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
    shown = _shown(workshop, base, variants, [weight for _, weight in pieces])
    equations = _Equations(base, variants, shown, least)
    strengths = equations.strengths(campaign, range(len(campaign.channels)))
    return Detectable(
        limits=equations.limits(strengths),
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


@dataclass(frozen=True, eq=False)
class _Shown:
    """One run's derivatives by what the variants have, and by how much those of the amplitudes (n,
    a) change where what moves the model is as wrong as it may be."""

    run: RunFit
    weight: float
    columns: Sequence[Columns]
    astray: Array


def _shown(
    workshop: Workshop, base: Fit, variants: Sequence[Variant], weights: Sequence[float]
) -> list[_Shown]:
    systems = workshop.systems(base.model)
    prepared = [prepare(workshop, base.model, variant) for variant in variants]

    def of_run(item: tuple[RunFit, float]) -> _Shown:
        run, weight = item
        columns = signatures(run, base.model, systems, prepared)
        astray = np.zeros((run.bench.size, sum(c.amplitudes.shape[1] for c in columns)))
        if (wrong := workshop.astray.get(run.bench.run.id)) is not None:
            wrongly = signatures(replace(run, bench=wrong), base.model, systems, prepared)
            pairs = zip(wrongly, columns, strict=True)
            astray = np.hstack([one.amplitudes - other.amplitudes for one, other in pairs])
        return _Shown(run, weight, columns, np.nan_to_num(astray, posinf=0.0, neginf=0.0))

    return workshop.each(of_run, list(zip(base.runs, weights, strict=True)))


@dataclass(frozen=True, eq=False)
class _Equations:
    """The derivatives of all records, per noise: by the vehicle's numbers and what every run leaves
    free (`base`), and by what the `variants` have (`shown`)."""

    base: Fit
    variants: Sequence[Variant]
    shown: Sequence[_Shown]
    least: float  #: share of the noise's power that is immaterial, or may be the simulation's error

    @property
    def settings(self) -> list[RunSetting]:
        """How the runs are driven."""
        return [run.bench.simulator.setting for run in self.base.runs]

    def limits(self, strengths: Sequence[float]) -> tuple[Limit, ...]:
        """What these least strengths of the variants, in scales of their amplitudes, are."""
        pairs = zip(self.variants, strengths, strict=True)
        return tuple(limit(variant, strength) for variant, strength in pairs)

    def strengths(self, campaign: Campaign, channels: Iterable[int]) -> list[float]:
        """From where on each effect would be seen by some of the channels in all of a campaign's
        runs."""
        kept = list(channels)
        grams = [_gram(shown, kept, self.base.sigma) for shown in self.shown]
        fitted, judging = (_data(self.base, campaign, kept, role) for role in ("fit", "validate"))
        judging = judging or fitted  # where no run is held out those fitted judge
        found = []
        for k, variant in enumerate(self.variants):
            information, wrong, price = self._of(k, grams)
            numbers = len(variant.shapes) + sum(not p.switch for p in variant.amplitudes)
            price += numbers * log(fitted)
            by_chance = drop_needed(price, fitted, judging, len(self.variants), 0.0)
            found.append(
                max(
                    least_strength(variant, information, by_chance),
                    # What is wrong of the effect itself grows with it, and may never be exceeded.
                    least_strength(variant, information - wrong, self.least * fitted),
                )
            )
        return found

    def _of(self, k: int, grams: Sequence[tuple[Array, Array]]) -> tuple[Array, Array, float]:
        """What the runs tell of the amplitudes of one variant (a, a), how wrong what moves the
        model makes it (a, a), and what the variant's own numbers in all runs cost."""
        g, amplitudes = len(self.base.shared), len(self.variants[k].amplitudes)
        total, price = np.zeros((g + amplitudes, g + amplitudes)), 0.0
        wrong = np.zeros((amplitudes, amplitudes))
        among = sum(len(variant.amplitudes) for variant in self.variants[:k])
        for shown, (gram, astray) in zip(self.shown, grams, strict=True):
            run, columns = shown.run, shown.columns
            r, q = len(run.own), columns[k].own.shape[1]
            before = r + g + sum(c.own.shape[1] + c.amplitudes.shape[1] for c in columns[:k])
            mine = np.arange(before, before + q + amplitudes)
            order = np.concatenate([np.arange(r), mine[:q], np.arange(r, r + g), mine[q:]])
            matrix = gram[np.ix_(order, order)]
            prior = np.array([(f.scale / f.sigma) ** 2 for f in run.own] + [1.0] * q)
            inner = matrix[: r + q, : r + q] + np.diag(prior * (1.0 + TINY) + TINY)
            across = matrix[: r + q, r + q :]
            rest = matrix[r + q :, r + q :] - across.T @ np.linalg.solve(inner, across)
            total += shown.weight * rest
            own = np.linalg.slogdet(inner)[1] - np.linalg.slogdet(inner[:r, :r])[1]
            price += shown.weight * float(own)
            mine = np.arange(among, among + amplitudes)
            wrong += shown.weight * astray[np.ix_(mine, mine)]
        shared = total[:g, :g] + self.base.believed + TINY * np.eye(g)
        told = total[g:, g:] - total[g:, :g] @ np.linalg.solve(shared, total[:g, g:])
        return np.asarray(told), wrong, price


def _gram(shown: _Shown, kept: Sequence[int], sigma: float) -> tuple[Array, Array]:
    """Products, per noise power, of all of a run's columns as some channels show them: its own
    numbers, the shared ones, and for each variant its numbers in the run and its amplitudes; and
    those of what is wrong of the amplitudes'."""
    run = shown.run
    shared, own = np.split(run.jacobian, [run.derivatives.shared], axis=1)
    parts = (part for c in shown.columns for part in (c.own, c.amplitudes))
    every = np.nan_to_num(np.hstack([own, shared, *parts]), posinf=0.0, neginf=0.0)
    seen, astray = (run.bench.seen_by(part, kept) / sigma for part in (every, shown.astray))
    return np.asarray(seen.T @ seen), np.asarray(astray.T @ astray)


def _data(base: Fit, campaign: Campaign, kept: Sequence[int], role: str) -> int:
    """In-band data of the runs of a role, of as many channels as are predicted in the pieces."""
    predicted = np.mean([run.bench.predicted[list(kept)].sum() for run in base.runs])
    counts = (
        InBand(len(run.time_s), campaign.sample_rate_hz, campaign.band_hz).count
        for run in campaign.runs
        if run.role == role
    )
    return round(float(predicted) * sum(counts))


def _best(
    equations: _Equations, campaign: Campaign, offered: Sequence[Addition], before: Sequence[float]
) -> Added | None:
    """The addition with which least is enough, by the product of how many times less it is over all
    effects that are seen then; None where nothing gains."""
    own = len(campaign.channels)
    first, best, most = own, None, 0.0
    for one in offered:
        kept = [*range(own), *range(first, first + len(one.channels))]
        first += len(one.channels)
        after = equations.strengths(campaign, kept)
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
    best = found.best
    return {
        "refused": found.refused,
        "limits": [
            {**asdict(one), "shapes": dict(found.shapes[one.effect])} for one in found.limits
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
