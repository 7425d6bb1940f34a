"""Screening: how much of the residual each effect could explain, to first order.

An effect's *signature* is the change of the model's output when the effect is switched on, per
unit of its amplitude; it is taken at a clearly visible strength, through the same simulator that
confirms it. Signatures and residual are projected off everything the baseline could still absorb
(vehicle parameters with their priors, what each run leaves free); the drop in the cost that
remains is the effect's score.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.probe import FitProbe
from wheelhop.diagnose.screen_heights import screen_heights
from wheelhop.diagnose.screen_table import Columns, Known, Table, beyond, run_table
from wheelhop.effects import Effect, Parameter, RunSetting
from wheelhop.fit import Fit, Move, RunFit, Trial, Workshop, effect_run_parameters, moves
from wheelhop.simulate import Model
from wheelhop.vehicle import Drive, System

Array = NDArray[np.float64]

STRENGTH = 0.5
"""Signatures are taken at this fraction of an amplitude's scale."""

ABSURD = 1e3
"""So many times its scale no amplitude is believed to be: one standard deviation."""

RAN_AWAY = 1e9
"""A signature of such an acceleration, m/s², is that of a model that is not stable."""

AT_ONCE = 16
"""So many variants are held in memory together: each takes a table of every run."""

NEAR, FEW = 0.6, 2
"""So many more variants of an effect, that explain this share of what the best does, are kept."""

OWN_STRENGTH = 0.1
"""The same for what is free in every run: a distance gained, nonlinear on a short wave."""


@dataclass(frozen=True)
class Variant:
    """One effect in one form, its shape parameters at one start, those of single runs included."""

    effect: Effect
    choice: str
    shapes: Mapping[str, float]
    parameters: tuple[Parameter, ...]
    runs: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    @property
    def amplitudes(self) -> tuple[Parameter, ...]:
        """The parameters that vanish with the effect."""
        return tuple(p for p in self.parameters if not p.is_shape)


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
    contribution: Mapping[str, Array]
    information: Array
    along: Mapping[str, float] = field(default_factory=dict)
    others: tuple[Screened, ...] = ()

    @property
    def score(self) -> float:
        """Half of the gain less the price of its parameters: a logarithm of evidence."""
        return 0.5 * (self.gain - self.price)


def variants(workshop: Workshop, base: Fit, effect: Effect) -> list[Variant]:
    """All forms and shape starts in which an effect is screened; none: it does not apply."""
    channels = workshop.campaign.channels
    settings = [run.bench.simulator.setting for run in base.runs]
    if not any(effect.acts_in(setting) for setting in settings):
        return []
    probe = FitProbe(workshop, base.model, workshop.of_role("fit"))
    found: list[Variant] = []
    for choice in effect.choices(channels):
        form = effect.with_choice(choice) if choice else effect
        if not form.applies_to(workshop.nominal):
            continue
        parameters = tuple(workshop.parameters_of(form))
        amplitudes = any(not p.is_shape for p in parameters)
        if not amplitudes and not any(form.per_run(setting) for setting in settings):
            continue
        starts = {p.name: p.starts for p in parameters if p.is_shape}
        first = {name: values[0] for name, values in starts.items()}
        grid = [dict(zip(starts, values, strict=True)) for values in product(*starts.values())]
        for shapes in [{**first, **start} for start in form.shape_starts(probe)] or grid:
            runs = {s.run_id: _run_shapes(form, probe, s, shapes) for s in settings}
            found.append(Variant(form, choice, shapes, parameters, runs))
    return found


def _run_shapes(
    effect: Effect, probe: FitProbe, run: RunSetting, shapes: Mapping[str, float]
) -> Mapping[str, float]:
    """Where the shapes begin that an effect leaves free in a run: without them, amplitudes of the
    run would mean nothing."""
    names = {p.name for p in effect.per_run(run) if p.is_shape}
    if not names:
        return {}
    start, *_ = effect.run_starts(probe, run, shapes)
    return {k: v for k, v in start.items() if k in names}


def with_variant(model: Model, variant: Variant, amplitudes: Mapping[str, float]) -> Model:
    """The model with the effect added in this variant at the given amplitudes."""
    effect = variant.effect
    values = {f"{effect.id}.{k}": v for k, v in {**variant.shapes, **amplitudes}.items()}
    model = model.with_effect(effect, variant.parameters).with_values(values)
    for run_id, own in variant.runs.items():
        model = model.with_run(run_id, {f"{effect.id}.{k}": v for k, v in own.items()})
    return model


