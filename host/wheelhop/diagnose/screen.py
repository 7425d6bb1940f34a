"""Screening: how much of the residual each effect could explain, to first order.

An effect's *signature* is the change of the model's output when the effect is switched on, per
unit of its amplitude; it is taken at a clearly visible strength, through the same simulator that
confirms it. Signatures and residual are projected off everything the baseline could still absorb
(vehicle parameters with their priors, what each run leaves free); the drop in the cost that
remains is the effect's score.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.probe import FitProbe
from wheelhop.diagnose.screen_heights import screen_heights
from wheelhop.effects import Effect, Parameter
from wheelhop.fit import Fit, RunFit, Workshop
from wheelhop.simulate import Model
from wheelhop.vehicle import Drive, System

Array = NDArray[np.float64]

STRENGTH = 0.5
"""Signatures are taken at this fraction of an amplitude's scale."""

ABSURD = 1e3
"""So many times its scale no amplitude is believed to be: one standard deviation."""

OWN_STRENGTH = 0.1
"""The same for what is free in every run: a distance gained, nonlinear on a short wave."""


@dataclass(frozen=True)
class Variant:
    """One effect in one form, its shape parameters at one start."""

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
    the cost, the number of parameters that bought it and the price of one, and the error E that
    would be left. ``signatures`` (size, a) per run are free of what the run itself could absorb."""

    variant: Variant
    amplitudes: Mapping[str, float]
    gain: float
    freedom: float
    price: float
    error: float
    signatures: Mapping[str, Array]

    @property
    def score(self) -> float:
        """Half of the gain less the price of its parameters: half the BIC difference."""
        return 0.5 * (self.gain - self.freedom * self.price)


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
        parameters = tuple(form.parameters_for(base.model.values, channels))
        amplitudes = any(not p.is_shape for p in parameters)
        if not amplitudes and not any(form.per_run(setting) for setting in settings):
            continue
        starts = {p.name: p.starts for p in parameters if p.is_shape}
        first = {name: values[0] for name, values in starts.items()}
        grid = [dict(zip(starts, values, strict=True)) for values in product(*starts.values())]
        for shapes in [{**first, **start} for start in form.shape_starts(probe)] or grid:
            found.append(Variant(form, choice, shapes, parameters))
    return found


def with_variant(model: Model, variant: Variant, amplitudes: Mapping[str, float]) -> Model:
    """The model with the effect added in this variant at the given amplitudes."""
    effect = variant.effect
    values = {f"{effect.id}.{k}": v for k, v in {**variant.shapes, **amplitudes}.items()}
    model = model.with_effect(effect, variant.parameters).with_values(values)
    for run_id, own in variant.runs.items():
        model = model.with_run(run_id, {f"{effect.id}.{k}": v for k, v in own.items()})
    return model


@dataclass(frozen=True)
class _Prepared:
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
    prepared = [
        _prepare(workshop, base.model, variant)
        for effect in effects
        for variant in variants(workshop, base, effect)
    ]
    tables = workshop.each(lambda run: _run_tables(run, base, prepared), base.runs)
    best: dict[str, Screened] = {}
    for i, item in enumerate(prepared):
        result = _solve(base, item.variant, [table[i] for table in tables])
        known = best.get(item.variant.effect.id)
        if known is None or result.score > known.score:
            best[item.variant.effect.id] = result
    for effect in effects:
        if effect.has_random_heights and (found := _screened_heights(workshop, base, effect)):
            best[effect.id] = found
    return sorted(best.values(), key=lambda s: -s.score)


def _screened_heights(workshop: Workshop, base: Fit, effect: Effect) -> Screened | None:
    """An effect that adds unknown heights: its parameters are shapes, the price follows from
    the evidence."""
    heights = screen_heights(workshop, base, effect)
    if heights is None:
        return None
    parameters = effect.parameters_for(base.model.values, workshop.campaign.channels)
    freedom = max(heights.freedom, 1.0)
    rss = max(base.rss - heights.gain * base.sigma**2, 0.0)
    return Screened(
        Variant(effect, "", heights.theta, tuple(parameters)),
        {},
        heights.gain,
        freedom,
        price=(heights.gain - heights.worth) / freedom,
        error=float(np.sqrt(rss / sum(run.bench.energy for run in base.runs))),
        signatures={run.bench.run.id: np.zeros((len(run.residual), 0)) for run in base.runs},
    )


def _prepare(workshop: Workshop, model: Model, variant: Variant) -> _Prepared:
    steps, models = [], []
    for p in variant.amplitudes:
        step = p.scale if p.switch else STRENGTH * p.scale
        steps.append(step)
        models.append(with_variant(model, variant, {p.name: p.absent + step}))
    absent = with_variant(model, variant, {})
    return _Prepared(
        variant,
        tuple(steps),
        tuple(models),
        tuple(workshop.systems(m) for m in models),
        absent,
        workshop.systems(absent),
    )


@dataclass(frozen=True, eq=False)
class _Table:
    """One run's normal equations with the run's own parameters eliminated: shared parameters
    first, then the variant's amplitudes."""

    matrix: Array  # (g + a, g + a)
    gradient: Array  # (g + a,)
    gain: float  # what the run's own parameters gain by themselves
    freedom: int  # how many of them the effect brought
    signatures: Array  # (size, a)


