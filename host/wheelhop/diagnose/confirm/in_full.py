"""Confirmation: which effects are simulated in full, and each of these fitted with the vehicle.

Speed, start and histories have many false minima, one per wave. A fit ends in the one it begins in,
so several places on the track are tried, each run by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import inf

import numpy as np

from wheelhop.diagnose.confirm.starts import (
    Start,
    begun,
    in_form,
    other_forms,
    placings,
    shapes_as_believed,
    starts,
)
from wheelhop.diagnose.confirm.validate import Incumbent, validate
from wheelhop.diagnose.score import (
    HOPELESS,
    Rung,
    all_noise,
    at_noise,
    best_first,
    material,
    noticeable,
    unforeseen,
)
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.effects import Effect, Misstatement, Switch
from wheelhop.fit import CONVERGED_QUICK, Fit, RunFit, Workshop, effect_parameters, fit
from wheelhop.simulate import Model

CONFIRMED = 5
"""At least so many effects are simulated in full on every rung."""

REACH = 0.5
"""And every one that screening expects to explain this share of what the best explains."""


SEEN = 0.25
"""Screening may see half the amplitude of an effect, and so this share of what it explains."""


def least_gain(workshop: Workshop, rung: Rung) -> float:
    """Least drop in cost by screening of an effect that could be material."""
    return SEEN * material(rung) * rung.fit.size


def worth_simulating(
    workshop: Workshop,
    rung: Rung,
    screened: Sequence[Screened],
    *,
    at_least: int = CONFIRMED,
    reach: float = REACH,
    settled: bool = False,
) -> list[Screened]:
    """The most promising effects, the best first.

    Effects that even by screening could take nothing material out of the residual are left alone:
    where it is `settled` that a model explains nearly all, they are no rivals of that one. Else
    first order may mislead, and what it cannot judge is simulated all the same. About what the
    campaign believes it hardly does, and the best of that are enough.
    """
    promising = [s for s in screened if s.score > 0 and s.gain > least_gain(workshop, rung)]
    enough = reach * promising[0].gain if promising else 0.0
    chosen = [
        s
        for i, s in enumerate(promising)
        if i < at_least or (s.gain >= enough and not isinstance(s.variant.effect, Misstatement))
    ]
    if settled:
        return chosen
    surprising = unforeseen(rung, workshop.noise)
    explained = all_noise(rung.fit, workshop.noise)
    if surprising or (not explained and noticeable(rung, workshop.noise)):
        # What has no number to fit may show in held-out runs alone: only there the wheels leave
        # the ground. Of sensors screening already says all.
        switches = [s for s in screened if s.freedom == 0 and s.variant.effect.place != "sensor"]
        chosen += [s for s in switches if s not in chosen]
    if surprising:
        # So may what is free in every run: a driver need not be unsteady in all of them.
        own = [s for s in screened if s.freedom > 0 and not s.variant.parameters]
        chosen += [s for s in own if s not in chosen]
    return chosen


def confirm(
    incumbent: Incumbent,
    screened: Screened,
    beside: Sequence[Rung] = (),
    further: Callable[[Start], None] = lambda start: None,
) -> Rung:
    """Fit the model of a rung with the screened effect added, from one start after the other:
    `further` is told of every one but the first.

    Derivatives with respect to the rung's parameters are taken from it: a quick fit that ends a
    little above the minimum; `refit` goes all the way. A switch changes everything at once: where
    it makes things worse by more than a quick fit neglects, the derivatives have changed, and only
    a full fit does it justice, if there is hope. What has none to come as far as one of the models
    `beside` it ends early.
    """
    workshop, base, effect = incumbent.workshop, incumbent.rung, screened.variant.effect
    others, raced = [rung.fit for rung in beside], list[Fit]()
    for start in starts(incumbent, screened, raced):
        if raced:
            further(start)
        bar = least_misfit(start.model, [*others, *raced])
        raced.append(fitted_from(workshop, start, bar))
    best = max(raced, key=lambda one: one.evidence)
    # A run held out took no part in the fit: it begins about the numbers found.
    shapes, held_out = best.model.theta(effect), workshop.of_role("validate")
    foreseeing = begun(workshop, base.model, best.model, effect, shapes, held_out)
    rough = validate(workshop, replace(best, model=foreseeing), base.update)
    neglected = CONVERGED_QUICK * max(base.fit.cost, base.fit.size)
    worse = best.cost > base.fit.cost + neglected
    switch = all(isinstance(p, Switch) for p in screened.variant.amplitudes)
    if switch and worse and best.error < HOPELESS * base.fit.error:
        full = refit(workshop, rough, least_misfit(rough.model, [base.fit, *others]))
        return min(rough, full, key=lambda rung: rung.fit.misfit)
    return rough


def fitted_from(workshop: Workshop, start: Start, bar: float) -> Fit:
    """A quick fit from a start, or a slow one with derivatives of its own."""
    model, base, benches = start.model, start.base.fit, workshop.of_role("fit")
    known = None if start.anew else base
    effect = model.effects[-1]
    free = effect_parameters(workshop.parameters_of(effect), model, effect)
    # Where an amplitude is not yet what it should be, shapes would run away to make up for it.
    amplitudes = [f for f in free if not f.is_shape]
    if 0 < len(amplitudes) < len(free):
        shared = [*base.shared, *amplitudes]
        model = fit(workshop, model, shared, benches, known, bar=bar).model
    return fit(workshop, model, [*base.shared, *free], benches, known, bar=bar)


def confirm_strong(incumbent: Incumbent, start: Start, beside: Sequence[Rung]) -> Rung:
    """The rung that a fit from a strong effect ends at, with its own derivatives: those of the
    vehicle without the effect do not show it. Ends early where it has no hope to reach the
    incumbent or the models `beside` it."""
    bar = least_misfit(start.model, [rung.fit for rung in (incumbent.rung, *beside)])
    found = fitted_from(incumbent.workshop, start, bar)
    return validate(incumbent.workshop, found, before=start.model)


def refit(workshop: Workshop, rung: Rung, bar: float = -inf) -> Rung:
    """Fit all parameters of a rung again, with all derivatives following the model; runs that stay
    far above the others are placed on their track anew. A fit that has no hope to come below the
    misfit `bar` ends early."""
    model, benches = placed_anew(workshop, rung), workshop.of_role("fit")
    found = fit(workshop, model, rung.fit.shared, benches, bar=bar)
    promising = bar == -inf or found.misfit < bar
    if model.effects and promising and not all_noise(found, workshop.noise):
        found = off_the_plateau(workshop, found)
    return validate(workshop, found, before=model)


def off_the_plateau(workshop: Workshop, found: Fit) -> Fit:
    """The fit, or a cheaper one begun with the shapes of its last effect at their prior means: no
    derivative leads off a plateau, such as a stop that is never reached."""
    best, benches = found, workshop.of_role("fit")
    for model in shapes_as_believed(found):
        trial = fit(workshop, model, found.shared, benches, found, bar=found.misfit)
        # Two ends of one minimum differ by what a quick fit neglects.
        if trial.misfit < best.misfit - CONVERGED_QUICK * max(best.cost, best.size):
            best = trial
    return best if best is found else fit(workshop, best.model, found.shared, benches)


def least_misfit(model: Model, rivals: Sequence[Fit]) -> float:
    """The bar that rivals set for a model: their least misfit, −∞ where none is comparable. What
    unknown heights of the ground take up says nothing of models without them."""
    rough = model.random_heights is None
    alike = [found.misfit for found in rivals if (found.model.random_heights is None) is rough]
    return min(alike, default=-inf)


def without(workshop: Workshop, rung: Rung, effect_id: str, *, quick: bool = False) -> Rung:
    """The rung's model without one effect, fitted again; `quick`: with the rung's derivatives,
    which is enough to see how much the effect explains."""
    shared = [f for f in rung.fit.shared if not f.name.startswith(f"{effect_id}.")]
    model, known = rung.model.without_effect(effect_id), rung.fit if quick else None
    return validate(workshop, fit(workshop, model, shared, workshop.of_role("fit"), known))


def best_form(incumbent: Incumbent, screened: Screened, found: Rung) -> Rung:
    """The effect that was added to a rung in the form that explains most in full simulation.

    Places that screening could not tell from the one `found` are begun where screening puts them:
    to first order a strong effect shows little difference. One with no hope to come as far as that
    in the runs fitted is fitted no further, and what held-out runs say of it means nothing. Other
    forms begin where it has ended.
    """
    workshop, effect = incumbent.workshop, found.model.effects[-1]
    tried = (screened, *screened.others)
    present = {s.variant.choice for s in tried if s.variant.effect is effect}
    present |= other_forms(workshop, effect).keys()
    for other in tried:
        if other.variant.choice not in present:
            present.add(other.variant.choice)
            rival = confirm(incumbent, replace(other, others=()), beside=[found])
            if rival.error_judging <= HOPELESS * found.error_judging:
                rival = refit(workshop, rival, least_misfit(rival.model, [found.fit]))
            found = _better(workshop, found, rival)
    return in_other_forms(workshop, found, found.model.effects[-1])


def in_other_forms(workshop: Workshop, found: Rung, effect: Effect) -> Rung:
    """A rung with one of its effects in the form that explains most; as it is where that leaves no
    more than noise."""
    others = [f for f in found.fit.shared if not f.name.startswith(f"{effect.id}.")]
    for form in other_forms(workshop, effect).values():
        if not at_noise(found, workshop.noise):
            model = in_form(workshop, found.fit, form)
            shared = [*others, *effect_parameters(workshop.parameters_of(form), model, form)]
            bar = least_misfit(model, [found.fit])
            fitted = fit(workshop, model, shared, workshop.of_role("fit"), bar=bar)
            found = _better(workshop, found, validate(workshop, fitted, before=model))
    return found


def _better(workshop: Workshop, found: Rung, rival: Rung) -> Rung:
    if rival.fit.misfit >= found.fit.misfit:
        return found
    return best_first([found, rival], workshop.noise)[0]


OUT_OF_STEP = 0.1
"""A run whose residual holds this share of its energy may be out of step with its track: a sine
that is a twentieth of its wave late leaves (2 sin(π/20))² = 0.1 of its own."""


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


def _best_place(workshop: Workshop, model: Model, run: RunFit) -> tuple[str, Mapping[str, float]]:
    """What a run leaves free, fitted by itself from wherever it may begin; the best end counts."""
    bench, run_id = run.bench, run.bench.run.id
    ends = [(run.rss, model.runs[run_id])]
    for start in placings(workshop, model, bench):
        found = fit(workshop, start, (), [bench])
        ends.append((found.rss, found.model.runs[run_id]))
    return run_id, min(ends, key=lambda end: end[0])[1]
