"""Find the law: which place, how much of what is left it explains, and which formula it has."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wheelhop.campaign import Campaign
from wheelhop.diagnose import Progress, Rung, fit_baseline
from wheelhop.diagnose.confirm.in_full import confirm, least_gain
from wheelhop.diagnose.confirm.validate import Incumbent
from wheelhop.diagnose.score import at_noise
from wheelhop.diagnose.screen.first_order import Screened, screen, taken_alone
from wheelhop.diagnose.search.ladder import fit_with, one_more
from wheelhop.effects import Effect
from wheelhop.fit import Workshop, foreseen
from wheelhop.law.few_terms import find_formula, fitted
from wheelhop.law.first_order import Promise, screen_places
from wheelhop.law.free import FreeForce
from wheelhop.law.motion import Moves
from wheelhop.law.moved import Moved
from wheelhop.law.names import nearest_name
from wheelhop.law.places import SEAT, Where
from wheelhop.law.regression import AS_WELL, Signatures
from wheelhop.law.rival import Rival
from wheelhop.vehicle import Vehicle, is_component

NAMED, NAMED_ON_RIG = 3, 5
"""So many named laws are fitted in full beside the free one."""


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
    return find_law_beside(
        baseline.workshop, fit_with(baseline, accepted, progress)[-1], library, progress
    )


def find_law_beside(
    workshop: Workshop,
    base: Rung,
    library: Sequence[Effect],
    progress: Progress,
    *,
    names: bool = True,
) -> Found:
    """Find a law beside a fitted model, with or without the `names` of the nearest known laws."""
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
    progress(f"fitting a free law at {where.in_words}")
    rung = fitted(workshop, base, best.screened)
    moved = moves.of(where)
    formula = None
    if moved is not None:
        start = base
        if moves.on_road:
            start = _without_law(workshop, base, rung)
            moves = Moves(workshop, start.model, rung.model)
            signatures = Signatures(workshop, start.fit, moves)
        formula = find_formula(signatures, start, rung, where, moved, progress)
    # Where one run alone went far, a spline knows nothing without it; a formula may.
    laws = [rung] if formula is None else [rung, formula.rung]
    incumbent = Incumbent(workshop, base)
    if not any(incumbent.gives_way_to(law) for law in laws):
        return nothing
    rivals = _of_kind(base, where, library)
    named = _named(incumbent, rivals, progress) if names else []
    law = min(laws, key=lambda rung: rung.error_judging)
    as_well = named and named[0].rung.error_judging <= AS_WELL * law.error_judging
    if names and not as_well:
        progress("the named law whose force comes nearest")
        nearest = nearest_name(workshop, law, where, moves, rivals)
        named = _best_first([*named, *([] if nearest is None else [nearest])])
    free = Rival("free", f"free law with {best.form.name}", rung)
    return Found(workshop, base, shares, free, where, moved, named, formula, joined)


def screened(
    workshop: Workshop, base: Rung, progress: Progress
) -> tuple[list[Promise], Signatures, Moves]:
    """Every place with what promises most there, and what that was told by."""
    progress("screening free laws at every place")
    moves = Moves(workshop, base.model)
    signatures = Signatures(workshop, base.fit, moves, taken_alone(base.fit))
    return screen_places(signatures, base, moves), signatures, moves


def _without_law(workshop: Workshop, base: Rung, rung: Rung) -> Rung:
    """The base with the vehicle, and every run's place on its track, as they are with the free law,
    which alone is taken away: without it a fit moves them to make up for it."""
    model = rung.fit.model.without_effect(FreeForce.id)
    shared = [free for free in rung.fit.shared if not free.name.startswith(f"{FreeForce.id}.")]
    told = foreseen(workshop, model, shared, workshop.of_role("fit"))
    systems = workshop.systems(told.model)
    left = workshop.each(lambda run: run.bench.residual(told.model, systems), told.runs)
    runs = tuple(
        replace(run, residual=residual, spread=fine.spread)
        for run, residual, fine in zip(told.runs, left, rung.fit.runs, strict=True)
    )
    return replace(base, fit=replace(told, runs=runs, sigma=rung.fit.sigma))


def seat_for(workshop: Workshop, base: Rung, library: Sequence[Effect]) -> Screened | None:
    """What a seat for the driver promises, where the model has none."""
    if SEAT in {effect.id for effect in base.model.effects}:
        return None
    found = screen(workshop, base.fit, [effect for effect in library if effect.id == SEAT])
    return found[0] if found and np.isfinite(found[0].gain) else None


def _of_kind(base: Rung, where: Where, library: Sequence[Effect]) -> list[Effect]:
    """The laws of the library at this kind of place that the base does not have."""
    present = {effect.id for effect in base.model.effects}
    kind = {"strut": "suspension", "tyre": "tyre", "mount": ""}[where.kind]
    return [e for e in library if e.place == kind and e.id not in present]


def _named(incumbent: Incumbent, rivals: Sequence[Effect], progress: Progress) -> list[Rival]:
    """Those that explain most, fitted in full: the first, and on a rig every one, in all its forms,
    the others, which stand beside it for the eye, in the likeliest one."""
    progress("named laws beside it")
    workshop, base = incumbent.workshop, incumbent.rung
    screened = [s for s in screen(workshop, base.fit, rivals) if np.isfinite(s.gain)]
    if is_component(base.model.values):
        screened = screened[:NAMED_ON_RIG]
    else:
        screened = [*screened[:1], *(replace(s, others=()) for s in screened[1:NAMED])]
    return _best_first(Rival(s.id, s.variant.effect.title, confirm(incumbent, s)) for s in screened)


def _best_first(rivals: Iterable[Rival]) -> list[Rival]:
    """Each name once, as it leaves least. A law that holds another one as its limit leaves a little
    less wherever that one is true: of those that do as well the likeliest is first."""
    best: dict[str, Rival] = {}
    for rival in sorted(rivals, key=lambda r: r.rung.error_judging):
        best.setdefault(rival.name, rival)
    least = min((r.rung.error_judging for r in best.values()), default=0.0)

    def order(rival: Rival) -> tuple[bool, float]:
        as_well = rival.rung.error_judging <= AS_WELL * least
        return not as_well, -rival.rung.evidence if as_well else rival.rung.error_judging

    return sorted(best.values(), key=order)