def _run_tables(run: RunFit, base: Fit, prepared: Sequence[_Prepared]) -> list[_Table]:
    """Tables of all variants for one run; products of the baseline's columns are formed once."""
    known = np.hstack([run.own_jacobian, run.shared_jacobian, run.residual[:, None]])
    # The residual is free of heights already.
    free = np.hstack([run.freed(known[:, :-1]), run.residual[:, None]])
    products = known.T @ free
    products[-1] = products[:, -1]
    return [_run_table(run, base, item, free, products) for item in prepared]


def _run_table(run: RunFit, base: Fit, item: _Prepared, free: Array, products: Array) -> _Table:
    columns, own_columns, own = _columns(run, item)
    added = np.hstack([own_columns, columns])
    across, among = free.T @ added, added.T @ run.freed(added)
    r, q, g, a = len(run.own), len(own), len(base.shared), columns.shape[1]
    # Order of the whole: own, effect's own | shared, amplitudes | residual.
    order = [*range(r), *range(r + g + 1, r + g + 1 + q), *range(r, r + g)]
    order += [*range(r + g + 1 + q, r + g + 1 + q + a), r + g]
    whole = np.block([[products, across], [across.T, among]])[np.ix_(order, order)]
    n = r + q
    prior = np.array([(f.scale / f.sigma) ** 2 for f in run.own] + [1.0] * q) * base.sigma**2
    inner = whole[:n, :n] + np.diag(prior + 1e-9 * (base.sigma**2 + prior))
    back = np.linalg.solve(inner, whole[:n, n:])
    rest = whole[n:, n:] - whole[n:, :n] @ back
    nuisance = np.hstack([run.own_jacobian, own_columns])
    return _Table(
        rest[:-1, :-1],
        rest[:-1, -1],
        float(whole[-1, :n] @ back[:, -1]),
        q,
        columns - nuisance @ back[:, g:-1],
    )


def _columns(run: RunFit, item: _Prepared) -> tuple[Array, Array, Sequence[Parameter]]:
    """Signatures of the amplitudes (size, a), and of the effect's own parameters of this run
    (size, q) per prior standard deviation, with those parameters."""
    bench, effect = run.bench, item.variant.effect
    size, run_id = len(run.residual), bench.run.id
    if not bench.simulator.acts(effect):
        return np.zeros((size, len(item.models))), np.zeros((size, 0)), ()
    measured = bench.measured[:, bench.predicted].ravel()
    base = measured - run.residual
    if effect.place == "sensor" and all(p.switch for p in item.variant.parameters):
        # A record set right keeps the model's derivatives, a model set wrong does not.
        theta = {p.name: p.scale for p in item.variant.parameters}
        campaign = bench.simulator.campaign
        right = bench.band.coefficients(
            effect.restore(theta, bench.run.record, campaign.channels, campaign.sample_rate_hz)
        )
        return (measured - right[:, bench.predicted].ravel())[:, None], np.zeros((size, 0)), ()
    columns = [
        (bench.modelled(model, systems) - base) / step
        for step, model, systems in zip(item.steps, item.models, item.systems, strict=True)
    ]
    own = effect.per_run(bench.simulator.setting)
    own_columns = []
    for p in own:
        values = {f"{effect.id}.{q.name}": q.absent for q in own}
        values[f"{effect.id}.{p.name}"] += OWN_STRENGTH * p.scale
        moved = item.absent.with_run(run_id, values)
        own_columns.append((bench.modelled(moved, item.absent_systems) - base) / OWN_STRENGTH)
    return _stacked(columns, size), _stacked(own_columns, size), own


def _stacked(columns: Sequence[Array], size: int) -> Array:
    return np.stack(columns, axis=1) if columns else np.zeros((size, 0))


def _solve(base: Fit, variant: Variant, tables: Sequence[_Table]) -> Screened:
    g = len(base.shared)
    weight = np.array([(f.scale / f.sigma) ** 2 for f in base.shared]) * base.sigma**2
    matrix = np.sum([t.matrix for t in tables], axis=0)
    gradient = np.sum([t.gradient for t in tables], axis=0)
    matrix[:g, :g] += np.diag(weight + 1e-9 * (base.sigma**2 + weight))
    own_gain = sum(t.gain for t in tables)
    amplitudes = {p.name: p.absent for p in variant.amplitudes}
    gain = -np.inf
    if np.isfinite(matrix).all():  # else the simulation ran away: not at this strength
        # A signature these runs hardly show must not call for an absurd amplitude.
        most = ABSURD * np.array([p.scale for p in variant.amplitudes])
        matrix[g:, g:] += np.diag(1e-9 * np.diag(matrix)[g:] + (base.sigma / most) ** 2)
        amplitudes, gain = _bounded(matrix, gradient, g, variant.amplitudes)
    gain = (gain + own_gain) / base.sigma**2
    rss = max(base.rss - gain * base.sigma**2, 0.0)
    energy = sum(run.bench.energy for run in base.runs)
    return Screened(
        variant,
        amplitudes,
        gain,
        freedom=sum(not p.switch for p in variant.amplitudes)
        + len(variant.shapes)
        + sum(t.freedom for t in tables),
        price=float(np.log(base.size)),
        error=float(np.sqrt(rss / energy)),
        signatures={r.bench.run.id: t.signatures for r, t in zip(base.runs, tables, strict=True)},
    )


def _bounded(
    matrix: Array, gradient: Array, g: int, parameters: Sequence[Parameter]
) -> tuple[dict[str, float], float]:
    """Amplitudes within their bounds and the drop of the sum of squares: an amplitude that would
    leave its bounds is held there (switches at 1), until none does."""
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
    return {p.name: p.absent + float(x[g + i]) for i, p in enumerate(parameters)}, gain
