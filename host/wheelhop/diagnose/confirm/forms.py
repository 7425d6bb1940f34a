"""Which form of an effect explains most: to first order a strong one shows little difference."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from wheelhop.diagnose.confirm.in_full import confirm, least_cost, refit
from wheelhop.diagnose.confirm.validate import Incumbent, validate
from wheelhop.diagnose.score import HOPELESS, Rung, at_noise, best_first
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.fit import Workshop, effect_parameters, fit
from wheelhop.simulate import Model


def best_form(incumbent: Incumbent, screened: Screened, found: Rung) -> Rung:
    """The effect that was added to a rung in the form that explains most in full simulation.

    Forms that screening could not tell from the one `found` are begun where screening puts them.
    One with no hope to come as far as that in the runs fitted is fitted no further, and what
    held-out runs say of it means nothing. Where something is left, a form that has all of its
    numbers and more begins where it has ended: stops at both ends of the travel may be seen by
    neither of the clearances that screening gives them, and by one of them all the same.
    """
    workshop = incumbent.workshop
    tried = (screened, *screened.others)
    present = {s.variant.choice for s in tried if s.variant.effect in found.model.effects}
    for other in tried:
        if other.variant.choice not in present:
            present.add(other.variant.choice)
            rival = confirm(incumbent, replace(other, others=()), beside=[found])
            if rival.error_judging <= HOPELESS * found.error_judging:
                rival = refit(workshop, rival, least_cost([found]))
            found = _better(workshop, found, rival)
    for model in () if at_noise(found, workshop.noise) else _richer(workshop, found):
        effect = model.effects[-1]
        free = effect_parameters(workshop.parameters_of(effect), model, effect)
        shared, benches = [*incumbent.rung.fit.shared, *free], workshop.of_role("fit")
        fitted = fit(workshop, model, shared, benches, bar=least_cost([found]))
        found = _better(workshop, found, validate(workshop, fitted, before=model))
    return found


def _better(workshop: Workshop, found: Rung, rival: Rung) -> Rung:
    if rival.fit.cost >= found.fit.cost:
        return found
    return best_first([found, rival], workshop.noise)[0]


def _richer(workshop: Workshop, found: Rung) -> Iterator[Model]:
    """The model with its last effect in each form that has more numbers, these at their starts."""
    effect = found.model.effects[-1]
    known = {p.name for p in workshop.parameters_of(effect)}
    for choice in effect.choices(workshop.campaign.channels):
        form = effect.with_choice(choice)
        parameters = workshop.parameters_of(form)
        more = {
            f"{form.id}.{p.name}": p.starts[0] if p.is_shape else p.absent
            for p in parameters
            if p.name not in known
        }
        if more and len(known) + len(more) == len(parameters):
            model = replace(found.model, effects=(*found.model.effects[:-1], form))
            yield model.with_values(more)
