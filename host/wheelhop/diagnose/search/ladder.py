"""The ladder: accept the effect that explains most, make it part of the model, look again.

Effects that the user names are added one after the other, whatever the judgement on them would be.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf
from types import MappingProxyType

from wheelhop.campaign import Campaign, CampaignError
from wheelhop.compare import Floor
from wheelhop.diagnose.baseline import Baseline, axle_driven, fit_baseline
from wheelhop.diagnose.confirm.in_full import confirm, refit
from wheelhop.diagnose.confirm.validate import Incumbent
from wheelhop.diagnose.diagnosis import Diagnosis, EndedBy, Step
from wheelhop.diagnose.score import Rung, fall, nearly_all
from wheelhop.diagnose.screen.first_order import screen
from wheelhop.diagnose.search.forgets import (
    FORGETS,
    beginning_allowed_for,
    never_forgotten,
    remaining,
    without_runs,
)
from wheelhop.diagnose.search.look import (
    look_at,
    on_one_floor,
    step_of,
    steps_of,
    stood_on_alone,
    with_step,
)
from wheelhop.diagnose.search.scored import (
    BASELINE,
    Beyond,
    Scored,
    Search,
    Watch,
    ids_of,
    with_derivatives,
)
from wheelhop.diagnose.search.together import (
    exchange,
    in_best_forms,
    look_for_several,
    without_idle,
)
from wheelhop.diagnose.verdict.conclude import conclude
from wheelhop.diagnose.verdict.critic import criticism, refuted, upheld
from wheelhop.diagnose.verdict.ranking import why_not
from wheelhop.diagnose.verdict.stability import unstable
from wheelhop.effects import Effect, Place, beliefs
from wheelhop.files import Progress
from wheelhop.fit import OutOfBudget, Workshop
from wheelhop.gate import Gated, gate
from wheelhop.identify import linearity
from wheelhop.vehicle import CORNERS, Vehicle, wheels

SMALL = 0.1
"""A ladder ends where a further rung lowers the error, in logarithms, by less than this share of
what the first one did. A real car is a little wrong in ten ways: to name them all is no help."""

BETWEEN: tuple[Place, ...] = ("suspension", "body")
"""Places between the measured axles and the sensors on the body."""


def own_floor(workshop: Workshop, steps: Sequence[Step]) -> Floor:
    """The floor that a ladder was compared with: nothing is asked beyond its names."""
    return steps[-1].comparison.floor


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
    to_the_end: bool = False,
    budget_s: float | None = None,
    jobs: int | None = None,
    progress: Progress = lambda text: None,
    beyond: Beyond = own_floor,
) -> tuple[Gated, Diagnosis, Baseline]:
    """Diagnose a gated campaign. Runs whose motion depends on how they began are left out as soon
    as a model shows it, and the diagnosis starts again.

    Returns the campaign that was diagnosed, the diagnosis, and the fitted baseline.
    """
    base = fit_baseline(gated.campaign, vehicle, jobs=jobs, progress=progress)
    found = diagnose_from(
        gated,
        vehicle,
        base,
        effects,
        max_effects=max_effects,
        to_the_end=to_the_end,
        budget_s=budget_s,
        progress=progress,
        beyond=beyond,
    )
    bounced = [f for f in found.findings if f.kind == FORGETS and f not in gated.findings]
    if found.unfinished is not None or not bounced or not remaining(gated.campaign, bounced):
        return gated, found, base
    progress(f"once more without {', '.join(f.about for f in bounced)}")
    return diagnose_gated(
        without_runs(gated, bounced),
        vehicle,
        effects,
        max_effects=max_effects,
        to_the_end=to_the_end,
        budget_s=budget_s and budget_s - base.workshop.work.seconds,
        jobs=jobs,
        progress=progress,
        beyond=beyond,
    )


def diagnose_from(
    gated: Gated,
    vehicle: Vehicle,
    base: Baseline,
    effects: Mapping[str, Effect],
    *,
    max_effects: int = 4,
    to_the_end: bool = False,
    budget_s: float | None = None,
    progress: Progress = lambda text: None,
    watch: Watch = lambda scored: None,
    beyond: Beyond = own_floor,
) -> Diagnosis:
    """Diagnose a gated campaign from its fitted baseline.

    ``watch`` is called with the state of the search after screening and after each effect that was
    simulated in full, ``beyond`` asked for the noise floor where the search came to its end. It
    ends with the verdict so far where it has used `budget_s` of work or is interrupted; `progress`
    and `watch` may raise OutOfBudget to end it, too.
    """
    effects = {**effects, **beliefs(gated.campaign, vehicle)}
    diagnosis = climb(
        base,
        effects,
        max_effects=max_effects,
        to_the_end=to_the_end,
        budget_s=budget_s,
        progress=progress,
        watch=watch,
        beyond=beyond,
    )
    bounced = never_forgotten(base.workshop, diagnosis.ladder[-1].rung)
    said = upheld(gated.findings, diagnosis, base.workshop.noise)
    findings = *said, *bounced, *criticism(diagnosis), *unstable(base.workshop.run_away)
    diagnosis = replace(diagnosis, findings=findings, beliefs=tuple(refuted(diagnosis)))
    last = diagnosis.ladder[-1]
    if diagnosis.unfinished is not None:
        return diagnosis
    between = any(e.place in BETWEEN for e in last.rung.model.effects) or last.above_floor
    whole = len(wheels(vehicle.values)) == len(CORNERS)
    if not between or not whole or axle_driven(gated.campaign, vehicle) is None:
        return diagnosis
    try:
        progress("asking whether what lies between axle and body is linear")
        return replace(diagnosis, axle_to_body=linearity(gated.campaign, vehicle))
    except (OutOfBudget, KeyboardInterrupt):
        return diagnosis  # the verdict is there


def climb(
    base: Baseline,
    effects: Mapping[str, Effect],
    *,
    max_effects: int,
    to_the_end: bool = False,
    budget_s: float | None = None,
    progress: Progress,
    watch: Watch = lambda scored: None,
    beyond: Beyond = own_floor,
) -> Diagnosis:
    """The diagnosis, from a fitted baseline on."""
    workshop = base.workshop
    search = Search(workshop, effects, max_effects, progress, watch, to_the_end)
    search.table[BASELINE] = Scored(base.rung)
    steps: Sequence[Step] = [step_of(workshop, base.rung)]
    below = steps
    better: Rung | None = None
    ended_by: EndedBy | None = None
    try:
        with workshop.work.limited(budget_s):
            look_at(search, steps[0])
            for _ in range(2 * max_effects):
                better, below = _better(search, steps)
                if better is None:
                    break
                search.settle()
                rung = without_idle(search, in_best_forms(search, search.best(better)))
                rung = beginning_allowed_for(workshop, rung)
                step = step_of(workshop, rung, steps[0])
                steps, better = with_step(below, step), None
                if not _looked_on(search, steps):
                    break
    except (OutOfBudget, KeyboardInterrupt) as end:
        ended_by = "budget" if isinstance(end, OutOfBudget) else "interrupted"
        # What was found, though nobody has asked yet whether all of it is needed.
        better = better or _best_so_far(search, steps)
        steps = steps if better is None else with_step(below, step_of(workshop, better, steps[0]))
    steps = on_one_floor(workshop, steps)
    if ended_by is None and (floor := beyond(workshop, steps)) is not steps[-1].comparison.floor:
        steps = on_one_floor(workshop, steps, floor)
    return conclude(search, steps, ended_by)


def _looked_on(search: Search, steps: Sequence[Step]) -> bool:
    """Examine the residual of a new rung. False where some runs should be left out and the
    diagnosis started again."""
    workshop, rung = search.workshop, steps[-1].rung
    bounced = never_forgotten(workshop, rung)
    if bounced and remaining(workshop.campaign, bounced):
        search.table[ids_of(rung)] = Scored(rung)
        return False
    if len(rung.model.effects) == 1:
        stood_on_alone(search, rung)
    known = search.table.get(ids_of(rung))
    if known is not None and known.looked:
        # The same set of effects, fitted no better: searching from it again would cycle.
        search.table[ids_of(rung)] = replace(known, rung=rung, chosen=None, together=())
    else:
        look_at(search, steps[-1])
    return True


def _least(search: Search, steps: Sequence[Step]) -> float:
    """The least fall of the error, as `fall`, that justifies a further rung."""
    if search.to_the_end or len(steps) < 2:
        return -inf
    return SMALL * fall(steps[0].rung, steps[1].rung)


def _best_so_far(search: Search, steps: Sequence[Step]) -> Rung | None:
    """The best model with one more effect that holds and lowers the error enough, if any."""
    rung, least = steps[-1].rung, _least(search, steps)
    known = search.table.get(ids_of(rung))
    held = [c.rung for c in known.candidates if c.holds] if known and search.room(rung) else []
    return held[0] if held and fall(rung, held[0]) >= least else None


def _better(search: Search, steps: Sequence[Step]) -> tuple[Rung | None, Sequence[Step]]:
    """The next better model (None if there is none) and the ladder that it continues. Tried in this
    order: one more effect, one effect exchanged for another, several effects at once."""
    rung, workshop = steps[-1].rung, search.workshop
    here, origin = search.table[ids_of(rung)], search.table[BASELINE]
    room, least = search.room(rung), _least(search, steps)

    def worth_it(more: Rung) -> bool:
        return fall(rung, more) >= least

    if here.chosen is not None and room > 0 and worth_it(here.chosen.rung):
        return here.chosen.rung, steps
    better = exchange(search, rung) if len(rung.model.effects) > 1 else None
    if better is not None or not steps[-1].above_floor:
        return better, steps
    part = search.max_effects > 1 and not nearly_all(origin.rung, rung, workshop.noise)
    if here is not origin and origin.together is None and part:
        # The first effect may stand in for a group, and take the place of one of its members.
        group = look_for_several(search, origin)
        if group is not None and Incumbent(workshop, rung).gives_way_to(group):
            return group, steps[:1]
        search.table[BASELINE] = replace(origin, together=())
    if room > 1 and here.together is None and steps[-1].above_expected >= least:
        better = look_for_several(search, here)
    return (better if better is None or worth_it(better) else None), steps


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
    rung = with_derivatives(workshop, rung)  # of a ladder that went on from there
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
    """Fit the baseline of a campaign, begun at the numbers `known`, then add `effects` one by one;
    each rung is compared with the records.

    Raises
    ------
    CampaignError
        The campaign does not hold what a comparison needs, or an effect does not apply to it.
    """
    base = fit_baseline(campaign, vehicle, jobs=jobs, progress=progress, known=known)
    return steps_of(base.workshop, fit_with(base, effects, progress))
