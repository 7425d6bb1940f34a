"""A look at a residual: screen all effects, simulate the best in full, choose one or none. And the
rungs of the ladder that looks lead up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import hypot, inf

from wheelhop.compare import Floor
from wheelhop.diagnose.baseline import comparison_of
from wheelhop.diagnose.confirm.in_full import (
    best_form,
    confirm,
    confirm_strong,
    least_misfit,
    refit,
    worth_simulating,
)
from wheelhop.diagnose.confirm.starts import Start, strong
from wheelhop.diagnose.confirm.validate import Incumbent
from wheelhop.diagnose.diagnosis import Step
from wheelhop.diagnose.score import (
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
from wheelhop.diagnose.screen.first_order import Screened, screen
from wheelhop.diagnose.search.scored import BASELINE, Candidate, Scored, Search, ids_of, remembered
from wheelhop.effects import Effect, OwnValues, RandomHeights, TiedRuns
from wheelhop.files import Progress
from wheelhop.files.words import percent
from wheelhop.fit import Workshop

LAST_RESORT = 3
"""Where none holds and something is left, so many effects, those that the fitted runs favour, are
fitted in full; so many more are simulated for that where there is none in the model yet."""


def step_of(workshop: Workshop, rung: Rung, baseline: Step | None = None) -> Step:
    """A rung with its parameters and its comparison with the records; `baseline` is the first."""
    names = tuple(effect.id for effect in rung.model.effects)
    lacked = 0.0 if baseline is None else max(baseline.unexplained, 0.0)
    return Step(names, rung, parameters_of(rung), comparison_of(workshop, rung), lacked)


def with_step(steps: Sequence[Step], step: Step) -> list[Step]:
    """The ladder with one more step. A better fit of the same effects replaces their step; steps
    between the baseline and the new one are kept without derivatives."""
    below = [s for s in steps if s.added != step.added]
    return [*(replace(s, rung=remembered(s.rung)) if s.added else s for s in below), step]


def steps_of(workshop: Workshop, rungs: Sequence[Rung]) -> list[Step]:
    """All rungs of a ladder as steps on one floor, the baseline first."""
    return on_one_floor(workshop, [step_of(workshop, rung) for rung in rungs])


def on_one_floor(
    workshop: Workshop, steps: Sequence[Step], floor: Floor | None = None
) -> list[Step]:
    """The steps of a ladder compared with one noise floor. Of those estimated from the quietest
    parts of a residual the least of all steps is used, unless something tells a better one."""
    least = min((step.comparison.floor for step in steps), key=lambda one: one.error)
    told, floor = floor is not None, floor or least
    comparisons = [step.comparison for step in steps]
    if told or not floor.is_stated:
        comparisons = [comparison_of(workshop, step.rung, floor=floor) for step in steps]
    baseline, *others = map(lambda s, c: replace(s, comparison=c), steps, comparisons)
    lacked = max(baseline.unexplained, 0.0)
    return [baseline, *(replace(step, lacked=lacked) for step in others)]


def parameters_of(rung: Rung) -> dict[str, tuple[float, float]]:
    """Every fitted number, and relation of them that was measured, and its standard deviation;
    switches, and numbers that stand for what is free in each run, have none (NaN)."""
    values, fitted = rung.model.values, rung.fit
    found = {f.name: (values[f.name], fitted.uncertainty(f.name)) for f in fitted.shared}
    found |= fitted.relations
    for effect in rung.model.effects:
        fixed = rung.model.theta(effect) | summary_of(rung, effect)
        for name, value in fixed.items():
            found.setdefault(f"{effect.id}.{name}", (value, float("nan")))
    return found


def beside_other_laws(step: Step, scored: Scored) -> Step:
    """The step, its intervals as wide as what else was tried makes of each number.

    An effect that makes the runs fitted and those held out likelier, and yet does not hold, is one
    way to account for what the model is wrong by. Each number then varies by as much as the effect
    that moves it furthest would move it.
    """
    rung = step.rung
    others = [
        c.rung.model.values
        for c in scored.candidates
        if scored.rung is rung
        and c.rung.evidence > rung.evidence
        and c.rung.error_judging < rung.error_judging
    ]
    believed = rung.fit.believed_deviations

    def wider(name: str, value: float, sd: float) -> float:
        furthest = max((abs(o.get(name, value) - value) for o in others), default=0.0)
        return min(hypot(sd, furthest), believed.get(name, inf)) if furthest else sd

    parameters = {name: (v, wider(name, v, sd)) for name, (v, sd) in step.parameters.items()}
    return replace(step, parameters=parameters)


def summary_of(rung: Rung, effect: Effect) -> dict[str, float]:
    """Numbers that stand for what an effect leaves free per run."""
    return effect.summary(_run_by_run(rung, effect))


def contradicted(rung: Rung, effect: Effect) -> bool:
    """Whether what an effect leaves free per run came out against its nature."""
    return isinstance(effect, TiedRuns) and effect.contradicted(_run_by_run(rung, effect))


def _run_by_run(rung: Rung, effect: Effect) -> list[OwnValues]:
    found, prefix = [], f"{effect.id}."
    for run in rung.fit.runs:
        if run.bench.simulator.acts(effect):
            theta = {**rung.model.values, **rung.model.theta(effect, run.bench.run.id)}
            own = run.uncertainties(rung.fit.sigma)
            known_to = {k.removeprefix(prefix): v for k, v in own.items() if k.startswith(prefix)}
            found.append(OwnValues(run.bench.simulator.setting, theta, known_to))
    return found


def look_at(search: Search, step: Step) -> Scored:
    """Screen the effects that are not in the model, simulate the most promising ones in full, and
    choose one or none. Where the model may have no more effects, only screen."""
    found = search.table[ids_of(step.rung)] = _looked(search, step)
    return found


def _looked(search: Search, step: Step) -> Scored:
    rung, workshop = step.rung, search.workshop
    done = bool(rung.model.effects) and not noticeable(rung, workshop.noise)
    if done and not step.above_floor:
        return Scored(rung, looked=True)
    present = ids_of(rung)
    left = [effect for effect in search.effects.values() if effect.id not in present]
    search.progress(f"screening {len(left)} effects")
    scored = Scored(rung, tuple(screen(workshop, rung.fit, left)))
    if done or (present and len(present) >= search.max_effects):  # described, not explained
        return replace(scored, looked=True)
    search.told(scored)
    incumbent = Incumbent(workshop, rung)
    candidates = _confirm_best(search, incumbent, scored, step.above_floor)
    candidates = _refit_leaders(incumbent, candidates, step.above_floor, search.progress)
    chosen = next((c for c in candidates if c.holds), None)
    scored = replace(scored, candidates=tuple(candidates), chosen=chosen, looked=True)
    search.told(scored)
    return scored


def _fall(rung: Rung, leader: Candidate) -> str:
    return f"{leader.id} {percent(rung.error_judging)} → {percent(leader.rung.error_judging)}"


def _confirm_best(
    search: Search, incumbent: Incumbent, scored: Scored, above_floor: bool
) -> list[Candidate]:
    """Full simulation of the most promising effects, the best first. Once one explains nearly all,
    only what screening puts beside it is a rival. Where none holds and the baseline leaves
    something, a few more are simulated that first order, a tangent, thinks little of; where none of
    these does, a few that may be too strong for it. What a law of the right name leaves of another
    form is no reason for that."""
    workshop, rung, screened = incumbent.workshop, incumbent.rung, scored.screened

    def enough(found: Rung) -> bool:
        return at_noise(found, workshop.noise) or nearly_all(rung, found, workshop.noise)

    chosen = worth_simulating(workshop, rung, screened)
    rivals = worth_simulating(workshop, rung, screened, at_least=1, settled=True)
    found: list[Candidate] = []

    def simulate(item: Screened, which: str, start: Start | None = None) -> None:
        leader = next((c for c in _best_first(found, workshop.noise) if c.holds), None)
        so_far = "" if leader is None else f"; {_fall(rung, leader)} so far"
        said, beside = f"simulating {item.id} ({which}){so_far}", [c.rung for c in found]
        search.progress(said)
        if start is None:
            tell = search.progress
            confirmed = confirm(incumbent, item, beside, lambda one: tell(f"{said}, {one.why}"))
        else:
            confirmed = confirm_strong(incumbent, start, beside)
        new = judged(incumbent, item, confirmed, len(screened))
        likelier = [c for c in found if c.id == new.id and c.rung.evidence > new.rung.evidence]
        found[:] = [c for c in found if c.id != new.id] + (likelier or [new])
        search.told(replace(scored, candidates=tuple(_best_first(found, workshop.noise))))

    for i, item in enumerate(chosen):
        if item in rivals or not any(c.holds and enough(c.rung) for c in found):
            simulate(item, f"{i + 1} of {len(chosen)}")
    if above_floor and not rung.model.effects and not any(c.holds for c in found):
        more = [s for s in screened if s not in chosen and s.score > 0][:LAST_RESORT]
        for i, item in enumerate(more):
            simulate(item, f"{i + 1} of {len(more)} more")
        strongest = [] if any(c.holds for c in found) else strong(incumbent, screened)[:LAST_RESORT]
        for i, (item, start) in enumerate(strongest):
            simulate(item, f"{i + 1} of {len(strongest)} {start.why}", start)
    return _best_first(found, workshop.noise)


def _refit_leaders(
    incumbent: Incumbent, candidates: Sequence[Candidate], above_floor: bool, progress: Progress
) -> list[Candidate]:
    """The candidates, the leaders of them fitted with all derivatives; the best first.

    A quick fit favours effects that resemble what the vehicle's own parameters do, and it may end
    where its derivatives no longer hold: before one is believed, the best two that hold are fitted
    so, too. What a fit that went astray makes of runs held out says nothing of its effect, so where
    much is left the few that make the runs fitted likelier than these two are fitted as well; if
    none holds, as far as there is hope that they take a part of it that is worth it.
    """
    workshop, rung = incumbent.workshop, incumbent.rung
    holding = [c for c in candidates if c.holds][:2]
    likeliest = max((c.rung.fit.evidence for c in holding), default=-inf)
    astray = [c for c in candidates if not c.holds and c.rung.fit.evidence > likeliest]
    astray = sorted(astray, key=lambda c: -c.rung.fit.evidence)[:LAST_RESORT]
    leaders = [*holding, *astray] if above_floor else holding
    refitted: list[Candidate] = []
    for leader in leaders:
        ahead = next((c.rung for c in refitted if c.holds), None)
        if ahead and leader.rung.fit.error > HOPELESS * ahead.fit.error:
            refitted.append(leader)
            continue
        progress(f"fitting the vehicle with {leader.id}")
        if ahead or holding:
            beat = least_misfit(leader.rung.fit.model, [ahead.fit] if ahead else [])
        else:
            beat = least_misfit(leader.rung.fit.model, [rung.fit]) - worth_seeking(rung.fit)
        better = refit(workshop, leader.rung, beat)
        worth = leader.holds or better.fit.misfit < beat
        leads = not ahead or best_first([ahead, better], workshop.noise)[0] is better
        if worth and leads and not at_noise(better, workshop.noise):
            better = best_form(incumbent, leader.screened, better)
        refitted.append(judged(incumbent, leader.screened, better, leader.tried))
    others = [c for c in candidates if c.id not in {leader.id for leader in leaders}]
    return _best_first(refitted, workshop.noise) + others


def _best_first(candidates: Sequence[Candidate], noise: float) -> list[Candidate]:
    """Candidates that hold first, each part ordered by `best_first`."""
    place = {id(rung): i for i, rung in enumerate(best_first([c.rung for c in candidates], noise))}
    return sorted(candidates, key=lambda c: (not c.holds, place[id(c.rung)]))


def judged(incumbent: Incumbent, screened: Screened, rival: Rung, tried: int) -> Candidate:
    """The effect that a rival has and the incumbent has not, one of so many tried."""
    base, noise = incumbent.against(rival), incumbent.workshop.noise
    odds = log_odds(base, rival, noise)
    effect, dropped = screened.variant.effect, power(base) - power(rival)
    of_the_first = effect.on_rig and of_a_law(dropped, base.by_laws)
    if not screened.variant.parameters or isinstance(effect, RandomHeights):
        # Free at every second of a run, it takes a part of whatever is left.
        of_the_first = dropped < LAW**2 * base.by_laws
    likely = holds_against(base, rival, odds, tried, noise) and not of_the_first
    return Candidate(screened, rival, odds, tried, likely and not contradicted(rival, effect))


def stood_on_alone(search: Search, rung: Rung) -> None:
    """Beside the baseline, the single effect that the ladder has come to is what was fitted last:
    the way to its minimum may have led over another effect, which in the end is not needed."""
    (effect,), origin = rung.model.effects, search.table[BASELINE]
    then = origin.candidate(effect.id)
    item = next((s for s in origin.screened if s.id == effect.id), None)
    if item is None:
        return
    if then is None or then.rung.fit is not rung.fit:
        incumbent = Incumbent(search.workshop, origin.rung)
        then = judged(incumbent, item, rung, len(origin.screened))
    others = (c for c in origin.candidates if c.id != effect.id)
    together = origin.together and ()
    search.table[BASELINE] = replace(
        origin, candidates=(then, *others), chosen=then, together=together
    )
