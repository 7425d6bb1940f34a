"""Which effects can pass for which on the runs of a campaign: angles between their signatures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from effect_pictures import EFFECT, INK, SOFT, STYLE
from effect_stage import Array, Stage, strengths, switched_on
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from scipy.linalg import block_diag

from wheelhop.campaign import Channel, read_campaign
from wheelhop.diagnose import Baseline, fit_baseline
from wheelhop.effects import Amplitude, Effect, RandomHeights
from wheelhop.fit import RunFit, effect_run_parameters, moves
from wheelhop.simulate import Model

OWN_SHARE = 0.1  # of the scale of what is free in each run: a distance is nonlinear on short waves
HEAT = LinearSegmentedColormap.from_list("near to far", ["#06263f", EFFECT, "#cfe1ef", "#ffffff"])


def angles_picture(effects: Mapping[str, Effect], stage: Stage, folder: Path) -> Figure:
    """How far each effect is from anything each other can do, on the campaign's fitted runs; of the
    forms of either the two that come nearest to each other."""
    campaign = read_campaign(folder)
    base = fit_baseline(campaign, stage.vehicle, progress=lambda text: print(text, flush=True))
    # Heights that may be anything have no signature.
    known = [e for e in effects.values() if e.on_vehicle and not isinstance(e, RandomHeights)]
    values = stage.vehicle.values
    forms = [form for effect in known for form in _forms(effect, campaign.channels, values)]
    absorbed = _baseline_columns(base)
    signatures = np.column_stack([_signature(base, form, stage) for form in forms])
    alone = _left_over(signatures, absorbed, np.zeros((len(signatures), 0)), base)
    table = np.empty((len(forms), len(forms)))
    for j, form in enumerate(forms):
        print(f"angles to {form.id}, form {j + 1} of {len(forms)}", flush=True)
        left = _left_over(signatures, absorbed, _columns(base, form, stage), base)
        table[:, j] = left / np.maximum(alone, 1e-12)
    first = [i for i, form in enumerate(forms) if i == 0 or form.id != forms[i - 1].id]
    nearest = np.minimum.reduceat(np.minimum.reduceat(table, first, axis=0), first, axis=1)
    names = [effect.id for effect in known]
    return _draw(names, np.degrees(np.arcsin(np.clip(nearest, 0.0, 1.0))))


def _forms(
    effect: Effect, channels: Sequence[Channel], values: Mapping[str, float]
) -> list[Effect]:
    """The laws of an effect that the vehicle may have; a sensor's fault in one channel stands for
    all."""
    choices = effect.choices(channels)
    if effect.place == "sensor":
        choices = choices[:1]
    every = [effect.with_choice(c) if c else effect for c in choices]
    return [form for form in every if form.applies_to(values)]


def _baseline_columns(base: Baseline) -> Array:
    """What the vehicle's numbers and every run's own can absorb, (data, parameters)."""
    runs = base.rung.fit.runs
    split = [np.hsplit(run.jacobian, [run.derivatives.shared]) for run in runs]
    return np.hstack([np.vstack([s for s, _ in split]), block_diag(*(own for _, own in split))])


def _prior(base: Baseline, count: int) -> Array:
    """Precision of all columns, those of an effect last and free."""
    shared = [(f.scale / f.sigma) ** 2 for f in base.rung.fit.shared]
    own = [(f.scale / f.sigma) ** 2 for run in base.rung.fit.runs for f in run.own]
    return base.rung.fit.sigma**2 * np.array([*shared, *own, *[0.0] * count])


def _left_over(signatures: Array, absorbed: Array, columns: Array, base: Baseline) -> Array:
    """Size of the part of each signature that neither the baseline nor these columns can take."""
    matrix = np.hstack([absorbed, columns])
    square = matrix.T @ matrix
    prior = _prior(base, columns.shape[1]) + 1e-9 * np.diag(square) + 1e-30
    taken = matrix @ np.linalg.solve(square + np.diag(prior), matrix.T @ signatures)
    return np.asarray(np.linalg.norm(signatures - taken, axis=0))


def _signature(base: Baseline, form: Effect, stage: Stage) -> Array:
    """The effect at its visible strength: change of all fitted runs' data, (data,)."""
    settings = [run.bench.simulator.setting for run in base.rung.fit.runs]
    model = switched_on(base.rung.model, form, settings, strengths(form, stage), OWN_SHARE)
    return np.concatenate(_change(base, model))


def _columns(base: Baseline, form: Effect, stage: Stage) -> Array:
    """What each of the effect's numbers does by itself, (data, numbers)."""
    runs = base.rung.fit.runs
    settings = [run.bench.simulator.setting for run in runs]
    at = strengths(form, stage)
    parameters = form.parameters_for(stage.vehicle.values, stage.campaign.channels)
    amplitudes = [p for p in parameters if isinstance(p, Amplitude)]
    absent = at | {p.name: p.absent for p in amplitudes}
    columns = []
    for p in amplitudes:
        values = absent | {p.name: at[p.name]}
        model = switched_on(base.rung.model, form, settings, values, own_share=0.0)
        columns.append(np.concatenate(_change(base, model)))
    nothing = switched_on(base.rung.model, form, settings, absent, own_share=0.0)
    size = sum(len(run.residual) for run in runs)
    shared = np.stack(columns, axis=1) if columns else np.zeros((size, 0))
    return np.hstack(
        [shared, block_diag(*(_own_columns(base, run, form, nothing) for run in runs))]
    )


def _own_columns(base: Baseline, run: RunFit, form: Effect, nothing: Model) -> Array:
    """What each number that the effect leaves free in a run does there, (size, numbers)."""
    own = effect_run_parameters(run.bench.simulator.setting, form)
    made = moves(run.bench, nothing, own, lambda f: OWN_SHARE * f.scale)
    systems = base.workshop.systems(nothing)
    record, *others = run.bench.records([(m, systems) for m in (nothing, *(m.model for m in made))])
    columns = np.zeros((len(run.residual), len(own)))
    for move, other in zip(made, others, strict=True):
        for i, part in move.parts(run.bench, other - record):
            columns[:, i] = part
    return columns


def _change(base: Baseline, model: Model) -> list[Array]:
    """Change of the model's in-band data, run by run."""
    systems = base.workshop.systems(model)
    parts = []
    for run in base.rung.fit.runs:
        measured = run.bench.measured[:, run.bench.predicted].ravel()
        parts.append(run.bench.modelled(model, systems) - (measured - run.residual))
    return parts


def _draw(names: Sequence[str], table: Array) -> Figure:
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11.0, 0.32 * len(names) + 2.2), layout="constrained")
        axes = figure.add_subplot()
        axes.imshow(table, cmap=HEAT, vmin=0, vmax=90, aspect="auto")
        for i, row in enumerate(table):
            for j, angle in enumerate(row):
                colour = "white" if angle < 45 else INK
                text = "" if i == j else f"{angle:.0f}"
                axes.text(j, i, text, ha="center", va="center", color=colour, fontsize=8)
        axes.set_xticks(range(len(names)), names, rotation=90)
        axes.set_yticks(range(len(names)), names)
        axes.xaxis.tick_top()
        axes.tick_params(length=0, colors=INK)
        axes.spines[:].set_visible(False)
        axes.set_xlabel("could it be this one?", color=SOFT)
        axes.set_ylabel("this effect is there", color=SOFT)
    return figure
