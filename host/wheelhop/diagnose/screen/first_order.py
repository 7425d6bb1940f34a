"""Screening: how much of the residual each effect could explain, to first order.

Signatures and residual are projected off everything the baseline could still absorb (vehicle
parameters with their priors, what each run leaves free); the drop in the cost that remains is the
effect's score.

Any residual is explained to a part by heights of the ground that may be chosen freely: two unknowns
for eight channels. Two controls tell whether it was the ground. The rear wheels must meet what the
front wheels met: if heights of its own under every wheel make better use of their greater freedom,
it was not. And heights must be random, which lines that follow from the known track are not: these
are set aside, and what heights are worth without them decides.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import log
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.score import all_noise
from wheelhop.diagnose.screen.signatures import Prepared, Variant, prepare, signatures, variants
from wheelhop.diagnose.screen.table import Columns, Known, Table, beyond, run_table
from wheelhop.effects import Amplitude, Effect, RandomHeights, Switch
from wheelhop.fit import (
    Explained,
    Fit,
    Ground,
    Noise,
    RunFit,
    Spectrum,
    Workshop,
    explained,
    find_density,
)
from wheelhop.vehicle import Drive, System

Array = NDArray[np.float64]

ABSURD = 1e3  # times its scale no amplitude is believed to be: one standard deviation

AT_ONCE = 8  # variants are held in memory together: each takes a table of every run

NEAR, FEW = 0.6, 2
"""So many variants of an effect that explain this share of what the best does, or one of each form,
are kept."""

LINE = 5.0
"""A frequency so many times as far from what is expected as the middle one is a line: of the
eight coefficients of four channels (χ²) one of eighty thousand is so by chance."""

MOST = 0.5
"""Heights are random if this share of what they are worth remains without lines. Random ones keep
all of it; of those that stand for a stop or a wandering speed nearly all goes with the lines."""


class Heights(NamedTuple):
    """What heights of the best density would explain: its parameters, the drop of the cost, how
    much of that they are worth after their price, the degrees of freedom they spend, and the sum of
    squares they leave."""

    theta: dict[str, float]
    gain: float
    worth: float
    freedom: float
    rss: float


def screen_heights(workshop: Workshop, base: Fit, effect: RandomHeights) -> Heights | None:
    """The heights that explain the base's residual best; None if no run rolls on a track."""
    if all(run.bench.simulator.series is None for run in base.runs):
        return None
    spectra, apart = (_spectra(workshop, base, coherent) for coherent in (True, False))
    kept = [np.ones(len(spectrum.energy), bool) for spectrum in spectra]
    whole = random = _best(workshop, base, effect, spectra, kept)
    # Small lines hide behind large ones.
    while (lines := random.found.surprise > LINE * np.median(random.found.surprise)).any():
        kept = _without(kept, lines)
        random = _best(workshop, base, effect, spectra, kept)
    control = _best(workshop, base, effect, apart, kept)
    is_ground = random.worth > max(control.worth, MOST * whole.worth)
    worth = 2.0 * random.worth
    gain = worth - random.found.log_volume
    worth = worth if is_ground else -abs(gain)
    return Heights(random.theta, gain, worth, random.found.freedom, base.rss - random.taken)


class _Density(NamedTuple):
    """The best density of some frequencies, what its heights explain, the sum of squares they take
    out, and the logarithm of how much likelier they make these records."""

    theta: dict[str, float]
    found: Explained
    taken: float
    worth: float


def _spectra(workshop: Workshop, base: Fit, coherent: bool) -> list[Spectrum]:
    systems = workshop.systems(base.model)
    return [
        Spectrum.of(
            Ground(run.bench, base.model, systems[run.bench.drive], coherent),
            run.residual,
            run.residual,
        )
        for run in base.runs
        if run.bench.simulator.series is not None
    ]


