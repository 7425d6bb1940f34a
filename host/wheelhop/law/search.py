"""Find the law: which place, how much of what is left it explains, and which formula it has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign
from wheelhop.diagnose import Progress, Rung, fit_baseline
from wheelhop.diagnose.confirm import confirm, least_gain, refit
from wheelhop.diagnose.judge import at_noise
from wheelhop.diagnose.ladder import fit_with, one_more
from wheelhop.diagnose.screen import Screened, screen
from wheelhop.diagnose.validate import Incumbent, validate
from wheelhop.effects import Effect
from wheelhop.fit import Workshop, effect_parameters, fit
from wheelhop.law.along import along, force_along
from wheelhop.law.first_order import Promise, gives_force_at_once, screen_places
from wheelhop.law.formula import Formula
from wheelhop.law.free import FreeForce
from wheelhop.law.motion import Moves
from wheelhop.law.moved import Moved
from wheelhop.law.places import SEAT, Where
from wheelhop.law.regression import Signatures, Sums
from wheelhop.law.terms import SHAPED, Term, candidates, neighbours
from wheelhop.vehicle import Vehicle, is_component

Array = NDArray[np.float64]

MOST_TERMS = 4
NAMED, NAMED_ON_RIG = 3, 5
"""So many named laws are fitted in full beside the free one."""
AS_WELL = 1.05
"""A law with a name that leaves no more than this many times what the free one leaves does as
well."""

STEPS = (0.1, 0.05, 0.025, 0.0125)
"""By such shares of the largest extension gaps move, and widths by factors alike."""

ALIKE = 1e-4
"""A term of which no more than this share of its power is new, beside those before it, is none."""


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
    share of the residual's power its best form explains to first order. `joined` names effects the
    `base` has beyond those accepted: what puts a place where none was."""

    workshop: Workshop
    base: Rung
    screened: Mapping[str, float]
    free: Rival | None
    where: Where | None
    moved: Moved | None
    named: Sequence[Rival]
    formula: Rival | None
    joined: tuple[str, ...] = ()

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
    promises, signatures, moves = screened(workshop, base, progress)
    seat, joined = seat_for(workshop, base, library), tuple[str, ...]()
    if seat is not None and seat.score > max((p.screened.score for p in promises), default=0.0):
        # No law of any place there is, but a place that is not there yet.
        base, joined = one_more(workshop, base, seat.variant.effect, progress), (SEAT,)
        promises, signatures, moves = screened(workshop, base, progress)
    power = base.fit.error**2
    shares = {p.where.name: 1.0 - p.screened.error**2 / power for p in promises}
    nothing = Found(workshop, base, shares, None, None, None, (), None, joined)
    if not promises or at_noise(base, workshop.noise):
        return nothing
    best = promises[0]
    if best.screened.score <= 0 or best.screened.gain < least_gain(workshop, base):
        return nothing
    where = best.where
    progress(f"fitting a free law at the {where.name}")
    rung = confirm(workshop, base, best.screened)
    moved = moves.of(where)
    formula = None
    if moved is not None:
        if moves.on_road:
            moves = Moves(workshop, base.model, rung.model)
            signatures = Signatures(workshop, base.fit, moves)
        formula = _formula(signatures, base, rung, where, moved, progress)
    # Where one run alone went far, a spline knows nothing without it; a formula may.
    laws = [rung] if formula is None else [rung, formula.rung]
    if not any(Incumbent(workshop, base).gives_way_to(law) for law in laws):
        return nothing
    named = _named(workshop, base, where, library, progress)
    free = Rival("free", f"free law with {best.form.name}", rung)
    return Found(workshop, base, shares, free, where, moved, named, formula, joined)


def screened(
    workshop: Workshop, base: Rung, progress: Progress
) -> tuple[list[Promise], Signatures, Moves]:
    """Every place with what promises most there, and what that was told by."""
    progress("screening free laws at every place")
    moves = Moves(workshop, base.model)
    signatures = Signatures(workshop, base.fit, moves)
    return screen_places(signatures, base, moves), signatures, moves


def seat_for(workshop: Workshop, base: Rung, library: Sequence[Effect]) -> Screened | None:
    """What a seat for the driver promises, where the model has none."""
    if SEAT in {effect.id for effect in base.model.effects}:
        return None
    found = screen(workshop, base.fit, [effect for effect in library if effect.id == SEAT])
    return found[0] if found and np.isfinite(found[0].gain) else None


