"""Effects too strong for first order: friction that nearly always holds its struts, for one.

The vehicle fitted without it has springs as stiff as what holds them, and about that vehicle the
effect's signature is nothing. Nor does a little of it help where the vehicle is believed to be. So
each effect is simulated there as strong as shows clearly (`Parameter.scale`), and what comes
nearest to the records is fitted from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from wheelhop.diagnose.confirm.in_full import fitted_from, least_cost, starts_of
from wheelhop.diagnose.confirm.validate import Incumbent, misfits, validate
from wheelhop.diagnose.score import Rung
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.simulate import Model


def strong(incumbent: Incumbent, screened: Sequence[Screened]) -> list[tuple[Screened, Model]]:
    """Effects as strong as shows clearly, each with the model where its fit may begin: those that
    come nearest to the runs fitted first, and none that comes no nearer than the vehicle does
    without. Empty where that vehicle is not hard to believe."""
    base, workshop = incumbent.as_believed, incumbent.workshop
    if base is None:
        return []
    starts = [
        (effect, next(starts_of(workshop, base, _as_strong(form), [1.0])))
        for effect in screened
        for form in (effect, *effect.others)
        if any(not p.switch for p in form.variant.amplitudes)
    ]
    models = [base.model, *(model for _, model in starts)]
    without, *left = misfits(workshop, models, workshop.of_role("fit"), base.fit.sigma)
    order = sorted(range(len(starts)), key=lambda i: left[i])
    best: dict[str, tuple[Screened, Model]] = {}
    for i in order:
        if left[i] < without:
            best.setdefault(starts[i][0].variant.effect.id, starts[i])
    return list(best.values())


def confirm_strong(incumbent: Incumbent, start: Model, beside: Sequence[Rung]) -> Rung:
    """The rung that a fit from one of these models ends at, all derivatives following the model:
    those of the vehicle without know nothing of so strong an effect. It ends early where it has no
    hope to come as far as the incumbent and the models `beside` it."""
    workshop, base = incumbent.workshop, incumbent.rung
    found, _ = fitted_from(workshop, base, start, least_cost([base, *beside]), anew=True)
    return validate(workshop, found, before=start)


def _as_strong(screened: Screened) -> Screened:
    """The same with every amplitude at its scale, to the side where screening sees it."""
    amplitudes = dict(screened.amplitudes)
    for p in screened.variant.amplitudes:
        if not p.switch:
            side = -1.0 if amplitudes[p.name] < p.absent else 1.0
            amplitudes[p.name] = p.absent + side * p.scale
    return replace(screened, amplitudes=amplitudes)