@dataclass(frozen=True)
class Prepared:
    """A variant with the models that show each amplitude's signature."""

    variant: Variant
    steps: tuple[float, ...]
    models: tuple[Model, ...]
    systems: tuple[dict[Drive, System], ...]
    absent: Model
    absent_systems: dict[Drive, System]


def screen(workshop: Workshop, base: Fit, effects: Sequence[Effect]) -> list[Screened]:
    """Screen all `effects` against the residual of `base`; best first.

    Effects that do not apply to this campaign are left out.
    """
    chosen = [variant for effect in effects for variant in variants(workshop, base, effect)]
    found: dict[str, list[Screened]] = {}
    for first in range(0, len(chosen), AT_ONCE):
        some = chosen[first : first + AT_ONCE]
        tables = tabulated(workshop, base, some)
        for i, variant in enumerate(some):
            result = solve(base, variant, [table[i] for table in tables])
            found.setdefault(variant.effect.id, []).append(result)
    best = {effect_id: _best_of(results) for effect_id, results in found.items()}
    for effect in effects:
        if effect.has_random_heights and (heights := _screened_heights(workshop, base, effect)):
            best[effect.id] = heights
    return sorted(best.values(), key=lambda s: -s.score)


def tabulated(workshop: Workshop, base: Fit, chosen: Sequence[Variant]) -> list[list[Table]]:
    """The tables of these variants, run by run of `base`."""
    prepared = [prepare(workshop, base.model, variant) for variant in chosen]
    systems = workshop.systems(base.model)
    return workshop.each(lambda run: _run_tables(run, base, systems, prepared), base.runs)


def _best_of(variants: Sequence[Screened]) -> Screened:
    """The best variant of an effect with the next few behind it, and the next few starts of the
    same form: to first order the wrong end of a grid may explain twice as much."""
    best, *others = sorted(variants, key=lambda s: -s.score)
    others = [s for s in others if s.score > 0]
    near = [s for s in others if s.gain > NEAR * best.gain][:FEW]
    same = [s for s in others if s.variant.choice == best.variant.choice and s not in near]
    # Only the best is held against other effects: the others' contributions are not kept.
    return replace(best, others=tuple(replace(s, contribution={}) for s in (*near, *same[:FEW])))


def _screened_heights(workshop: Workshop, base: Fit, effect: Effect) -> Screened | None:
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


def prepare(workshop: Workshop, model: Model, variant: Variant) -> Prepared:
    """The models in which each amplitude is switched on by itself, clearly visible."""
    steps, models = [], []
    for p in variant.amplitudes:
        step = p.scale if p.switch else STRENGTH * p.scale
        steps.append(step)
        models.append(with_variant(model, variant, {p.name: p.absent + step}))
    absent = with_variant(model, variant, {})
    return Prepared(
        variant,
        tuple(steps),
        tuple(models),
        tuple(workshop.systems(m) for m in models),
        absent,
        workshop.systems(absent),
    )


def _run_tables(
    run: RunFit, base: Fit, systems: dict[Drive, System], prepared: Sequence[Prepared]
) -> list[Table]:
    """Tables of all variants for one run; products of the baseline's columns are formed once."""
    known = Known.of(run)
    columns = signatures(run, base.model, systems, prepared)
    return [run_table(run, base, c, known.with_columns(run, c)) for c in columns]


def signatures(
    run: RunFit, model: Model, systems: dict[Drive, System], prepared: Sequence[Prepared]
) -> list[Columns]:
    """The signatures of all variants in one run, simulated together."""
    bench, size = run.bench, len(run.residual)
    trials, own_moves = list[Trial](), list[list[Move]]()
    for item in prepared:
        own_moves.append([])
        if _acts(run, item.variant) and not _is_restored(item.variant):
            trials += zip(item.models, item.systems, strict=True)
            free = effect_run_parameters(bench.simulator.setting, item.variant.effect)
            own = [f for f in free if not f.is_shape]
            own_moves[-1] = moves(bench, item.absent, own, lambda f: OWN_STRENGTH * f.scale)
            trials += [(move.model, item.absent_systems) for move in own_moves[-1]]
    changes = iter(bench.changes((model, systems), trials))
    found = []
    for item, moved in zip(prepared, own_moves, strict=True):
        columns = [np.zeros(size) for _ in item.models]
        if _acts(run, item.variant) and _is_restored(item.variant):
            columns = [_restored(run, item.variant)]
        elif _acts(run, item.variant):
            columns = [bench.coefficients(next(changes)) / step for step in item.steps]
        parts = dict(part for move in moved for part in move.parts(bench, next(changes)))
        own_columns = [parts[i] / OWN_STRENGTH for i in sorted(parts)]
        found.append(Columns(_stacked(columns, size), _stacked(own_columns, size)))
    return found


