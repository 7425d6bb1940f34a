"""Few terms, by evidence, that say what a free law says: how a formula is found."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose import Progress, Rung
from wheelhop.diagnose.confirm.in_full import confirm, refit
from wheelhop.diagnose.confirm.validate import Incumbent, validate
from wheelhop.diagnose.score import at_noise
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.effects import Effect
from wheelhop.fit import Workshop, effect_parameters, fit
from wheelhop.law.along import along, force_along
from wheelhop.law.formula import Formula
from wheelhop.law.free import FreeForce
from wheelhop.law.moved import Moved
from wheelhop.law.places import Where
from wheelhop.law.regression import AS_WELL, Columned, Signatures, Sums, gives_force_at_once
from wheelhop.law.rival import Rival
from wheelhop.law.terms import SHAPED, Term, candidates, neighbours

Array = NDArray[np.float64]

MOST_TERMS = 4

STEPS = (0.1, 0.05, 0.025, 0.0125)
"""By such shares of the largest extension gaps move, and widths by factors alike."""

ALIKE = 1e-4
"""A term of which no more than this share of its power is new, beside those before it, is none."""


def find_formula(
    signatures: Signatures, base: Rung, free: Rung, where: Where, moved: Moved, progress: Progress
) -> Rival | None:
    """Terms joined one by one, each with its gap or width as the data ask for it, while the
    evidence asks for one more and the free law leaves less; then taken out again while the others
    do as well, and gaps and widths fitted with everything else."""
    workshop = signatures.workshop
    every = candidates(moved.extension, moved.rate, moved.inputs)
    progress(f"terms of a formula for {where.in_words}")
    best: Formula | None = None
    screened: Screened | None = None
    worth, axles = 0.0, [False, True] if len(where.ends()) > 1 else [False]
    while best is None or screened is None or screened.error > AS_WELL * free.error_fit:
        chosen = () if best is None else best.terms
        taken = {term.name for term in chosen}
        trials = [[*chosen, term] for term in every if term.name not in taken]
        more, trial = _best_of(signatures, where, trials, axles)
        if not more > worth or len(trial.terms) > MOST_TERMS:
            break
        _, best = _shaped(signatures, trial, more)
        worth, best = _best_of(signatures, where, [best.terms], axles)
        sums = Sums(signatures, _alone(signatures, best))
        screened = sums.screen(best, _columns(signatures, best))
    if best is None or screened is None or not np.isfinite(screened.gain):
        return None
    progress(f"fitting the formula for {where.in_words}")
    rung = fitted(workshop, base, screened)
    told = signatures.follow_records or gives_force_at_once(workshop.campaign)
    if not told and rung.error_judging > AS_WELL * free.error_judging:
        # Where terms are simulated beside the model, a strong law is told at the motion without it;
        # the free law knows better.
        other, like = _like_the_free_law(workshop, base, free, where, moved, every)
        if other.error_judging < rung.error_judging:
            rung, best = other, like
    rung, best = _with_shapes(workshop, rung, best)
    while len(best.terms) > 1:  # the first term chosen may be what only two others together explain
        unsure = _least_sure(rung, best)
        fewer = best.of([term for term in best.terms if term is not unsure])
        shorter = _in_place(workshop, rung, fewer)
        if shorter.error_judging > AS_WELL * rung.error_judging:
            break
        rung, best = shorter, fewer
    parts = best.parts(rung.model.values)
    words = dict.fromkeys(part.words if part.shape else part.term.words for part in parts)
    return Rival("formula", " + ".join(words), rung)


def fitted(workshop: Workshop, base: Rung, screened: Screened) -> Rung:
    """The model with a law, fitted in full. A strong one moves everything else elsewhere: where
    more than noise is left, its derivatives are not those without it."""
    rung = confirm(Incumbent(workshop, base), screened)
    if gives_force_at_once(workshop.campaign) or at_noise(rung, workshop.noise):
        return rung
    return min(rung, refit(workshop, rung), key=lambda rung: rung.fit.cost)


def _best_of(
    signatures: Signatures, where: Where, trials: Sequence[Sequence[Term]], axles: Sequence[bool]
) -> tuple[float, Formula]:
    """The sum of terms of greatest evidence, and that: a gap or a width that is chosen is a number
    that is fitted, as a force is. Whether each axle has forces of its own is one of `axles`."""
    tried = [Formula(where, trial, apart) for trial in trials for apart in axles]
    alone = dict.fromkeys(term for one in tried for term in _alone(signatures, one))
    sums = Sums(signatures, list(alone))

    def worth(formula: Formula) -> float:
        shapes = sum(term.kernel in SHAPED for term in formula.terms)
        own = sums.worth(_columns(signatures, formula), shapes)
        return own - (signatures.as_well if formula.apart else 0.0)

    return max(((worth(one), one) for one in tried), key=lambda found: found[0])


def _alone(signatures: Signatures, formula: Formula) -> list[Effect]:
    return [part for term in formula.terms for part in signatures.alone(formula.where, term)]


def _columns(signatures: Signatures, formula: Formula) -> Columned:
    """Of which terms at which axles each force of a formula is."""
    each = [
        [(part, f"{term.name}_N") for part in signatures.alone(formula.where, term)]
        for term in formula.terms
    ]
    if not formula.apart:
        return each
    return [[parts[i]] for i in range(len(formula.where.ends())) for parts in each]


def _shaped(signatures: Signatures, formula: Formula, worth: float) -> tuple[float, Formula]:
    """The formula with its gaps and widths moved to where it explains most, one after the other,
    by smaller and smaller steps; and what it is worth."""
    for step in STEPS:
        for i in reversed(range(len(formula.terms))):
            terms = formula.terms
            taken = {term.name for term in terms}
            trials = [
                (*terms[:i], other, *terms[i + 1 :])
                for other in neighbours(terms[i], step)
                if other.name not in taken
            ]
            if trials:
                more, trial = _best_of(signatures, formula.where, trials, [formula.apart])
                if more > worth:
                    worth, formula = more, trial
    return worth, formula


def _with_shapes(workshop: Workshop, rung: Rung, formula: Formula) -> tuple[Rung, Formula]:
    """Gaps and widths fitted with everything else, and each axle's own, if that is better; the
    formula as it was if neither is."""
    if not any(term.kernel in SHAPED for term in formula.terms):
        return rung, formula
    shaped = formula.with_free_shapes()
    found = _in_place(workshop, rung, shaped)
    if found.error_judging < rung.error_judging:
        rung, formula = found, shaped
    if at_noise(rung, workshop.noise) or formula.apart or len(formula.where.ends()) == 1:
        return rung, formula
    apart = shaped.with_each_axle()
    found = _in_place(workshop, rung, apart)
    better = found.error_judging * AS_WELL < rung.error_judging
    return (found, apart) if better else (rung, formula)


def _like_the_free_law(
    workshop: Workshop, base: Rung, free: Rung, where: Where, moved: Moved, every: Sequence[Term]
) -> tuple[Rung, Formula]:
    """The terms that one after the other, beside spring and damper, come nearest to the force of
    the free law along the motion recorded, fitted from there with its derivatives."""
    x, v, step = moved.extension, moved.rate, 1.0 / workshop.campaign.sample_rate_hz
    columns = [np.ones_like(x), x, v]
    target = force_along(free.model, where, moved, step)
    basis = np.linalg.qr(np.stack(columns, axis=1))[0]
    left = target - basis @ (basis.T @ target)
    # What the free law leaves unexplained it does not know either.
    enough = (free.error_judging / base.error_judging) ** 2 * float(left @ left)
    forces = {t: along(t.kernel, (1.0, *t.shape), moved, step, t.by) for t in every}
    chosen: list[Term] = []
    while len(chosen) < MOST_TERMS:
        own = {t: f - basis @ (basis.T @ f) for t, f in forces.items() if t not in chosen}
        own = {t: f for t, f in own.items() if f @ f > ALIKE * (forces[t] @ forces[t])}
        gains = {t: float(left @ f) ** 2 / float(f @ f) for t, f in own.items()}
        best = max(gains, key=lambda t: gains[t], default=None)
        if best is None or (chosen and gains[best] < enough):
            break
        chosen.append(best)
        columns.append(forces[best])
        basis = np.column_stack([basis, own[best] / np.linalg.norm(own[best])])
        left = target - basis @ (basis.T @ target)
    _, stiffness, damping, *amplitudes = np.linalg.lstsq(
        np.stack(columns, axis=1), target, rcond=None
    )[0].tolist()
    formula = Formula(where, chosen)
    model = free.model.without_effect(FreeForce.id)
    keys = ("component.stiffness_N_m", "component.damping_N_s_m")
    linear = zip(keys if where.name == "component" else (), (stiffness, damping), strict=False)
    model = model.with_effect(formula, workshop.parameters_of(formula)).with_values(
        {f"{formula.id}.{t.name}_N": n for t, n in zip(chosen, amplitudes, strict=True)}
        | {key: max(value, 0.0) for key, value in linear}
    )
    own_numbers = effect_parameters(workshop.parameters_of(formula), model, formula)
    shared = [f for f in free.fit.shared if not f.name.startswith(f"{FreeForce.id}.")]
    found = fit(workshop, model, [*shared, *own_numbers], workshop.of_role("fit"), free.fit)
    return validate(workshop, found), formula


def _least_sure(rung: Rung, formula: Formula) -> Term:
    """The term whose forces are the smallest multiple of their standard deviations."""
    found = rung.fit

    def sure(term: Term) -> float:
        names = formula.forces_of(term)
        return max(abs(found.model.values[name]) / found.uncertainty(name) for name in names)

    return min(formula.terms, key=sure)


def _in_place(workshop: Workshop, rung: Rung, formula: Formula) -> Rung:
    """The rung with a formula in place of another of such terms, fitted from there with its
    derivatives."""
    before = rung.model.values
    model = rung.model.without_effect(formula.id)
    model = model.with_effect(formula, workshop.parameters_of(formula))
    names = {name: name if name in before else formula.common(name) for name in model.values}
    model = model.with_values({n: before[known] for n, known in names.items() if known in before})
    own = effect_parameters(workshop.parameters_of(formula), model, formula)
    shared = [free for free in rung.fit.shared if not free.name.startswith(f"{formula.id}.")]
    found = fit(workshop, model, [*shared, *own], workshop.of_role("fit"), rung.fit)
    return validate(workshop, found)
