"""The ladder: accept the effect that explains most, make it part of the model, look again.

Effects that the user names are added one after the other, whatever the judgement on them would be.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import inf
from types import MappingProxyType

from wheelhop.campaign import Campaign, CampaignError
from wheelhop.diagnose.baseline import Baseline, Progress, axle_driven, fit_baseline
from wheelhop.diagnose.confirm import confirm, least_cost, refit, worth_simulating
from wheelhop.diagnose.critic import criticism, refuted, upheld
from wheelhop.diagnose.diagnosis import Diagnosis, Step
from wheelhop.diagnose.forgets import (
    FORGETS,
    beginning_allowed_for,
    never_forgotten,
    remaining,
    without_runs,
)
from wheelhop.diagnose.forms import best_form
from wheelhop.diagnose.judge import (
    HOPELESS,
    LAW,
    Rung,
    at_noise,
    best_first,
    holds_against,
    log_odds,
    nearly_all,
    noticeable,
    of_a_law,
    power,
    worth_seeking,
)
from wheelhop.diagnose.look import (
    Candidate,
    Look,
    contradicted,
    on_one_floor,
    step_of,
    steps_of,
    with_step,
)
from wheelhop.diagnose.ranking import why_not
from wheelhop.diagnose.screen import Screened, screen
from wheelhop.diagnose.together import Stand, exchange, look_for_several, without_idle
from wheelhop.diagnose.validate import Incumbent
from wheelhop.diagnose.verdict import conclude
from wheelhop.effects import Effect, Place, beliefs
from wheelhop.fit import Workshop
from wheelhop.gate import Gated, gate
from wheelhop.identify import linearity
from wheelhop.vehicle import CORNERS, Vehicle, wheels

BETWEEN: tuple[Place, ...] = ("suspension", "body")
"""Places between the measured axles and the sensors on the body."""

Watch = Callable[[Look], None]

LAST_RESORT = 3
"""Where none holds and something is left, so many effects, those that the fitted runs favour, are
fitted in full; so many more are simulated for that where there is none in the model yet."""


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
    look = _look(workshop, steps[0], effects, max_effects, progress, watch)
    first = origin = look
    tried = [look.remembered()]
    alone = look.chosen is not None
    shorter: Mapping[str, Rung] = {}
    stands: Mapping[str, Stand] = {}
    for _ in range(2 * max_effects):
        room = max_effects - len(rung.model.effects)
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
        origin = first
        rung = beginning_allowed_for(workshop, rung)
        step = step_of(workshop, rung, steps[0])
        steps = with_step(steps, step)
        bounced = never_forgotten(workshop, rung)
        if bounced and remaining(workshop.campaign, bounced):  # better begun anew without them
            look = Look(rung, (), (), None)
            break
        room = max_effects - len(rung.model.effects)
        look = _look(workshop, step, effects, room, progress, watch)
        tried.append(look.remembered())
    return conclude(
        workshop, on_one_floor(workshop, steps), first, look, stands, list(effects.values())
    )


def _open(rung: Rung, effects: Mapping[str, Effect], workshop: Workshop) -> dict[str, Effect]:
    """The effects of which a group may hold beside what a rung has: not another law of the struts
    where all that is left is no more than what its own may leave."""
    settled = of_a_law(power(rung) - workshop.noise**2, rung.by_laws)
    return {name: e for name, e in effects.items() if not (settled and e.on_rig)}


def _look(
    workshop: Workshop,
    step: Step,
    effects: Mapping[str, Effect],
    room: int,
    progress: Progress,
    watch: Watch,
) -> Look:
    """Screen what is not in the model yet, simulate the best in full, choose one or none. Nothing
    is simulated where the model has no room for more."""
    rung = step.rung
    done = bool(rung.model.effects) and not noticeable(rung, workshop.noise)
    if done and not step.above_floor:
        return Look(rung, (), (), None)
    present = {effect.id for effect in rung.model.effects}
    left = [effect for effect in effects.values() if effect.id not in present]
    progress(f"screening {len(left)} effects")
    screened = screen(workshop, rung.fit, left)
    if done or (rung.model.effects and not room):  # to be described, not explained
        return Look(rung, tuple(screened), (), None)
    incumbent = Incumbent(workshop, rung)
    watch(Look(rung, tuple(screened), (), None))
    candidates = _confirm_best(incumbent, screened, step.above_floor, progress, watch)
    candidates = _refit_leaders(incumbent, candidates, step.above_floor, progress)
    chosen = next((c for c in candidates if c.holds), None)
    look = Look(rung, tuple(screened), tuple(candidates), chosen)
    watch(look)
    return look


def _confirm_best(
    incumbent: Incumbent,
    screened: Sequence[Screened],
    above_floor: bool,
    progress: Progress,
    watch: Watch,
) -> list[Candidate]:
    """Full simulation of the most promising effects, the best first. Once one explains nearly all,
    only what screening puts beside it is a rival. Where none holds and the baseline leaves
    something, a few more are simulated that first order thinks little of: of play it may see a
    seventieth. What a law of the right name leaves of another form is no reason for that."""
    workshop, rung = incumbent.workshop, incumbent.rung

    def enough(found: Rung) -> bool:
        return at_noise(found, workshop.noise) or nearly_all(rung, found, workshop.noise)

    chosen = worth_simulating(workshop, rung, screened)
    rivals = worth_simulating(workshop, rung, screened, at_least=1, settled=True)
    found: list[Candidate] = []

    def simulate(item: Screened, which: str) -> None:
        progress(f"simulating {item.variant.effect.id} ({which})")
        confirmed = confirm(workshop, rung, item, beside=[c.rung for c in found])
        found.append(_judged(incumbent, item, confirmed, len(screened)))
        watch(Look(rung, tuple(screened), tuple(_best_first(found, workshop.noise)), None))

    for i, item in enumerate(chosen):
        if item in rivals or not any(c.holds and enough(c.rung) for c in found):
            simulate(item, f"{i + 1} of {len(chosen)}")
    if above_floor and not rung.model.effects and not any(c.holds for c in found):
        more = [s for s in screened if s not in chosen and s.score > 0][:LAST_RESORT]
        for i, item in enumerate(more):
            simulate(item, f"{i + 1} of {len(more)} more")
    return _best_first(found, workshop.noise)


def _refit_leaders(
    incumbent: Incumbent, candidates: Sequence[Candidate], above_floor: bool, progress: Progress
) -> list[Candidate]:
    """The candidates, the best two that hold fitted with all derivatives; the best first.

    A quick fit favours effects that resemble what the vehicle's own parameters do, and it may end
    where its derivatives no longer hold: before none is believed, the best few are fitted so, too,
    as far as there is hope that they take a part of what is left that is worth it.
    """
    workshop, rung = incumbent.workshop, incumbent.rung
    leaders, bar = [c for c in candidates if c.holds][:2], -inf
    if not leaders and above_floor:
        # What a fit that went astray makes of runs held out says nothing of the effect.
        leaders = sorted(candidates, key=lambda c: -c.rung.fit.evidence)[:LAST_RESORT]
        bar = rung.fit.cost - worth_seeking(rung.fit)
    refitted: list[Candidate] = []
    for leader in leaders:
        ahead = next((c.rung for c in refitted if c.holds), None)
        if ahead and leader.rung.error_judging > HOPELESS * ahead.error_judging:
            refitted.append(leader)
            continue
        progress(f"fitting the vehicle with {leader.id}")
        better = refit(workshop, leader.rung, least_cost([ahead]) if ahead else bar)
        worth = leader.holds or better.fit.cost < bar
        leads = not ahead or best_first([ahead, better], workshop.noise)[0] is better
        if worth and leads and not at_noise(better, workshop.noise):
            better = best_form(workshop, rung, leader.screened, better)
        refitted.append(_judged(incumbent, leader.screened, better, leader.tried))
    others = [c for c in candidates if c.id not in {leader.id for leader in leaders}]
    return _best_first(refitted, workshop.noise) + others


def _best_first(candidates: Sequence[Candidate], noise: float) -> list[Candidate]:
    """Those that hold before the others."""
    place = {id(rung): i for i, rung in enumerate(best_first([c.rung for c in candidates], noise))}
    return sorted(candidates, key=lambda c: (not c.holds, place[id(c.rung)]))


def _judged(incumbent: Incumbent, screened: Screened, rival: Rung, tried: int) -> Candidate:
    base, noise = incumbent.against(rival), incumbent.workshop.noise
    odds = log_odds(base, rival, noise)
    effect, dropped = screened.variant.effect, power(base) - power(rival)
    of_the_first = effect.on_rig and of_a_law(dropped, base.by_laws)
    if not screened.variant.parameters:  # free in every run: it takes part of whatever is left
        of_the_first = dropped < LAW**2 * base.by_laws
    likely = holds_against(base, rival, odds, tried, noise) and not of_the_first
    return Candidate(screened, rival, odds, tried, likely and not contradicted(rival, effect))


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
    rough = confirm(workshop, rung, screened[0])
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
