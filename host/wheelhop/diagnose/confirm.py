"""Confirmation: an effect simulated in full and fitted together with the vehicle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf, isfinite

import numpy as np

from wheelhop.diagnose.judge import all_noise
from wheelhop.diagnose.placement import begun, placed_anew
from wheelhop.diagnose.rung import Rung
from wheelhop.diagnose.screen import Screened, with_variant
from wheelhop.diagnose.validate import validate
from wheelhop.fit import Bench, Fit, Free, Workshop, effect_parameters, fit
from wheelhop.simulate import Model


def confirm(
    workshop: Workshop, base: Rung, screened: Screened, beside: Sequence[Rung] = ()
) -> Rung:
    """Fit the model of `base` with the screened effect added.

    Derivatives with respect to the base's parameters are taken from the base: a quick fit that
    ends a little above the minimum; `refit` goes all the way. A fit that ends far above what
    screening expects, or at numbers hard to believe, has gone astray and begins again elsewhere,
    and so does one that leaves more than noise while another form is as likely: to first order a
    strong effect shows little difference between its forms. The best one counts. A switch changes
    everything at once: where it makes things worse, the derivatives have changed, and only a full
    fit does it justice. What has no hope to come as far as one of the models `beside` it ends
    early.
    """
    benches = workshop.of_role("fit")
    bar = _bar(beside, screened.variant.effect.has_random_heights)
    best: Fit | None = None
    believed = False
    starts = _starts(workshop, base, screened)[: len(SHARES)]
    forms = [choice for choice, _ in starts]
    for i, (_, model) in enumerate(starts):
        effect = model.effects[-1]
        free = effect_parameters(workshop.parameters_of(effect), model, effect)
        # Where an amplitude is not yet what it should be, shapes would run away to make up for it.
        amplitudes = [f for f in free if not f.is_shape]
        if 0 < len(amplitudes) < len(free):
            shared = [*base.fit.shared, *amplitudes]
            model = fit(workshop, model, shared, benches, base.fit, bar=bar).model
        found = fit(workshop, model, [*base.fit.shared, *free], benches, base.fit, bar=bar)
        if best is None or found.evidence > best.evidence:
            best, believed = found, _believable(found, free)
        fine = best.error < ASTRAY * screened.error and believed
        tried = all_noise(best, workshop.noise) or set(forms[i + 1 :]) <= set(forms[: i + 1])
        if fine and tried:
            break
    assert best is not None
    rough = validate(workshop, best, base.update)
    worse = best.cost > base.fit.cost and all(p.switch for p in screened.variant.amplitudes)
    if worse:
        return min(rough, refit(workshop, rough, base), key=lambda rung: rung.fit.cost)
    return rough


def _believable(found: Fit, free: Sequence[Free]) -> bool:
    """Whether the numbers lie where they are believed to."""
    values = found.model.values
    return all(abs(values[f.name] - f.mean) < FAR * f.sigma for f in free)


def refit(workshop: Workshop, rung: Rung, ahead: Rung | None = None) -> Rung:
    """Fit all parameters of a rung again, with all derivatives following the model; runs that stay
    far above the others are placed on their track anew. A fit that has no hope to come as far as
    the rung `ahead` ends early."""
    model, benches = placed_anew(workshop, rung), workshop.of_role("fit")
    bar = _bar([] if ahead is None else [ahead], model.random_heights is not None)
    found = fit(workshop, model, rung.fit.shared, benches, bar=bar)
    return validate(workshop, found, before=model)


def _bar(rivals: Sequence[Rung], has_random_heights: bool) -> float:
    """The least cost among rivals. Unknown heights have another likelihood: what they cost says
    nothing of models without."""
    alike = [r.fit.cost for r in rivals if r.model.random_heights is None]
    return -inf if has_random_heights else min(alike, default=-inf)


def without(workshop: Workshop, rung: Rung, effect_id: str, *, quick: bool = False) -> Rung:
    """The rung's model with one effect taken out, fitted again; `quick`: with the rung's own
    derivatives, which shows what it is missed for."""
    shared = [f for f in rung.fit.shared if not f.name.startswith(f"{effect_id}.")]
    model, known = rung.model.without_effect(effect_id), rung.fit if quick else None
    return validate(workshop, fit(workshop, model, shared, workshop.of_role("fit"), known))


SHARES = (1.0, 0.4, 0.1)
"""A fit begins at one of these shares of the amplitudes that screening expects: to first order
strong effects are overrated."""

SMALLEST_START = 0.05
"""And with at least this fraction of an amplitude's scale: at zero some laws are flat."""

ASTRAY = 1.2
"""A fit that ends this many times above the error that screening expects has gone astray."""

FAR = 3.0
"""And so has one that ends so many standard deviations from what is believed of the effect's
numbers: a gap that is never used up fits from any width above one that is."""


def _starts(workshop: Workshop, base: Rung, screened: Screened) -> list[tuple[str, Model]]:
    """The models where the fit of an effect may begin, each with its form: the likeliest variants,
    each as it fits best at some share of what screening expects, the vehicle as it is or moved
    along; then more shares of the likeliest."""
    by_variant = []
    for item in (screened, *screened.others):
        models = list(_starts_of(workshop, base, item))
        order = np.argsort(_misfits(workshop, base, models), kind="stable")
        by_variant.append([(item.variant.choice, models[i]) for i in order])
    return [*(models[0] for models in by_variant), *by_variant[0][1:]]


def _starts_of(workshop: Workshop, base: Rung, screened: Screened) -> Iterator[Model]:
    variant = screened.variant
    shares = SHARES if any(not p.switch for p in variant.amplitudes) else SHARES[:1]
    absent = with_variant(base.model, variant, {})
    begins = begun(workshop, base.model, absent, variant.effect, variant.shapes)
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


def _misfits(workshop: Workshop, base: Rung, models: Sequence[Model]) -> list[float]:
    """−2 ln p of what each model leaves of the runs fitted."""
    trials = [(model, workshop.systems(model)) for model in models]

    def of_run(bench: Bench) -> list[float]:
        measured = bench.measured[:, bench.predicted].ravel()
        residuals = [measured - bench.coefficients(record) for record in bench.records(trials)]
        return [bench.cost(residual, base.fit.sigma) for residual in residuals]

    total = np.sum(workshop.each(of_run, workshop.of_role("fit")), axis=0)
    return [float(t) if isfinite(t) else inf for t in total]