def _best(
    workshop: Workshop,
    base: Fit,
    effect: RandomHeights,
    spectra: Sequence[Spectrum],
    kept: Sequence[NDArray[np.bool_]],
) -> _Density:
    parts = [spectrum.at(mask) for spectrum, mask in zip(spectra, kept, strict=True)]
    rss = base.rss + sum(p.residual - s.residual for p, s in zip(parts, spectra, strict=True))
    on_ground = [run.bench for run in base.runs if run.bench.simulator.series is not None]
    gone = zip(on_ground, kept, strict=True)
    size = base.size - round(sum(bench.size * float((~mask).mean()) for bench, mask in gone))
    parameters = workshop.parameters_of(effect)
    given = sum(len(run.own) for run in base.runs) + len(base.shared)
    start = {p.name: p.start for p in parameters}
    noise = Noise(rss, size - given, workshop.noise)
    without = noise.sigma
    theta, noise = find_density(effect, parameters, start, parts, noise)
    found = explained(effect, theta, parts, noise.sigma)
    worth = found.evidence(size, noise.sigma) + 0.5 * rss / without**2 + size * log(without)
    return _Density(theta, found, rss - noise.rss, worth)


def _without(
    kept: Sequence[NDArray[np.bool_]], lines: NDArray[np.bool_]
) -> list[NDArray[np.bool_]]:
    """The frequencies kept but for those among them that are lines."""
    is_line = iter(np.split(lines, np.cumsum([mask.sum() for mask in kept])))
    fewer = [mask.copy() for mask in kept]
    for mask in fewer:
        mask[mask] = ~next(is_line)
    return fewer


@dataclass(frozen=True)
class Screened:
    """An effect's best variant: the amplitudes (and per-run values) it would take, the drop of
    the cost, the number of parameters that bought it and their price, and the error E that
    would be left. ``contribution`` (size,) per run is free of what the run itself could absorb;
    ``along`` is how the base's shared parameters would move with it, and ``others`` are further
    variants that screening cannot dismiss. ``information`` (a, a) is the amplitudes' precision if
    nothing but noise is left."""

    variant: Variant
    amplitudes: Mapping[str, float]
    gain: float
    freedom: float
    price: float
    error: float
    contribution: Mapping[str, NDArray[np.floating]]
    information: Array
    along: Mapping[str, float] = field(default_factory=dict)
    others: tuple[Screened, ...] = ()

    @property
    def id(self) -> str:
        """The effect's id."""
        return self.variant.effect.id

    @property
    def score(self) -> float:
        """Half of the gain less the price of its parameters: a logarithm of evidence."""
        return 0.5 * (self.gain - self.price)


def screen(workshop: Workshop, base: Fit, effects: Sequence[Effect]) -> list[Screened]:
    """Screen all `effects` against the residual of `base`; best first.

    Effects that do not apply to this campaign are left out.
    """
    return _screened(workshop, base, effects, _forms(workshop, base, effects))


def screen_best(workshop: Workshop, base: Fit, effects: Sequence[Effect]) -> list[Screened]:
    """Screen `effects` where only the best count: first in the runs that tell most; then, in all
    runs, those that explained there at least half as much as the best. Switches stay: first order
    says little of them."""
    forms = _forms(workshop, base, effects)
    if effects and not all_noise(base, workshop.noise):
        found = _screened(workshop, replace(base, runs=telling(base)), effects, forms)
        best = max((s.gain for s in found), default=0.0)
        kept = {s.id for s in found if s.gain >= best / 2 or s.freedom == 0}
        effects = [effect for effect in effects if effect.id in kept]
    return _screened(workshop, base, effects, forms)


def _forms(workshop: Workshop, base: Fit, effects: Sequence[Effect]) -> list[Variant]:
    return [variant for effect in effects for variant in variants(workshop, base, effect)]


def _screened(
    workshop: Workshop, base: Fit, effects: Sequence[Effect], forms: Sequence[Variant]
) -> list[Screened]:
    """These effects in their forms, those of others left out; best first."""
    ids = {effect.id for effect in effects}
    chosen = [variant for variant in forms if variant.effect.id in ids]
    found: dict[str, list[Screened]] = {}
    alone = taken_alone(base)
    for variant, tables in tabulated(workshop, base, chosen):
        found.setdefault(variant.effect.id, []).append(solve(base, variant, tables, alone))
    best = {effect_id: _best_of(results) for effect_id, results in found.items()}
    for effect in (e for e in effects if isinstance(e, RandomHeights)):
        if heights := _screened_heights(workshop, base, effect):
            best[effect.id] = heights
    return sorted(best.values(), key=lambda s: -s.score)


