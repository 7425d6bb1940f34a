"""Where the fit of an effect may begin: every place, each with its reason, in one list.

A fit is local. First order says where to begin, but it overrates what is strong, sees little of
what differs between forms, and nothing of what the vehicle was bent to make up for. So there are
several places, tried in turn until a fit has come far enough; what it costs decides.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import copysign, inf, isclose, isfinite, sqrt
from typing import TYPE_CHECKING

import numpy as np

from wheelhop.diagnose.score import Rung, all_noise
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.diagnose.screen.signatures import with_variant
from wheelhop.effects import Effect, Shape, Switch
from wheelhop.fit import Bench, Fit, FitProbe, Free, Workshop, seek_again
from wheelhop.simulate import Model

if TYPE_CHECKING:
    from wheelhop.diagnose.confirm.validate import Incumbent

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

FAR = 3.0
"""A fit that ends so many standard deviations from what is believed of a number has gone astray."""

Values = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Start:
    """A model where a fit may begin, and why there. The shared numbers of ``base`` are fitted, and
    its derivatives are borrowed unless they are to be made `anew`."""

    model: Model
    why: str
    base: Rung
    anew: bool = False


def starts(incumbent: Incumbent, screened: Screened, ended: Sequence[Fit]) -> Iterator[Start]:
    """Where the fit of an effect beside a rung may begin, the next place only as long as none of
    those that have `ended` by then came far enough.

    Forms and shares of what is screened, until one ends about as low as screening expects, at
    numbers that are believed, with no other form as likely or nothing left but noise. Then, where
    shapes are hard to believe, saturated. Where something is left, where those have ended in
    plainer forms that were not tried: what is free to do more looks better to first order, and may
    end elsewhere. And where the vehicle is hard to believe, that may be for want of the effect, and
    no way may have led back: so as it is believed.
    """
    workshop, noise = incumbent.workshop, incumbent.workshop.noise
    listed = _screened(workshop, incumbent.rung, screened)[: len(SHARES)]
    forms, own = [form for form, _ in listed], f"{screened.id}."
    for i, (_, start) in enumerate(listed):
        yield start
        best = max(ended, key=lambda one: one.evidence)
        believed = believable(best, [f for f in best.shared if f.name.startswith(own)])
        tried = all_noise(best, noise) or set(forms[i + 1 :]) <= set(forms[: i + 1])
        if best.error < ASTRAY * screened.error and believed and tried:
            break
    if not believed and any(isinstance(p, Shape) for p in screened.variant.parameters):
        yield from saturated(workshop, incumbent.rung, screened)
        best = max(ended, key=lambda one: one.evidence)
    if not all_noise(best, noise):
        plain = {choice: model for one in ended for choice, model in plainer(workshop, one)}
        for choice, model in plain.items():
            if choice not in forms:
                yield Start(model, "in a plainer form", incumbent.rung)
        best = max(ended, key=lambda one: one.evidence)
    astray = not believable(best, of_the_vehicle(best))
    if astray and not all_noise(best, noise) and incumbent.as_believed is not None:
        (_, start), *_ = _screened(workshop, incumbent.as_believed, screened)
        yield replace(start, why="in the vehicle as believed")


def _screened(workshop: Workshop, base: Rung, screened: Screened) -> list[tuple[str, Start]]:
    """As screened, each start with its form: the likeliest variants, each as it fits best at some
    share of what screening expects, the vehicle as it is or moved along; then more shares of the
    likeliest."""
    by_variant, fitted = [], workshop.of_role("fit")
    for item in (screened, *screened.others):
        switches = all(isinstance(p, Switch) for p in item.variant.amplitudes)
        models = list(at_shares(workshop, base, item, SHARES[:1] if switches else SHARES))
        order = np.argsort(misfits(workshop, models, fitted, base.fit.sigma), kind="stable")
        choice = item.variant.choice
        by_variant.append([(choice, Start(models[i], "from elsewhere", base)) for i in order])
    return [*(each[0] for each in by_variant), *by_variant[0][1:]]


def saturated(workshop: Workshop, base: Rung, screened: Screened) -> Iterator[Start]:
    """Start at the smallest amplitude beyond which doubling changes nothing (for example a gap that
    is never crossed), in the form that fits best, its shapes' priors included. Yields nothing where
    doubling always changes something."""
    shares = [2.0**k for k in range(DOUBLINGS + 1)]
    found: list[tuple[float, Model]] = []
    fitted = workshop.of_role("fit")
    for item in (screened, *screened.others):
        models = [next(at_shares(workshop, base, item, [share])) for share in shares]
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
                if isinstance(p, Shape) and p.believed is not None
            )
            found.append((misfit[same.index(True)] + away, models[same.index(True)]))
    if found:
        yield Start(min(found, key=lambda one: one[0])[1], "saturated", base)


def strong(incumbent: Incumbent, screened: Sequence[Screened]) -> list[tuple[Screened, Start]]:
    """Effects too strong for first order, as strong as shows clearly (`Parameter.scale`), in the
    vehicle as believed: those that come nearest to the runs fitted first, and none that comes no
    nearer than this vehicle does without. None where the vehicle is not hard to believe.

    Friction that nearly always holds its struts is one: the vehicle fitted without it has springs
    as stiff as what holds them, and about that vehicle its signature is nothing. Nor does a little
    of it help where the vehicle is believed to be.
    """
    base, workshop = incumbent.as_believed, incumbent.workshop
    if base is None:
        return []
    places = [
        (item, next(at_shares(workshop, base, _as_strong(form), [1.0])))
        for item in screened
        for form in (item, *item.others)
        if any(not isinstance(p, Switch) for p in form.variant.amplitudes)
    ]
    models = [base.model, *(model for _, model in places)]
    without, *left = misfits(workshop, models, workshop.of_role("fit"), base.fit.sigma)
    best: dict[str, tuple[Screened, Start]] = {}
    for i in np.argsort(left, kind="stable"):
        item, model = places[i]
        if left[i] < without:
            best.setdefault(item.id, (item, Start(model, "strong ones", incumbent.rung, anew=True)))
    return list(best.values())


def _as_strong(screened: Screened) -> Screened:
    """The screened effect with every amplitude at its scale, with the sign that screening gives
    it."""
    amplitudes = {
        p.name: p.absent + copysign(p.scale, screened.amplitudes[p.name] - p.absent)
        for p in screened.variant.amplitudes
        if not isinstance(p, Switch)
    }
    return replace(screened, amplitudes={**screened.amplitudes, **amplitudes})


def other_forms(workshop: Workshop, effect: Effect) -> dict[str, Effect]:
    """The other forms of an effect that have some of its numbers, and some of their own. (With all
    alike it is not another form but another place.)"""
    known = {p.name for p in workshop.parameters_of(effect)}
    found = {}
    for choice in effect.choices(workshop.campaign.channels):
        form = effect.with_choice(choice)
        names = {p.name for p in workshop.parameters_of(form)}
        if names & known and names - known and form.applies_to(workshop.nominal):
            found[choice] = form
    return found


def in_form(workshop: Workshop, found: Fit, form: Effect) -> Model:
    """A fitted model with one of its effects in another form: the numbers that both have as they
    are, the form's own at the starts that fit best. Stops at both ends of the travel may be seen by
    neither of the clearances that screening gives them, and by one of them all the same."""
    effects = [form if e.id == form.id else e for e in found.model.effects]
    parameters = {f"{form.id}.{p.name}": p for p in workshop.parameters_of(form)}
    values = {
        name: value
        for name, value in found.model.values.items()
        if name in parameters or not name.startswith(f"{form.id}.")
    }
    model = replace(found.model, effects=tuple(effects), values=values)
    own = {name: p for name, p in parameters.items() if name not in values}
    if not own:
        return model
    begins = product(*(p.starts if isinstance(p, Shape) else (p.start,) for p in own.values()))
    models = [model.with_values(dict(zip(own, begin, strict=True))) for begin in begins]
    left = misfits(workshop, models, workshop.of_role("fit"), found.sigma)
    return models[int(np.argmin(left))]


def plainer(workshop: Workshop, found: Fit) -> Iterator[tuple[str, Model]]:
    """Where a fit has ended, its last effect in each form that has some of its numbers and no
    others, with the form's name: friction that holds no more at rest than it slides with."""
    effect = found.model.effects[-1]
    names = {p.name for p in workshop.parameters_of(effect)}
    for choice in effect.choices(workshop.campaign.channels):
        form = effect.with_choice(choice)
        fewer = {p.name for p in workshop.parameters_of(form)}
        if fewer < names and form.applies_to(workshop.nominal):
            yield choice, in_form(workshop, found, form)


