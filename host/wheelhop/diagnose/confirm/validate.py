"""Validation: what a fitted model foresees of the runs it was not fitted to.

A prediction is no better than the numbers it is made with: where the fitted runs hardly show a
strong effect (no wheel leaves the ground on them), held-out runs that do show it stay above the
noise although no physics is missing. Nor is it better than the simulation that makes it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite

import numpy as np

from wheelhop.diagnose.confirm.starts import believable, misfits, of_the_vehicle, shapes_nearby
from wheelhop.diagnose.score import Rung, best_first, log_odds, unforeseen
from wheelhop.fit import Bench, Fit, Workshop, fit, follow, linearised, update
from wheelhop.fit.bench import RUNS_AWAY
from wheelhop.simulate import Model

INEXACT = 1e-3
"""Simulations of the same car by two programs differ by about this share of what strong effects
do: 0.06 % where a wheel lifts, against the multibody program of the tests."""


def validate(
    workshop: Workshop, fitted: Fit, known: Fit | None = None, before: Model | None = None
) -> Rung:
    """What a fitted model does on the "validate" runs; `known` is a fit of a similar model to
    these, whose derivatives may be borrowed, and `before` the model that was fitted again: from it
    these runs follow.

    A model with effects that explains the runs it was fitted to may move its numbers as far as
    those left them uncertain. The baseline may not: it would make up for a faint effect.
    """
    benches = workshop.of_role("validate")
    if not benches:
        return Rung(fitted, None, simulated_wrong=inexact(workshop, fitted))
    start = fitted.model
    if before is not None and any(
        effect.per_run(bench.simulator.setting) for effect in before.effects for bench in benches
    ):
        start = follow(workshop, before, fitted, benches)
    foreseen = fit(workshop, start, (), benches)
    rung = Rung(fitted, foreseen, simulated_wrong=inexact(workshop, foreseen))
    if fitted.model.effects and unforeseen(rung, workshop.noise):
        moved = update(workshop, fitted, foreseen.model, benches, known)
        rung = replace(rung, update=moved, simulated_wrong=inexact(workshop, moved))
        if unforeseen(rung, workshop.noise):
            best = from_elsewhere(workshop, fitted, foreseen.model, moved)
            rung = replace(rung, update=best, simulated_wrong=inexact(workshop, best))
    return rung


def from_elsewhere(workshop: Workshop, fitted: Fit, foreseen: Model, moved: Fit) -> Fit:
    """The update begun where the runs fitted may leave a shape of an effect, at that of these
    places which the runs held out like best, or `moved` if that costs less."""
    benches, starts = workshop.of_role("validate"), list(shapes_nearby(fitted, foreseen))
    if not starts:
        return moved
    best = starts[int(np.argmin(misfits(workshop, starts, benches, moved.sigma)))]
    return min(moved, update(workshop, fitted, best, benches), key=lambda one: one.misfit)


@dataclass(frozen=True, eq=False)
class Incumbent:
    """A rung that others begin at and are held against on equal terms: if a rival's numbers may
    move on the runs held out, so may its own."""

    workshop: Workshop
    rung: Rung

    def against(self, rival: Rung) -> Rung:
        """The rung as it is judged beside `rival`."""
        return self.rung if rival.update is None else self._moved

    def gives_way_to(self, rival: Rung) -> bool:
        """Whether a rival is the better model, and runs held out do not object."""
        noise, mine = self.workshop.noise, self.against(rival)
        return best_first([mine, rival], noise)[0] is rival and log_odds(mine, rival, noise) > 0.0

    @cached_property
    def as_believed(self) -> Rung | None:
        """The rung's model with the vehicle at its prior means and derivatives made there; None
        unless the fitted numbers are far from these. Wheels that are too small, for one, stand for
        contact patches that are too long, and from there no way may lead to these."""
        fitted = self.rung.fit
        vehicle = of_the_vehicle(fitted)
        if believable(fitted, vehicle):
            return None
        model = fitted.model.with_values({f.name: f.mean for f in vehicle})
        benches = [run.bench for run in fitted.runs]
        found = linearised(self.workshop, model, fitted.shared, benches)
        return replace(self.rung, fit=found) if isfinite(found.cost) else None

    @cached_property
    def _moved(self) -> Rung:
        if self.rung.validation is None or self.rung.update is not None:
            return self.rung
        benches = self.workshop.of_role("validate")
        start = self.rung.validation.model
        return replace(self.rung, update=update(self.workshop, self.rung.fit, start, benches))


@dataclass(frozen=True, eq=False)
class SimulatedWrong:
    """Finds the power by which a simulation may be wrong, in units of the noise's."""

    workshop: Workshop
    judging: Fit

    def __call__(self) -> float:
        """That power."""
        noise, judging = self.workshop.noise, self.judging
        if noise == 0.0:
            return 0.0
        power = _of_effects(self.workshop, judging) + _of_axles(self.workshop, judging)
        return power / (judging.size * noise**2)


def inexact(workshop: Workshop, judging: Fit) -> SimulatedWrong:
    """Of a fit, without derivatives: as long as the model is remembered."""
    return SimulatedWrong(workshop, judging.without_derivatives)


def _of_axles(workshop: Workshop, judging: Fit) -> float:
    """Power that axle motion as wrong as it may be adds to what a linear vehicle makes of it,
    which every datum is weighed by: where friction turns, an axle a millisecond late is a jump a
    millisecond late."""
    model = judging.model
    systems, astray = workshop.systems(model), workshop.astray

    @RUNS_AWAY
    def added(bench: Bench) -> float:
        wrong = astray.get(bench.run.id)
        if wrong is None:
            return 0.0
        change = wrong.modelled(model, systems) - bench.modelled(model, systems)
        foreseen = bench.foreseen * workshop.noise**2
        return max(float(change @ change - foreseen), 0.0)

    return sum(workshop.each(added, [run.bench for run in judging.runs]))


def _of_effects(workshop: Workshop, judging: Fit) -> float:
    """Power by which the simulation of a model's effects may be wrong. What a sensor does to the
    record needs no simulation."""
    model = judging.model
    bare = model
    for effect in model.effects:
        if effect.place != "sensor":
            bare = bare.without_effect(effect.id)
    if bare is model:
        return 0.0
    systems = workshop.systems(model), workshop.systems(bare)

    @RUNS_AWAY
    def contributed(bench: Bench) -> float:
        full, rest = bench.records(list(zip((model, bare), systems, strict=True)))
        difference = bench.coefficients(full - rest)
        return float(difference @ difference)

    return INEXACT**2 * sum(workshop.each(contributed, [run.bench for run in judging.runs]))
