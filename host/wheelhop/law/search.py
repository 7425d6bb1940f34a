"""Find the law: which place, how much of what is left it explains, and which formula it has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, ComponentCampaign
from wheelhop.diagnose import Progress, Rung, fit_baseline
from wheelhop.diagnose.added import fit_with
from wheelhop.diagnose.confirm import confirm
from wheelhop.diagnose.judge import at_noise
from wheelhop.diagnose.promising import least_gain
from wheelhop.diagnose.screen import Screened, screen
from wheelhop.diagnose.screen_sums import Terms
from wheelhop.diagnose.validate import Incumbent, validate
from wheelhop.effects import Effect
from wheelhop.fit import Workshop, fit
from wheelhop.law.formula import Formula
from wheelhop.law.free import Form, FreeForce
from wheelhop.law.places import Moved, Where, motion_of, places
from wheelhop.law.terms import Term, candidates, knots, slips
from wheelhop.vehicle import Vehicle, static_tyre_load

Array = NDArray[np.float64]

COUNTS = {True: (5, 9, 17, 33), False: (5,)}
"""Knots of a spline where an imposed motion gives the force at once; and elsewhere, where each knot
is an integration of every run."""
MOST_OF_BOTH = 9
"""More knots than that belong to a law with a kink, which is one of extension or of rate alone."""
MOST_TERMS = 4
NAMED = 3
"""So many named laws are fitted in full beside the free one."""
AS_WELL = 1.05
"""A law with a name that leaves no more than this many times what the free one leaves does as
well."""


@dataclass(frozen=True, eq=False)
class Rival:
    """A law fitted in full: its name, how it reads, and the model with it."""

    name: str
    words: str
    rung: Rung


@dataclass(frozen=True, eq=False)
class Found:
    """What was found. `free` is None where nothing can be found; `named` are laws of the library at
    the same kind of place, best first; `formula` may be None; `screened` holds for every place the
    share of the residual's power its best form explains to first order."""

    workshop: Workshop
    base: Rung
    screened: Mapping[str, float]
    free: Rival | None
    where: Where | None
    moved: Moved | None
    named: Sequence[Rival]
    formula: Rival | None

    @property
    def preferred(self) -> Rival | None:
        """The simplest law that does as well as any: a name before a formula before free form."""
        if self.free is None:
            return None
        order = [r for r in (*self.named[:1], self.formula, self.free) if r is not None]
        least = min(r.rung.error_judging for r in order)
        return next(r for r in order if r.rung.error_judging <= AS_WELL * least)


def find_law(
    campaign: Campaign,
    vehicle: Vehicle,
    accepted: Sequence[Effect],
    library: Sequence[Effect],
    progress: Progress,
) -> Found:
    """Look for a force the model with the `accepted` effects lacks, `library` beside it.

    Raises
    ------
    CampaignError
        The campaign does not hold what a comparison needs, or an effect does not apply to it.
    """
    baseline = fit_baseline(campaign, vehicle, progress=progress)
    workshop, base = baseline.workshop, fit_with(baseline, accepted, progress)[-1]
    progress("screening free laws at every place")
    free, shares = _screen_places(workshop, base)
    nothing = Found(workshop, base, shares, None, None, None, (), None)
    if not free or free[0][1].gain < least_gain(workshop, base) or at_noise(base, workshop.noise):
        return nothing
    where, best = free[0]
    progress(f"fitting a free law at the {where.name}")
    rung = confirm(workshop, base, replace(best, others=()))
    if not Incumbent(workshop, base).gives_way_to(rung):
        return nothing
    moved = motion_of(workshop, base.model, where)
    formula = _formula(workshop, base, rung, where, moved, progress) if moved is not None else None
    named = _named(workshop, base, where, library, progress)
    words = f"free law with {best.variant.choice}"
    return Found(workshop, base, shares, Rival("free", words, rung), where, moved, named, formula)


def _screen_places(
    workshop: Workshop, base: Rung
) -> tuple[list[tuple[Where, Screened]], dict[str, float]]:
    """Every place with its best form, the most likely first, and the shares they explain."""
    found = []
    campaign = workshop.campaign
    quick = isinstance(campaign, ComponentCampaign) and campaign.drive == "displacement"
    for where in places(base.model.values):
        moved = motion_of(workshop, base.model, where)
        forms = _forms(base.model.values, where, moved, quick)
        if forms and (result := screen(workshop, base.fit, [FreeForce(where, forms)])):
            found.append((where, result[0]))
    found = [(w, s) for w, s in found if np.isfinite(s.gain)]
    power = base.fit.error**2
    shares = {where.name: 1.0 - s.error**2 / power for where, s in found}
    return sorted((f for f in found if f[1].score > 0), key=lambda f: -f[1].score), shares