def shapes_as_believed(found: Fit) -> Iterator[Model]:
    """Each shape of a fit's last effect where it is believed to be. No derivative leads to a stop
    that the model never reaches, and a fit may stay wherever it came upon such a plateau."""
    last, values = found.model.effects[-1].id, found.model.values
    for i, shape in enumerate(found.shared):
        if shape.name.startswith(f"{last}.") and shape.is_shape and isfinite(shape.sigma):
            yield found.model.with_values(_with_shape(found, i, shape.mean - values[shape.name]))


def shapes_nearby(fitted: Fit, foreseen: Model) -> Iterator[Model]:
    """Each shape of an effect one standard deviation up and down, for runs that were not fitted.
    Stops that the runs fitted hardly reach may lie millimetres from where they are foreseen, and
    the fit of a run that does reach them ends in a false minimum."""
    for i, shape in enumerate(fitted.shared):
        if shape.is_shape and (variance := fitted.covariance[i, i]) > 0.0:
            for by in (-sqrt(variance), sqrt(variance)):
                yield foreseen.with_values(_with_shape(fitted, i, by))


def _with_shape(found: Fit, i: int, by: float) -> dict[str, float]:
    """A fit's shared numbers, one of them moved, the others along with it as the data hold them
    together."""
    return _moved(found, found.model, found.covariance[i] / found.covariance[i, i] * by)