def telling(base: Fit) -> tuple[RunFit, ...]:
    """The fewest runs that hold half of what is left above the noise."""
    above = [run.bench.cost(run.residual, base.sigma) - run.bench.size for run in base.runs]
    most_first = np.argsort(above)[::-1]
    held = np.cumsum(np.maximum(above, 0.0)[most_first])
    enough = most_first[: 1 + int(np.searchsorted(held, held[-1] / 2))]
    return tuple(base.runs[i] for i in sorted(enough))


class Taken(NamedTuple):
    """What a step to first order takes: the drop of the cost, and the sum of squares it leaves."""

    gain: float
    rss: float


def taken_alone(base: Fit) -> Taken:
    """What the vehicle and every run promise to take by themselves. Nothing where the fit is at its
    minimum; but where its derivatives mislead, or some of its runs are looked at alone, that is
    much, and none of it is an effect's."""
    tables = []
    for run in base.runs:
        none = Columns(np.zeros((run.bench.size, 0)), np.zeros((run.bench.size, 0)))
        tables.append(run_table(run, base, none, Known.of(run)))
    _, alone = _taken(base, (), tables)
    return alone if np.isfinite(alone.gain) else Taken(0.0, base.rss)


def tabulated(
    workshop: Workshop, base: Fit, chosen: Sequence[Variant]
) -> Iterator[tuple[Variant, list[Table]]]:
    """Each of these variants with its tables, run by run of `base`."""
    systems = workshop.systems(base.model)
    parts = [chosen[i : i + AT_ONCE] for i in range(0, len(chosen), AT_ONCE)]

    def of_run(item: tuple[RunFit, list[Prepared]]) -> list[Table]:
        return _run_tables(item[0], base, systems, item[1])

    def batches() -> Iterator[list[tuple[RunFit, list[Prepared]]]]:
        for part in parts:
            prepared = [prepare(workshop, base.model, variant) for variant in part]
            yield [(run, prepared) for run in base.runs]

    for part, tables in zip(parts, workshop.in_turn(of_run, batches()), strict=True):
        for i, variant in enumerate(part):
            yield variant, [table[i] for table in tables]


def _best_of(variants: Sequence[Screened]) -> Screened:
    """The best variant of an effect with the best start of each other form that comes near, and a
    few more starts: to first order the wrong end of a grid may explain twice as much."""
    best, *others = sorted(variants, key=lambda s: -s.score)
    others = [s for s in others if s.score > 0]
    near = [s for s in others if s.gain > NEAR * best.gain]
    form, of_form = best.variant.choice, {s.variant.choice: s for s in reversed(near)}
    forms = [s for s in near if s is of_form[s.variant.choice] and s.variant.choice != form]
    starts = [s for s in near if s not in forms][: max(FEW - len(forms), 0)]
    same = [s for s in others if s.variant.choice == form and s not in starts][:FEW]
    # Only the best is held against other effects: the others' contributions are not kept.
    others = [replace(s, contribution={}) for s in (*forms, *starts, *same)]
    return replace(best, others=tuple(others))


def _screened_heights(workshop: Workshop, base: Fit, effect: RandomHeights) -> Screened | None:
    """An effect that adds unknown heights: its parameters are shapes, the price follows from
    the evidence."""
    heights = screen_heights(workshop, base, effect)
    if heights is None:
        return None
    parameters = workshop.parameters_of(effect)
    return Screened(
        Variant(effect, "", heights.theta, tuple(parameters)),
        {},
        heights.gain,
        max(heights.freedom, 1.0),
        price=heights.gain - heights.worth,
        error=float(np.sqrt(heights.rss / sum(run.bench.energy for run in base.runs))),
        contribution={},
        information=np.zeros((0, 0)),
    )


def _run_tables(
    run: RunFit, base: Fit, systems: dict[Drive, System], prepared: Sequence[Prepared]
) -> list[Table]:
    """Tables of all variants for one run; products of the baseline's columns are formed once."""
    known = Known.of(run)
    columns = signatures(run, base.model, systems, prepared)
    return [run_table(run, base, c, known) for c in columns]