def _forms(
    values: Mapping[str, float], where: Where, moved: Moved | None, quick: bool
) -> dict[str, Form]:
    """From few terms to many; `quick`: where a simulation costs next to nothing."""
    forms: list[Form] = []
    if where.kind == "tyre":
        rest = static_tyre_load(values, where.corners[0])
        end = "front" if where.corners[0] < 2 else "rear"
        deflection = rest / values[f"wheel.{end}.tyre_stiffness_N_m"]
        forms.append(Form("5 knots of deflection",
                          tuple(float(s) * deflection for s in np.linspace(-1, 1, 5))))  # fmt: skip
    elif moved is not None:
        for count in COUNTS[quick]:
            x, v = knots(moved.extension, count), knots(moved.rate, count)
            forms += [
                Form(f"{count} knots of extension", x),
                Form(f"{count} knots of rate", (), v),
            ]
            if count > MOST_OF_BOTH:
                continue
            forms.append(Form(f"{count} knots each of extension and rate", x, v))
            if quick:
                ways = slips(moved.extension)
                both = f"{count} knots each of extension and rate, and sliders"
                forms.append(Form(both, x, v, ways))
        forms.append(Form("sliders", (), (), slips(moved.extension)[:: 1 if quick else 3]))
    return {form.name: form for form in forms}


def _formula(
    workshop: Workshop, base: Rung, free: Rung, where: Where, moved: Moved, progress: Progress
) -> Rival | None:
    """Terms joined one by one while the evidence, to first order, asks for one more and the free
    law leaves less; then taken out again while the others do as well. What is left counts as noise
    (profile likelihood and the price of BIC)."""

    def worth(screened: Screened) -> float:
        return -base.fit.size * float(np.log(screened.error)) - 0.5 * screened.price

    worst = -base.fit.size * float(np.log(base.error_fit))
    chosen: list[Term] = []
    best: Screened | None = None
    every = candidates(moved.extension, moved.rate)
    progress(f"terms of a formula for the {where.name}")
    sums = Terms(workshop, base.fit, [Formula(where, [term]) for term in every])
    while len(chosen) < MOST_TERMS and (best is None or best.error > AS_WELL * free.error_fit):
        trials = [(sums.screen(Formula(where, [*chosen, term])), term)
                  for term in every if term not in chosen]  # fmt: skip
        trials = [t for t in trials if np.isfinite(t[0].gain)]
        if not trials:
            break
        screened, term = max(trials, key=lambda t: worth(t[0]))
        if worth(screened) <= (worth(best) if best else worst):
            break
        best, chosen = screened, [*chosen, term]
    if best is None:
        return None
    progress(f"fitting the formula for the {where.name}")
    rung = confirm(workshop, base, best)
    while len(chosen) > 1:  # the first term chosen may be what only two others together explain
        fewer = [term for term in chosen if term is not _least_sure(rung, chosen)]
        shorter = _in_place(workshop, rung, Formula(where, fewer))
        if shorter.error_judging > AS_WELL * rung.error_judging:
            break
        rung, chosen = shorter, fewer
    return Rival("formula", " + ".join(t.words for t in chosen), rung)


def _least_sure(rung: Rung, terms: Sequence[Term]) -> Term:
    """The term whose force is the smallest multiple of its standard deviation."""
    fit = rung.fit

    def sure(term: Term) -> float:
        name = f"{Formula.id}.{term.name}_N"
        return abs(fit.model.values[name]) / fit.uncertainty(name)

    return min(terms, key=sure)


def _in_place(workshop: Workshop, rung: Rung, formula: Formula) -> Rung:
    """The rung with a formula in place of a longer one, fitted from there with its derivatives."""
    model = rung.model.without_effect(formula.id)
    model = model.with_effect(formula, workshop.parameters_of(formula))
    model = model.with_values({name: rung.model.values[name] for name in model.values})
    shared = [free for free in rung.fit.shared if free.name in model.values]
    fitted = fit(workshop, model, shared, workshop.of_role("fit"), rung.fit)
    return validate(workshop, fitted)


def _named(
    workshop: Workshop, base: Rung, where: Where, library: Sequence[Effect], progress: Progress
) -> list[Rival]:
    """The laws of the library that explain most at this kind of place, fitted in full."""
    present = {effect.id for effect in base.model.effects}
    kind = "tyre" if where.kind == "tyre" else "suspension"
    rivals = [e for e in library if e.place == kind and e.id not in present]
    progress("named laws beside it")
    screened = [s for s in screen(workshop, base.fit, rivals) if np.isfinite(s.gain)][:NAMED]
    fitted = [
        Rival(s.variant.effect.id, s.variant.effect.title, confirm(workshop, base, s))
        for s in screened
    ]
    return sorted(fitted, key=lambda r: r.rung.error_judging)
