"""Signatures: what an effect changes in the records when it is switched on, per unit of amplitude.

They are taken at a clearly visible strength, through the same simulator that confirms the effect;
at several where their shape depends on it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.screen.table import Columns
from wheelhop.effects import Amplitude, Effect, Parameter, RunSetting, Shape, Switch
from wheelhop.fit import Fit, FitProbe, Move, RunFit, Trial, Workshop, effect_run_parameters, moves
from wheelhop.simulate import Model
from wheelhop.vehicle import Drive, System

Array = NDArray[np.float64]

RAN_AWAY = 1e9
"""A signature of such an acceleration, m/s², is that of a model that is not stable."""

OWN_STRENGTH = 0.1
"""The fraction of its scale for what is free in every run: a distance gained, nonlinear on a short
wave."""


@dataclass(frozen=True)
class Variant:
    """One effect in one form, its shape parameters at one start, those of single runs included, and
    its amplitudes' signatures taken at one fraction of their scales."""

    effect: Effect
    choice: str
    shapes: Mapping[str, float]
    parameters: tuple[Parameter, ...]
    runs: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    strength: float = Effect.screened_at[0]

    @property
    def amplitudes(self) -> tuple[Amplitude, ...]:
        """The parameters that vanish with the effect."""
        return tuple(p for p in self.parameters if isinstance(p, Amplitude))


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
        amplitudes = any(isinstance(p, Amplitude) for p in parameters)
        if not amplitudes and not any(form.per_run(setting) for setting in settings):
            continue
        starts = {p.name: p.starts for p in parameters if isinstance(p, Shape)}
        first = {name: values[0] for name, values in starts.items()}
        grid = [dict(zip(starts, values, strict=True)) for values in product(*starts.values())]
        for shapes in [{**first, **start} for start in probe.shape_starts(form)] or grid:
            runs = {s.run_id: _run_shapes(form, probe, s, shapes) for s in settings}
            found += [
                Variant(form, choice, shapes, parameters, runs, strength)
                for strength in form.screened_at
            ]
    return found


def _run_shapes(
    effect: Effect, probe: FitProbe, run: RunSetting, shapes: Mapping[str, float]
) -> Mapping[str, float]:
    """Where the shapes begin that an effect leaves free in a run: without them, amplitudes of the
    run would mean nothing."""
    names = {p.name for p in effect.per_run(run) if isinstance(p, Shape)}
    if not names:
        return {}
    start, *_ = probe.run_starts(effect, run, shapes)
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


def prepare(workshop: Workshop, model: Model, variant: Variant) -> Prepared:
    """The models in which each amplitude is switched on by itself, clearly visible."""
    steps, models = [], []
    for p in variant.amplitudes:
        step = p.scale if isinstance(p, Switch) else variant.strength * p.scale
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
    return variant.effect.place == "sensor" and all(
        isinstance(p, Switch) for p in variant.parameters
    )


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
