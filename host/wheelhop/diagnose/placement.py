"""Placing runs on their track: what a run leaves free begins where the model agrees best with it.

Speed, start and histories have many false minima, one per wave. A fit ends in the one it begins in,
so several are tried, each run by itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from wheelhop.diagnose.probe import FitProbe
from wheelhop.diagnose.rung import Rung
from wheelhop.effects import Effect
from wheelhop.fit import Bench, RunFit, Workshop, fit, seek_again
from wheelhop.simulate import Model

Values = Mapping[str, float]

OUT_OF_STEP = 0.1
"""A run whose residual holds this share of its energy may be out of step with its track: a sine
that is a twentieth of its wave late leaves (2 sin(π/20))² = 0.1 of its own."""


def with_starts(model: Model, effect: Effect, run_id: str, start: Values) -> Model:
    """The model with what an effect begins with in one run; speed and start are the run's own."""
    whole = ("speed_m_s", "start_m")
    return model.with_run(
        run_id, {k if k in whole else f"{effect.id}.{k}": v for k, v in start.items()}
    )


def begun(workshop: Workshop, base: Model, model: Model, effect: Effect, shapes: Values) -> Model:
    """`model`, which is `base` with the effect in these shapes, every run where it may best
    begin."""
    probe = FitProbe(workshop, base, list(workshop.benches.values()))
    systems = workshop.systems(model)

    def best(bench: Bench) -> Values:
        starts = effect.run_starts(probe, bench.simulator.setting, shapes)
        if len(starts) == 1:
            return starts[0]
        trials = [with_starts(model, effect, bench.run.id, start) for start in starts]
        measured = bench.measured[:, bench.predicted].ravel()
        records = bench.records([(trial, systems) for trial in trials])
        residuals = [measured - bench.coefficients(record) for record in records]
        return starts[int(np.argmin([float(r @ r) for r in residuals]))]

    benches = list(workshop.benches.values())
    for bench, start in zip(benches, workshop.each(best, benches), strict=True):
        model = with_starts(model, effect, bench.run.id, start)
    return model


def placed_anew(workshop: Workshop, rung: Rung) -> Model:
    """The rung's model, runs that are out of step with their track placed on it again: a slow drive
    over long waves can be placed only once its friction is known."""
    model = placed = rung.model
    fits = [*rung.fit.runs, *(rung.validation.runs if rung.validation is not None else ())]
    # Where the model runs away, no place is better than another.
    lost = [run for run in fits if OUT_OF_STEP * run.bench.energy < run.rss < np.inf]
    for run_id, own in workshop.each(lambda run: _best_place(workshop, model, run), lost):
        placed = placed.with_run(run_id, own)
    return placed


def _best_place(workshop: Workshop, model: Model, run: RunFit) -> tuple[str, Values]:
    """What a run leaves free, fitted by itself from wherever it may begin; the best end counts."""
    bench, run_id = run.bench, run.bench.run.id
    ends = [run.rss]
    places = [model.runs[run_id]]
    for start in _starts(workshop, model, bench):
        found = fit(workshop, start, (), [bench])
        ends.append(found.rss)
        places.append(found.model.runs[run_id])
    return run_id, places[int(np.argmin(ends))]


def _starts(workshop: Workshop, model: Model, bench: Bench) -> Sequence[Model]:
    run_id = bench.run.id
    sought = seek_again(workshop.campaign, bench, model, workshop.systems(model))
    again = model.with_run(run_id, sought)
    found = [again] if sought else []
    for effect in model.effects:
        if effect.per_run(bench.simulator.setting):
            probe = FitProbe(workshop, again.without_effect(effect.id), [bench])
            shapes = model.theta(effect)
            starts = effect.run_starts(probe, bench.simulator.setting, shapes)
            found += [with_starts(again, effect, run_id, start) for start in starts if start]
    return found
