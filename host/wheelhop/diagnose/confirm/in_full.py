"""Confirmation: which effects are simulated in full, and each of these fitted with the vehicle.

Speed, start and histories have many false minima, one per wave. A fit ends in the one it begins in,
so several places on the track are tried, each run by itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import inf, isclose, isfinite

import numpy as np

from wheelhop.diagnose.confirm.validate import Incumbent, believable, misfits, validate
from wheelhop.diagnose.score import HOPELESS, Rung, all_noise, material, noticeable, unforeseen
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.diagnose.screen.signatures import with_variant
from wheelhop.effects import Effect
from wheelhop.fit import (
    CONVERGED_QUICK,
    Bench,
    Fit,
    FitProbe,
    RunFit,
    Workshop,
    effect_parameters,
    fit,
    seek_again,
)
from wheelhop.simulate import Model

CONFIRMED = 5
"""At least so many effects are simulated in full on every rung."""

REACH = 0.5
"""And every one that screening expects to explain this share of what the best explains."""


SEEN = 0.25
"""Screening may see half the amplitude of an effect, and so this share of what it explains."""


def least_gain(workshop: Workshop, rung: Rung) -> float:
    """What screening must expect at least of an effect that could be material."""
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
        if i < at_least or (s.gain >= enough and not s.variant.effect.is_belief)
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


def confirm(incumbent: Incumbent, screened: Screened, beside: Sequence[Rung] = ()) -> Rung:
    """Fit the model of a rung with the screened effect added.

    Derivatives with respect to the rung's parameters are taken from it: a quick fit that ends a
    little above the minimum; `refit` goes all the way. Where the vehicle of the rung is hard to
    believe, that may be for want of the effect, and no way may lead back: then another fit begins
    where the vehicle is believed to be, and what ends likelier counts. A switch changes everything
    at once: where it makes things worse by more than a quick fit neglects, the derivatives have
    changed, and only a full fit does it justice, if there is hope. What has none to come as far as
    one of the models `beside` it ends early.
    """
    workshop, base = incumbent.workshop, incumbent.rung
    bar = -inf if screened.variant.effect.has_random_heights else least_cost(beside)
    best = _begun_at(workshop, base, screened, bar)
    if not all_noise(best, workshop.noise) and incumbent.as_believed is not None:
        (_, start), *_ = _starts(workshop, incumbent.as_believed, screened)
        other, _ = fitted_from(workshop, incumbent.as_believed, start, bar)
        best = max(best, other, key=lambda one: one.evidence)
    # A run held out took no part in the fit: it begins about the numbers found.
    effect = screened.variant.effect
    shapes, held_out = best.model.theta(effect), workshop.of_role("validate")
    foreseeing = begun(workshop, base.model, best.model, effect, shapes, held_out)
    rough = validate(workshop, replace(best, model=foreseeing), base.update)
    neglected = CONVERGED_QUICK * max(base.fit.cost, base.fit.size)
    worse = best.cost > base.fit.cost + neglected
    switch = all(p.switch for p in screened.variant.amplitudes)
    if switch and worse and best.error < HOPELESS * base.fit.error:
        full = refit(workshop, rough, least_cost([base, *beside]))
        return min(rough, full, key=lambda rung: rung.fit.cost)
    return rough


def _begun_at(workshop: Workshop, base: Rung, screened: Screened, bar: float) -> Fit:
    """The best quick fit that begins at a rung.

    One that ends far above what screening expects, or at numbers hard to believe, has gone astray
    and begins again elsewhere, and so does one that leaves more than noise while another form is as
    likely: to first order a strong effect shows little difference between its forms.
    """
    best: Fit | None = None
    believed = False
    starts = _starts(workshop, base, screened)[: len(SHARES)]
    forms = [choice for choice, _ in starts]
    for i, (_, model) in enumerate(starts):
        found, believable = fitted_from(workshop, base, model, bar)
        if best is None or found.evidence > best.evidence:
            best, believed = found, believable
        fine = best.error < ASTRAY * screened.error and believed
        tried = all_noise(best, workshop.noise) or set(forms[i + 1 :]) <= set(forms[: i + 1])
        if fine and tried:
            break
    assert best is not None
    if not believed and any(p.is_shape for p in screened.variant.parameters):
        saturated = _saturated(workshop, base, screened)
        if saturated is not None:
            found, _ = fitted_from(workshop, base, saturated, bar)
            best = max(best, found, key=lambda one: one.evidence)
    return best


def fitted_from(
    workshop: Workshop, base: Rung, start: Model, bar: float, *, anew: bool = False
) -> tuple[Fit, bool]:
    """A quick fit that begins at a model, and whether the numbers of its last effect lie where they
    are believed to. `anew`: with derivatives of its own, which is slow."""
    known = None if anew else base.fit
    effect, benches = start.effects[-1], workshop.of_role("fit")
    free = effect_parameters(workshop.parameters_of(effect), start, effect)
    # Where an amplitude is not yet what it should be, shapes would run away to make up for it.
    amplitudes = [f for f in free if not f.is_shape]
    if 0 < len(amplitudes) < len(free):
        shared = [*base.fit.shared, *amplitudes]
        start = fit(workshop, start, shared, benches, known, bar=bar).model
    found = fit(workshop, start, [*base.fit.shared, *free], benches, known, bar=bar)
    return found, believable(found, free)


def refit(workshop: Workshop, rung: Rung, bar: float = -inf) -> Rung:
    """Fit all parameters of a rung again, with all derivatives following the model; runs that stay
    far above the others are placed on their track anew. A fit that has no hope to come below the
    cost `bar` ends early; the cost of unknown heights of the ground is held against none."""
    model, benches = placed_anew(workshop, rung), workshop.of_role("fit")
    bar = bar if model.random_heights is None else -inf
    found = fit(workshop, model, rung.fit.shared, benches, bar=bar)
    promising = bar == -inf or found.cost < bar
    if model.effects and promising and not all_noise(found, workshop.noise):
        found = off_the_plateau(workshop, found)
    return validate(workshop, found, before=model)


def off_the_plateau(workshop: Workshop, found: Fit) -> Fit:
    """A fit with the shapes of its last effect where they are believed to be, if that costs less.

    No derivative leads to a stop that the model never reaches, and a fit may stay wherever it came
    upon such a plateau. So each shape is put back to what is believed of it, the other numbers
    along with it as the data hold them together, and the fit goes on.
    """
    last, best, benches = found.model.effects[-1].id, found, workshop.of_role("fit")
    values, covariance = found.model.values, found.covariance
    for i, shape in enumerate(found.shared):
        if not shape.name.startswith(f"{last}.") or not (shape.is_shape and isfinite(shape.sigma)):
            continue
        along = covariance[i] / covariance[i, i] * (shape.mean - values[shape.name])
        start = {
            f.name: min(max(values[f.name] + float(d), f.lower), f.upper)
            for f, d in zip(found.shared, along, strict=True)
        }
        model = found.model.with_values(start)
        trial = fit(workshop, model, found.shared, benches, found, bar=found.cost)
        best = min(best, trial, key=lambda one: one.cost)
    return best if best is found else fit(workshop, best.model, found.shared, benches)


def least_cost(rivals: Sequence[Rung]) -> float:
    """The least cost among rivals, −∞ without any. Unknown heights have another likelihood: what
    they cost says nothing of models without."""
    alike = [r.fit.cost for r in rivals if r.model.random_heights is None]
    return min(alike, default=-inf)


def without(workshop: Workshop, rung: Rung, effect_id: str, *, quick: bool = False) -> Rung:
    """The rung's model with one effect taken out, fitted again; `quick`: with the rung's own
    derivatives, which shows what it is missed for."""
    shared = [f for f in rung.fit.shared if not f.name.startswith(f"{effect_id}.")]
    model, known = rung.model.without_effect(effect_id), rung.fit if quick else None
    return validate(workshop, fit(workshop, model, shared, workshop.of_role("fit"), known))


SHARES = (1.0, 0.4, 0.1)
"""A fit begins at one of these shares of the amplitudes that screening expects: to first order
strong effects are overrated."""

DOUBLINGS = 7
"""Or, where shapes have ended hard to believe, where twice the strength changes nothing any more: a
gap that is never used up moves the records as any wider one does. It is sought up to a hundred
times what screening expects."""

SMALLEST_START = 0.05
"""And with at least this fraction of an amplitude's scale: at zero some laws are flat."""