def _formula(
    signatures: Signatures, base: Rung, free: Rung, where: Where, moved: Moved, progress: Progress
) -> Rival | None:
    """Terms joined one by one, each with its gap or width as the data ask for it, while the
    evidence asks for one more and the free law leaves less; then taken out again while the others
    do as well."""
    workshop = signatures.workshop
    every = candidates(moved.extension, moved.rate, moved.inputs)
    progress(f"terms of a formula for the {where.name}")
    chosen: list[Term] = []
    best: Screened | None = None
    worth = 0.0
    while len(chosen) < MOST_TERMS and (best is None or best.error > AS_WELL * free.error_fit):
        taken = {term.name for term in chosen}
        trials = [[*chosen, term] for term in every if term.name not in taken]
        more, trial = _best_of(signatures, where, trials)
        if not more > worth:
            break
        worth, chosen = _shaped(signatures, where, trial, more)
        alone = [signatures.alone(where, term) for term in chosen]
        best = Sums(signatures, alone).screen(Formula(where, chosen), alone)
    if best is None or not np.isfinite(best.gain):
        return None
    progress(f"fitting the formula for the {where.name}")
    rung = _fitted(workshop, base, best)
    if (
        not gives_force_at_once(workshop.campaign)
        and rung.error_judging > AS_WELL * free.error_judging
    ):
        # To first order a strong law is told at the motion without it; the free law knows better.
        other, terms = _like_the_free_law(workshop, base, free, where, moved, every)
        if other.error_judging < rung.error_judging:
            rung, chosen = other, terms
    while len(chosen) > 1:  # the first term chosen may be what only two others together explain
        fewer = [term for term in chosen if term is not _least_sure(rung, chosen)]
        shorter = _in_place(workshop, rung, Formula(where, fewer))
        if shorter.error_judging > AS_WELL * rung.error_judging:
            break
        rung, chosen = shorter, fewer
    return Rival("formula", " + ".join(t.words for t in chosen), rung)


def _fitted(workshop: Workshop, base: Rung, screened: Screened) -> Rung:
    """The model with a law, fitted in full. A strong one moves everything else elsewhere: where
    more than noise is left, its derivatives are not those without it."""
    rung = confirm(workshop, base, screened)
    if gives_force_at_once(workshop.campaign) or at_noise(rung, workshop.noise):
        return rung
    return min(rung, refit(workshop, rung), key=lambda rung: rung.fit.cost)


def _best_of(
    signatures: Signatures, where: Where, trials: Sequence[list[Term]]
) -> tuple[float, list[Term]]:
    """The sum of terms of greatest evidence, and that: a gap or a width that is chosen is a number
    that is fitted, as a force is."""
    alone = {term: signatures.alone(where, term) for trial in trials for term in trial}
    sums = Sums(signatures, list(alone.values()))

    def worth(terms: Sequence[Term]) -> float:
        shapes = sum(term.kernel in SHAPED for term in terms)
        return sums.worth([[alone[term]] for term in terms], shapes)

    return max(((worth(trial), trial) for trial in trials), key=lambda found: found[0])


def _shaped(
    signatures: Signatures, where: Where, terms: list[Term], worth: float
) -> tuple[float, list[Term]]:
    """The terms with their gaps and widths moved to where they explain most, one after the other,
    by smaller and smaller steps; and what they are worth."""
    for step in STEPS:
        for i in reversed(range(len(terms))):
            taken = {term.name for term in terms}
            trials = [
                [*terms[:i], other, *terms[i + 1 :]]
                for other in neighbours(terms[i], step)
                if other.name not in taken
            ]
            if trials:
                more, trial = _best_of(signatures, where, trials)
                if more > worth:
                    worth, terms = more, trial
    return worth, terms


def _like_the_free_law(
    workshop: Workshop, base: Rung, free: Rung, where: Where, moved: Moved, every: Sequence[Term]
) -> tuple[Rung, list[Term]]:
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
    fitted = fit(workshop, model, [*shared, *own_numbers], workshop.of_role("fit"), free.fit)
    return validate(workshop, fitted), chosen


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
    """The laws of the library that explain most at this kind of place, fitted in full: the first,
    and on a rig every one, in all its forms, the others, which stand beside it for the eye, in the
    likeliest one."""
    present = {effect.id for effect in base.model.effects}
    kind = {"strut": "suspension", "tyre": "tyre", "mount": ""}[where.kind]
    rivals = [e for e in library if e.place == kind and e.id not in present]
    progress("named laws beside it")
    screened = [s for s in screen(workshop, base.fit, rivals) if np.isfinite(s.gain)]
    if is_component(base.model.values):
        screened = screened[:NAMED_ON_RIG]
    else:
        screened = [*screened[:1], *(replace(s, others=()) for s in screened[1:NAMED])]
    fitted = [
        Rival(s.variant.effect.id, s.variant.effect.title, confirm(workshop, base, s))
        for s in screened
    ]
    # A law that holds another one as its limit leaves a little less wherever that one is true.
    least = min((r.rung.error_judging for r in fitted), default=0.0)

    def order(rival: Rival) -> tuple[bool, float]:
        as_well = rival.rung.error_judging <= AS_WELL * least
        return not as_well, -rival.rung.evidence if as_well else rival.rung.error_judging

    return sorted(fitted, key=order)