def _moved(base: Fit, model: Model, steps: Iterable[float]) -> dict[str, float]:
    """The numbers of a model that a fit shares, each moved by a step, within their bounds."""
    pairs = zip(base.shared, steps, strict=True)
    return {f.name: min(max(model.values[f.name] + float(d), f.lower), f.upper) for f, d in pairs}


def at_shares(
    workshop: Workshop, base: Rung, screened: Screened, shares: Sequence[float]
) -> Iterator[Model]:
    """One form of an effect at some shares of the amplitudes that screening expects: with the
    vehicle as it is, and moved along with them."""
    variant = screened.variant
    absent = with_variant(base.model, variant, {})
    everywhere = list(workshop.benches.values())
    begins = begun(workshop, base.model, absent, variant.effect, variant.shapes, everywhere)
    for share in shares:
        amplitudes = {}
        for p in variant.amplitudes:
            away = (screened.amplitudes[p.name] - p.absent) * (
                1.0 if isinstance(p, Switch) else share
            )
            least = SMALLEST_START * p.scale
            away = away if abs(away) > least else least
            amplitudes[p.name] = min(max(p.absent + away, p.lower), p.upper)
        model = begins.with_values({f"{variant.effect.id}.{k}": v for k, v in amplitudes.items()})
        yield model
        moved = [share * screened.along.get(f.name, 0.0) for f in base.fit.shared]
        if any(moved):
            yield model.with_values(_moved(base.fit, model, moved))


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
        starts = probe.run_starts(effect, bench.simulator.setting, shapes)
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


def with_starts(model: Model, effect: Effect, run_id: str, start: Values) -> Model:
    """The model with what an effect begins with in one run; speed and start are the run's own."""
    whole = ("speed_m_s", "start_m")
    return model.with_run(
        run_id, {k if k in whole else f"{effect.id}.{k}": v for k, v in start.items()}
    )


def of_the_vehicle(found: Fit) -> list[Free]:
    """The shared numbers of a fit that are no effect's."""
    effects = tuple(f"{effect.id}." for effect in found.model.effects)
    return [f for f in found.shared if not f.name.startswith(effects)]


def believable(found: Fit, free: Sequence[Free]) -> bool:
    """Whether these numbers of a fit lie where they are believed to."""
    values = found.model.values
    return all(abs(f.away(values[f.name])) < FAR for f in free)


def misfits(
    workshop: Workshop, models: Sequence[Model], benches: Sequence[Bench], sigma: float
) -> list[float]:
    """−2 ln p of what each model leaves of these runs, `sigma` being the noise of a coefficient."""
    trials = [(model, workshop.systems(model)) for model in models]

    def of_run(bench: Bench) -> list[float]:
        measured = bench.measured[:, bench.predicted].ravel()
        residuals = [measured - bench.coefficients(record) for record in bench.records(trials)]
        return [bench.cost(residual, sigma) for residual in residuals]

    total = np.sum(workshop.each(of_run, benches), axis=0)
    return [float(t) if isfinite(t) else inf for t in total]


def placings(workshop: Workshop, model: Model, bench: Bench) -> Sequence[Model]:
    """A run anew where on its track its record fits, and wherever an effect may begin in it."""
    run_id = bench.run.id
    sought = seek_again(workshop.campaign, bench, model, workshop.systems(model))
    again = model.with_run(run_id, sought)
    found = [again] if sought else []
    for effect in model.effects:
        if effect.per_run(bench.simulator.setting):
            probe = FitProbe(workshop, again.without_effect(effect.id), [bench])
            shapes = model.theta(effect)
            starts = probe.run_starts(effect, bench.simulator.setting, shapes)
            found += [with_starts(again, effect, run_id, start) for start in starts if start]
    return found