ASTRAY = 1.2
"""A fit that ends this many times above the error that screening expects has gone astray."""


def _starts(workshop: Workshop, base: Rung, screened: Screened) -> list[tuple[str, Model]]:
    """The models where the fit of an effect may begin, each with its form: the likeliest variants,
    each as it fits best at some share of what screening expects, the vehicle as it is or moved
    along; then more shares of the likeliest."""
    by_variant, fitted = [], workshop.of_role("fit")
    for item in (screened, *screened.others):
        switches = all(p.switch for p in item.variant.amplitudes)
        shares = SHARES[:1] if switches else SHARES
        models = list(starts_of(workshop, base, item, shares))
        order = np.argsort(misfits(workshop, models, fitted, base.fit.sigma), kind="stable")
        by_variant.append([(item.variant.choice, models[i]) for i in order])
    return [*(models[0] for models in by_variant), *by_variant[0][1:]]


def _saturated(workshop: Workshop, base: Rung, screened: Screened) -> Model | None:
    """The least strength, found by doubling, of which twice as much does the same, in the form that
    fits best, what is believed of its shapes included; None where none does."""
    shares = [2.0**k for k in range(DOUBLINGS + 1)]
    found: list[tuple[float, Model]] = []
    fitted = workshop.of_role("fit")
    for item in (screened, *screened.others):
        models = [next(starts_of(workshop, base, item, [share])) for share in shares]
        misfit = misfits(workshop, models, fitted, base.fit.sigma)
        # Strengths that end at one bound are the same; only others that do the same are saturated.
        same = [
            isfinite(one) and isclose(one, other) and model.values != twice.values
            for (one, model), (other, twice) in pairwise(zip(misfit, models, strict=True))
        ]
        if any(same):
            away = sum(
                ((item.variant.shapes[p.name] - p.believed) / p.scale) ** 2
                for p in item.variant.parameters
                if p.is_shape and p.believed is not None
            )
            found.append((misfit[same.index(True)] + away, models[same.index(True)]))
    return min(found, key=lambda one: one[0])[1] if found else None


