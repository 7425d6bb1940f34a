"""The ladder: accept the effect that explains most, make it part of the model, look again.

Effects that the user names are added one after the other, whatever the judgement on them would be.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from wheelhop.campaign import Campaign, CampaignError
from wheelhop.diagnose.baseline import Baseline, Progress, axle_driven, fit_baseline
from wheelhop.diagnose.confirm.in_full import confirm, refit
from wheelhop.diagnose.confirm.validate import Incumbent
from wheelhop.diagnose.diagnosis import Diagnosis, Step
from wheelhop.diagnose.score import Rung, holds_against, log_odds, nearly_all, of_a_law, power
from wheelhop.diagnose.screen.first_order import screen
from wheelhop.diagnose.search.forgets import (
    FORGETS,
    beginning_allowed_for,
    never_forgotten,
    remaining,
    without_runs,
)
from wheelhop.diagnose.search.look import (
    Look,
    Watch,
    look_at,
    on_one_floor,
    reached,
    step_of,
    steps_of,
    with_step,
)
from wheelhop.diagnose.search.together import Stand, exchange, look_for_several, without_idle
from wheelhop.diagnose.verdict.conclude import conclude
from wheelhop.diagnose.verdict.critic import criticism, refuted, upheld
from wheelhop.diagnose.verdict.ranking import why_not
from wheelhop.effects import Effect, Place, beliefs
from wheelhop.fit import Workshop
from wheelhop.gate import Gated, gate
from wheelhop.identify import linearity
from wheelhop.vehicle import CORNERS, Vehicle, wheels

BETWEEN: tuple[Place, ...] = ("suspension", "body")
"""Places between the measured axles and the sensors on the body."""


def diagnose(
    campaign: Campaign,
    vehicle: Vehicle,
    effects: Mapping[str, Effect],
    *,
    max_effects: int = 4,
    jobs: int | None = None,
    progress: Progress = lambda text: None,
) -> Diagnosis:
    """Which physics the nominal vehicle lacks to explain a campaign.

    Parameters
    ----------
    campaign, vehicle
        Records and nominal vehicle.
    effects
        The library: effects by id. What the campaign believes of tracks and sensors competes with
        them (`beliefs`).
    max_effects
        The ladder has at most this many rungs above the baseline.
    jobs
        Threads; all processors by default.
    progress
        Called with a line of text at every stage.

    Raises
    ------
    CampaignError
        The campaign does not hold what a comparison needs.
    """
    gated = gate(campaign, vehicle)
    return diagnose_gated(
        gated, vehicle, effects, max_effects=max_effects, jobs=jobs, progress=progress
    )[1]


def diagnose_gated(
    gated: Gated,
    vehicle: Vehicle,
    effects: Mapping[str, Effect],
    *,
    max_effects: int = 4,
    jobs: int | None = None,
    progress: Progress = lambda text: None,
) -> tuple[Gated, Diagnosis]:
    """The same of what the gate let through, and what of that was diagnosed: runs that do not
    forget how they began are left out as soon as a model says so, and all begins anew."""
    base = fit_baseline(gated.campaign, vehicle, jobs=jobs, progress=progress)
    found = diagnose_from(gated, vehicle, base, effects, max_effects=max_effects, progress=progress)
    bounced = [f for f in found.findings if f.kind == FORGETS and f not in gated.findings]
    if not bounced or not remaining(gated.campaign, bounced):
        return gated, found
    progress(f"once more without {', '.join(f.about for f in bounced)}")
    return diagnose_gated(
        without_runs(gated, bounced),
        vehicle,
        effects,
        max_effects=max_effects,
        jobs=jobs,
        progress=progress,
    )


def diagnose_from(
    gated: Gated,
    vehicle: Vehicle,
    base: Baseline,
    effects: Mapping[str, Effect],
    *,
    max_effects: int = 4,
    progress: Progress = lambda text: None,
    watch: Watch = lambda look: None,
) -> Diagnosis:
    """The same from what the gate let through and a baseline that was fitted to it.

    ``watch`` is called with every look at a residual as it stands, whenever it knows more: after
    screening, and after each effect that was simulated in full.
    """
    effects = {**effects, **beliefs(gated.campaign, vehicle)}
    diagnosis = climb(base, effects, max_effects=max_effects, progress=progress, watch=watch)
    bounced = never_forgotten(base.workshop, diagnosis.ladder[-1].rung)
    said = upheld(gated.findings, diagnosis, base.workshop.noise)
    findings = *said, *bounced, *criticism(diagnosis)
    diagnosis = replace(diagnosis, findings=findings, beliefs=tuple(refuted(diagnosis)))
    last = diagnosis.ladder[-1]
    between = any(e.place in BETWEEN for e in last.rung.model.effects) or last.above_floor
    whole = len(wheels(vehicle.values)) == len(CORNERS)
    if not between or not whole or axle_driven(gated.campaign, vehicle) is None:
        return diagnosis
    progress("asking whether what lies between axle and body is linear")
    return replace(diagnosis, axle_to_body=linearity(gated.campaign, vehicle))


def climb(
    base: Baseline,
    effects: Mapping[str, Effect],
    *,
    max_effects: int,
    progress: Progress,
    watch: Watch = lambda look: None,
) -> Diagnosis:
    """The diagnosis, from a fitted baseline on."""
    workshop, rung = base.workshop, base.rung
    steps = [step_of(workshop, rung)]
    look = look_at(workshop, steps[0], effects, max_effects, progress, watch)
    first = origin = look
    tried = [look.remembered()]
    alone = look.chosen is not None
    shorter: Mapping[str, Rung] = {}
    stands: Mapping[str, Stand] = {}
    most = max_effects
    for _ in range(2 * max_effects):
        room = most - len(rung.model.effects)
        better = look.chosen.rung if look.chosen is not None and room > 0 else None
        if better is None and len(rung.model.effects) > 1:
            exchanged = exchange(workshop, rung, shorter, tried, effects, progress)
            stands, better = exchanged.stands, exchanged.rung
        part = max_effects > 1 and not nearly_all(first.rung, rung, workshop.noise)
        if better is None and alone and part and steps[-1].above_floor:
            # The first may have been taken for what only several explain: it takes a place.
            alone = False
            visited = [frozenset(e.id for e in k.rung.model.effects) for k in tried]
            anew = look_for_several(
                workshop, first, effects, max_effects, progress, visited, last=look
            )
            group = anew.chosen.rung if anew.chosen is not None else rung
            if anew is not first and Incumbent(workshop, rung).gives_way_to(group):
                origin, better, steps = anew, group, steps[:1]
        if better is None and room > 1 and steps[-1].above_floor:
            look = look_for_several(workshop, look, _open(rung, effects, workshop), room, progress)
            first = origin = look if len(steps) == 1 else first
            better = look.chosen.rung if look.chosen is not None else None
        if better is None:
            break
        look = tried[-1]  # the same, in less memory
        (rung, shorter), stands = without_idle(workshop, better, steps[0].rung, progress), {}
        # If a group comes down to what was chosen first, the first look said how that stands alone.
        if first.chosen is None or [e.id for e in rung.model.effects] != [first.chosen.id]:
            first = origin
        if len(rung.model.effects) == 1:
            first = reached(workshop, first, rung)
        origin = first
        rung = beginning_allowed_for(workshop, rung)
        step = step_of(workshop, rung, steps[0])
        steps = with_step(steps, step)
        bounced = never_forgotten(workshop, rung)
        if bounced and remaining(workshop.campaign, bounced):  # better begun anew without them
            look = Look(rung, (), (), None)
            break
        then = _came_back(workshop, rung, tried)
        if then is not None:  # nothing more is added
            most, alone = len(rung.model.effects), False
            look = replace(then, rung=rung, candidates=(), chosen=None)
        else:
            room = most - len(rung.model.effects)
            look = look_at(workshop, step, effects, room, progress, watch)
        tried.append(look.remembered())
    return conclude(
        workshop, on_one_floor(workshop, steps), first, look, stands, list(effects.values())
    )


def _came_back(workshop: Workshop, rung: Rung, looks: Sequence[Look]) -> Look | None:
    """The look of when the ladder stood on these effects before, and no worse: all that a group
    added is not needed, one by one. Another look would find the same group."""
    names, noise = {e.id for e in rung.model.effects}, workshop.noise
    for look in looks:
        if {e.id for e in look.rung.model.effects} == names:
            base = Incumbent(workshop, look.rung).against(rung)
            if not holds_against(base, rung, log_odds(base, rung, noise), 1, noise):
                return look
    return None


def _open(rung: Rung, effects: Mapping[str, Effect], workshop: Workshop) -> dict[str, Effect]:
    """The effects of which a group may hold beside what a rung has: not another law of the struts
    where all that is left is no more than what its own may leave."""
    settled = of_a_law(power(rung) - workshop.noise**2, rung.by_laws)
    return {name: e for name, e in effects.items() if not (settled and e.on_rig)}


def fit_with(base: Baseline, effects: Sequence[Effect], progress: Progress) -> list[Rung]:
    """The ladder from the fitted baseline through `effects`, in the order given.

    Raises
    ------
    CampaignError
        An effect does not apply to this campaign.
    """
    rungs = [base.rung]
    for effect in effects:
        rungs.append(one_more(base.workshop, rungs[-1], effect, progress))
    return rungs


def one_more(workshop: Workshop, rung: Rung, effect: Effect, progress: Progress) -> Rung:
    """The model of `rung` with one more effect, started from what screening suggests and refitted
    in full.

    Raises
    ------
    CampaignError
        The effect does not apply to this campaign.
    """
    if not rung.fit.has_derivatives:  # of a ladder that went on from there
        rung = refit(workshop, rung)
    progress(f"screening {effect.id}")
    screened = screen(workshop, rung.fit, [effect])
    if not screened:
        where = workshop.campaign.folder / "campaign.toml"
        reason = why_not(effect, workshop.drives)
        raise CampaignError(f"{where}: {effect.id} cannot be added: {reason}; leave it out")
    progress(f"simulating {effect.id}")
    rough = confirm(Incumbent(workshop, rung), screened[0])
    progress(f"fitting the vehicle with {effect.id}")
    return refit(workshop, rough)


def steps_with(
    campaign: Campaign,
    vehicle: Vehicle,
    effects: Sequence[Effect],
    progress: Progress,
    known: Mapping[str, float] = MappingProxyType({}),
    jobs: int | None = None,
) -> list[Step]:
    """The same from the campaign on, each rung compared with the records; the baseline's fit begins
    at what is `known`.

    Raises
    ------
    CampaignError
        The campaign does not hold what a comparison needs, or an effect does not apply to it.
    """
    base = fit_baseline(campaign, vehicle, jobs=jobs, progress=progress, known=known)
    return steps_of(base.workshop, fit_with(base, effects, progress))