def solve(
    base: Fit, variant: Variant, tables: Sequence[Table], alone: Taken | None = None
) -> Screened:
    """The amplitudes that explain most of all runs, within their bounds, and what they leave; what
    is taken `alone`, without them, is not theirs."""
    alone = alone or Taken(0.0, base.rss)
    x, taken = _taken(base, variant.amplitudes, tables)
    g = len(base.shared)
    away = x[g:].tolist()
    amplitudes = {p.name: p.absent + d for p, d in zip(variant.amplitudes, away, strict=True)}
    own_price = sum(t.price for t in tables)
    numbers = sum(not isinstance(p, Switch) for p in variant.amplitudes) + len(variant.shapes)
    left = taken.rss / alone.rss if alone.rss > 0.0 else 1.0
    energy = sum(run.bench.energy for run in base.runs)
    return Screened(
        variant,
        amplitudes,
        taken.gain - alone.gain,
        numbers + sum(t.freedom for t in tables),
        # What all runs share has no firm prior: as in BIC, it is worth one datum.
        price=numbers * float(np.log(base.size)) + (own_price if np.isfinite(own_price) else 0.0),
        error=float(np.sqrt(left * base.rss / energy)),
        contribution={
            r.bench.run.id: t.signatures @ np.array(list(amplitudes.values()), np.float32)
            for r, t in zip(base.runs, tables, strict=True)
        },
        information=_information(
            np.sum([t.at_noise for t in tables], axis=0), _weight(base), base.sigma
        ),
        along={f.name: f.scale * float(d) for f, d in zip(base.shared, x[:g], strict=True)},
    )


def _taken(
    base: Fit, amplitudes: Sequence[Amplitude], tables: Sequence[Table]
) -> tuple[Array, Taken]:
    """The step of shared parameters and amplitudes that takes most, and what it takes."""
    g, weight = len(base.shared), _weight(base)
    matrix = np.sum([t.matrix for t in tables], axis=0)
    gradient = np.sum([t.gradient for t in tables], axis=0)
    matrix[:g, :g] += weight + 1e-9 * (base.sigma**2 * np.eye(g) + weight)
    if not np.isfinite(matrix).all():  # the simulation ran away: not at this strength
        return np.zeros(len(gradient)), Taken(-np.inf, base.rss)
    # A signature these runs hardly show must not call for an absurd amplitude.
    most = ABSURD * np.array([p.scale for p in amplitudes])
    matrix[g:, g:] += np.diag(1e-9 * np.diag(matrix)[g:] + (base.sigma / most) ** 2)
    x, gain = _bounded(matrix, gradient, g, amplitudes)
    left = [table.left(x) for table in tables]
    gain += sum(beyond(r, base.sigma, each) for r, each in zip(base.runs, left, strict=True))
    own_gain = sum(t.gain for t in tables)
    gain += own_gain if np.isfinite(own_gain) else 0.0  # what a run has for itself may run away
    return x, Taken(gain / base.sigma**2, float(sum(squares.sum() for squares in left)))


def _weight(base: Fit) -> Array:
    """Precision (g, g) with which the shared parameters are believed, per scale, times σ²."""
    return base.believed * base.sigma**2


def _information(matrix: Array, weight: Array, sigma: float) -> Array:
    """Precision (a, a) of the amplitudes, the shared parameters with this `weight` eliminated."""
    g = len(weight)
    shared = matrix[:g, :g] + weight + 1e-9 * (sigma**2 * np.eye(g) + weight)
    back = np.linalg.solve(shared, matrix[:g, g:])
    return np.asarray((matrix[g:, g:] - matrix[g:, :g] @ back) / sigma**2)


def _bounded(
    matrix: Array, gradient: Array, g: int, parameters: Sequence[Amplitude]
) -> tuple[Array, float]:
    """Steps of shared parameters and amplitudes, those within their bounds, and the drop of the sum
    of squares: an amplitude that would leave its bounds is held there (switches at 1), until none
    does."""
    held = {g + i: p.scale for i, p in enumerate(parameters) if isinstance(p, Switch)}
    while True:
        free = [i for i in range(len(gradient)) if i not in held]
        x = np.zeros(len(gradient))
        x[list(held)] = list(held.values())
        x[free] = np.linalg.solve(matrix[np.ix_(free, free)], (gradient - matrix @ x)[free])
        outside = {
            g + i: bounded
            for i, p in enumerate(parameters)
            if (bounded := min(max(x[g + i], p.lower - p.absent), p.upper - p.absent)) != x[g + i]
        }
        if not outside:
            break
        held |= outside
    gain = float(2 * gradient @ x - x @ matrix @ x)
    return x, gain