def _acts(run: RunFit, variant: Variant) -> bool:
    return run.bench.simulator.acts(variant.effect)


def _is_restored(variant: Variant) -> bool:
    """Whether an effect is a fault of the record that can be undone: a record set right keeps the
    model's derivatives, a model set wrong does not."""
    return variant.effect.place == "sensor" and all(p.switch for p in variant.parameters)


def _restored(run: RunFit, variant: Variant) -> Array:
    """How much larger the record is than the record set right, (size,)."""
    bench, campaign = run.bench, run.bench.simulator.campaign
    theta = {p.name: p.scale for p in variant.parameters}
    right = variant.effect.restore(
        theta, bench.run.record, campaign.channels, campaign.sample_rate_hz
    )
    return bench.coefficients(bench.run.record - right)


def _stacked(columns: Sequence[Array], size: int) -> Array:
    """Columns (size, k); not a number where a simulation ran away."""
    together = np.stack(columns, axis=1) if columns else np.zeros((size, 0))
    return np.where(np.abs(together).max(axis=0, initial=0.0) < RAN_AWAY, together, np.nan)


def solve(base: Fit, variant: Variant, tables: Sequence[Table]) -> Screened:
    """The amplitudes that explain most of all runs, within their bounds, and what they leave."""
    g = len(base.shared)
    weight = np.array([(f.scale / f.sigma) ** 2 for f in base.shared]) * base.sigma**2
    matrix = np.sum([t.matrix for t in tables], axis=0)
    gradient = np.sum([t.gradient for t in tables], axis=0)
    matrix[:g, :g] += np.diag(weight + 1e-9 * (base.sigma**2 + weight))
    own_gain, own_price = sum(t.gain for t in tables), sum(t.price for t in tables)
    if not (np.isfinite(own_gain) and np.isfinite(own_price)):  # what a run has for itself ran away
        own_gain, own_price = 0.0, 0.0
    amplitudes = {p.name: p.absent for p in variant.amplitudes}
    gain, along, rss = -np.inf, dict[str, float](), base.rss
    if np.isfinite(matrix).all():  # else the simulation ran away: not at this strength
        # A signature these runs hardly show must not call for an absurd amplitude.
        most = ABSURD * np.array([p.scale for p in variant.amplitudes])
        matrix[g:, g:] += np.diag(1e-9 * np.diag(matrix)[g:] + (base.sigma / most) ** 2)
        x, gain = _bounded(matrix, gradient, g, variant.amplitudes)
        amplitudes = {
            p.name: p.absent + float(d) for p, d in zip(variant.amplitudes, x[g:], strict=True)
        }
        along = {f.name: f.scale * float(d) for f, d in zip(base.shared, x[:g], strict=True)}
        left = [table.left(x) for table in tables]
        rss = float(sum(squares.sum() for squares in left))
        gain += sum(
            beyond(r, base.sigma, squares) for r, squares in zip(base.runs, left, strict=True)
        )
    gain = (gain + own_gain) / base.sigma**2
    energy = sum(run.bench.energy for run in base.runs)
    numbers = sum(not p.switch for p in variant.amplitudes) + len(variant.shapes)
    return Screened(
        variant,
        amplitudes,
        gain,
        numbers + sum(t.freedom for t in tables),
        # What all runs share has no firm prior: as in BIC, it is worth one datum.
        price=numbers * float(np.log(base.size)) + own_price,
        error=float(np.sqrt(rss / energy)),
        contribution={
            r.bench.run.id: t.signatures @ np.array(list(amplitudes.values()))
            for r, t in zip(base.runs, tables, strict=True)
        },
        information=_information(np.sum([t.at_noise for t in tables], axis=0), weight, base.sigma),
        along=along,
    )


def _information(matrix: Array, weight: Array, sigma: float) -> Array:
    """Precision (a, a) of the amplitudes, the shared parameters with this `weight` eliminated."""
    g = len(weight)
    shared = matrix[:g, :g] + np.diag(weight + 1e-9 * (sigma**2 + weight))
    back = np.linalg.solve(shared, matrix[:g, g:])
    return np.asarray((matrix[g:, g:] - matrix[g:, :g] @ back) / sigma**2)


def _bounded(
    matrix: Array, gradient: Array, g: int, parameters: Sequence[Parameter]
) -> tuple[Array, float]:
    """Steps of shared parameters and amplitudes, those within their bounds, and the drop of the sum
    of squares: an amplitude that would leave its bounds is held there (switches at 1), until none
    does."""
    held = {g + i: p.scale for i, p in enumerate(parameters) if p.switch}
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