def starts_of(
    workshop: Workshop, base: Rung, screened: Screened, shares: Sequence[float]
) -> Iterator[Model]:
    """The models where the fit of one form of an effect may begin, at some shares of the amplitudes
    that screening expects: with the vehicle as it is, and moved along with them."""
    variant = screened.variant
    absent = with_variant(base.model, variant, {})
    everywhere = list(workshop.benches.values())
    begins = begun(workshop, base.model, absent, variant.effect, variant.shapes, everywhere)
    for share in shares:
        amplitudes = {}
        for p in variant.amplitudes:
            away = (screened.amplitudes[p.name] - p.absent) * (1.0 if p.switch else share)
            least = SMALLEST_START * p.scale
            away = away if abs(away) > least else least
            amplitudes[p.name] = min(max(p.absent + away, p.lower), p.upper)
        model = begins.with_values({f"{variant.effect.id}.{k}": v for k, v in amplitudes.items()})
        yield model
        along = {
            f.name: min(max(model.values[f.name] + share * d, f.lower), f.upper)
            for f in base.fit.shared
            if (d := screened.along.get(f.name, 0.0))
        }
        if along:
            yield model.with_values(along)


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


def begun(
    workshop: Workshop,
    base: Model,
    model: Model,
    effect: Effect,
    shapes: Values,
    benches: Sequence[Bench],
) -> Model:
    """`model`, which is `base` with the effect in these shapes, these runs where they may best
    begin."""
    probe = FitProbe(workshop, base, benches)
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
    for start in _begins(workshop, model, bench):
        found = fit(workshop, start, (), [bench])
        ends.append(found.rss)
        places.append(found.model.runs[run_id])
    return run_id, places[int(np.argmin(ends))]


def _begins(workshop: Workshop, model: Model, bench: Bench) -> Sequence[Model]:
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
