"""Effects that show only together, and effects that stand in another's place.

A loose sensor on an axle with friction, for one: the mount magnifies what friction excites, and
neither explains anything alone. Nor does any of four while wheels leave the ground at moments that
only all of them foresee. Where no single effect holds and something is left, the most promising
ones are therefore taken for granted one after the other, and the rest of the library screened
beside each; from the best pair on, effects are added until nothing is left.

Effects are accepted one after the other, and the first may have been taken for what only two
together explain. When nothing more can be added, each is therefore taken out again and the whole
library tried in its place, so that the order of acceptance does not decide the outcome.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import comb, inf, isfinite

from wheelhop.diagnose.confirm.in_full import (
    CONFIRMED,
    SEEN,
    confirm,
    in_other_forms,
    least_gain,
    least_misfit,
    refit,
    without,
    worth_simulating,
)
from wheelhop.diagnose.confirm.starts import other_forms
from wheelhop.diagnose.confirm.validate import Incumbent
from wheelhop.diagnose.score import (
    HOPELESS,
    NEARLY_ALL,
    Rung,
    all_noise,
    at_noise,
    best_first,
    holds_against,
    lead,
    log_odds,
    nearly_all,
    of_a_law,
    power,
    worth_seeking,
)
from wheelhop.diagnose.screen.first_order import Screened, screen_best
from wheelhop.diagnose.search.look import contradicted, judged, step_of
from wheelhop.diagnose.search.scored import (
    BASELINE,
    Candidate,
    Scored,
    Search,
    ids_of,
    with_derivatives,
)
from wheelhop.effects import Effect

FIRSTS = 5
"""So many effects are taken for granted."""

PAIRS = 3
"""So many pairs, the most promising ones, are simulated in full."""


def look_for_several(search: Search, scored: Scored) -> Rung | None:
    """The model with a group of effects that together explain what no single one does, at most as
    many as the model may have. None if there is none, or if the group would contain a set from
    which the ladder has searched before. The result goes into the table."""
    effects, room = _open(search, scored.rung), search.room(scored.rung)
    incumbent, found = Incumbent(search.workshop, scored.rung), tuple[Candidate, ...]()
    rung = _best_pair(search, scored, effects)
    while rung is not None and not (found := _group(incumbent, scored, rung, len(effects))):
        more = len(rung.model.effects) - len(scored.rung.model.effects) < room
        rung = _grown(search, rung, effects) if more else None
    search.table[ids_of(scored.rung)] = replace(scored, together=found)
    return rung


def _open(search: Search, rung: Rung) -> list[Effect]:
    """The effects of which a group may hold beside what a rung has: not another law of the struts
    where all that is left is no more than what its own may leave."""
    settled = of_a_law(power(rung) - search.workshop.noise**2, rung.by_laws)
    return [e for e in search.effects.values() if not (settled and e.on_rig)]


def _best_pair(search: Search, scored: Scored, effects: Sequence[Effect]) -> Rung | None:
    found: list[Rung] = []
    for first, second in _promising(search, scored, effects):
        beside = search.table.get(ids_of(first.rung))
        if known := beside and beside.candidate(second.id):
            found.append(known.rung)
            continue
        search.progress(f"simulating {' with '.join(sorted((first.id, second.id)))}")
        found.append(confirm(Incumbent(search.workshop, first.rung), second, tuple(found)))
    return _fitted(search, found)


def _promising(
    search: Search, scored: Scored, effects: Sequence[Effect]
) -> Iterator[tuple[Candidate, Screened]]:
    """The pairs with the smallest residual by screening, each once. Where the model has no place
    for a third effect, only pairs that could explain nearly all by themselves."""
    base, workshop = scored.rung.fit, search.workshop
    pairs_only = search.room(scored.rung) == 2 and workshop.noise > 0.0
    enough = NEARLY_ALL * (base.cost - base.size) if pairs_only else 0.0
    ids = {effect.id for effect in effects}
    open_to = [c for c in scored.candidates if c.id in ids]
    firsts = [c for c in open_to if c.rung.fit.evidence > base.evidence][:FIRSTS]
    found = []
    for first in firsts:
        least = least_gain(workshop, first.rung)
        gain = base.misfit - least_misfit(base.model, [first.rung.fit])
        found += [
            (first, s)
            for s in _beside(search, scored, first, effects, gain < least)
            if s.score > 0 and s.gain > least and gain + s.gain / SEEN > enough
        ]
    seen = set[frozenset[str]]()
    for first, second in sorted(found, key=lambda pair: pair[1].error):
        pair = frozenset((first.id, second.id))
        if len(seen) < PAIRS and pair not in seen:
            seen.add(pair)
            yield first, second


def _beside(
    search: Search, scored: Scored, first: Candidate, effects: Sequence[Effect], idle: bool
) -> Iterable[Screened]:
    """The rest of the library screened beside an effect. Earlier screening is reused where that
    effect is `idle` in the fitted runs, or where the ladder has searched from this set."""
    present = {first.id, *ids_of(scored.rung)}
    others = [effect for effect in effects if effect.id not in present]
    known = scored if idle else search.table.get(frozenset(present))
    if known is not None and known.looked:
        return [s for s in known.screened if s.variant.effect in others]
    search.progress(f"screening the others beside {first.id}")
    return screen_best(search.workshop, first.rung.fit, others)


def _grown(search: Search, rung: Rung, effects: Sequence[Effect]) -> Rung | None:
    """The group with one more effect, the one that explains most; None if none adds evidence."""
    workshop, present, fitted = search.workshop, ids_of(rung), rung.fit
    group = " and ".join(sorted(present))
    search.progress(f"screening the others beside {group}")
    screened = screen_best(workshop, fitted, [e for e in effects if e.id not in present])
    hope = max((s.gain for s in screened), default=0.0) > worth_seeking(fitted)
    # Where the best is no more than a part, many explain nearly as much: not all are simulated.
    # Where all are next to nothing, only what first order cannot judge is.
    at_least, reach = (CONFIRMED, 1.0) if hope else (0, inf)
    incumbent, found = Incumbent(workshop, rung), list[Rung]()
    for item in worth_simulating(workshop, rung, screened, at_least=at_least, reach=reach):
        search.progress(f"simulating {item.id} with {group}")
        found.append(confirm(incumbent, item, tuple(found)))
    return _fitted(search, [grown for grown in found if grown.fit.evidence > fitted.evidence])


def _fitted(search: Search, found: Sequence[Rung]) -> Rung | None:
    """The model with the most evidence over fitted and held-out runs, fitted with all derivatives.
    None where all simulations diverge, or where the ladder has searched from its effects before.
    The fitted runs alone would favour numbers that are free in each run."""
    stable = [rung for rung in found if isfinite(rung.evidence)]
    rung = max(stable, key=lambda rung: rung.evidence, default=None)
    if rung is None:
        return None
    known = search.table.get(ids_of(rung))
    if known is not None and known.looked:
        return None
    search.progress(f"fitting the vehicle with {' and '.join(sorted(ids_of(rung)))}")
    return search.best(refit(search.workshop, rung))


def _group(incumbent: Incumbent, scored: Scored, rung: Rung, library: int) -> tuple[Candidate, ...]:
    """The effects that a rung has in addition, each with the others beside it; empty if they do not
    hold. By chance two wrong effects of a whole library explain more than one does: a pair must
    explain nearly all of the residual, a larger group all of it."""
    noise, present = incumbent.workshop.noise, ids_of(scored.rung)
    members = [effect for effect in rung.model.effects if effect.id not in present]
    base, tried = incumbent.against(rung), comb(library, len(members))
    odds = log_odds(base, rung, noise)
    if len(members) > 2:
        enough = at_noise(rung, noise)
    else:
        enough = noise == 0.0 or nearly_all(base, rung, noise)
    holds = enough and holds_against(base, rung, odds, tried, noise)
    if not holds or any(contradicted(rung, effect) for effect in members):
        return ()
    # What screening said of an effect by itself is what the ranking shows.
    alone, ids = {item.id: item for item in scored.screened}, [effect.id for effect in members]
    return tuple(
        Candidate(alone[one], rung, odds, tried, True, ", ".join(i for i in ids if i != one))
        for one in ids
    )


def without_idle(search: Search, rung: Rung) -> Rung:
    """Drop effects that are no longer needed beside the last one, and the last one itself if it
    only helped the others' fit out of a local minimum. Drop laws of the struts that explain no more
    than another law may leave.

    The models without one of the effects go into the table, except where a quick fit shows that a
    full one would be hopeless.
    """
    workshop, baseline = search.workshop, search.table[BASELINE].rung
    if len(rung.model.effects) < 2:
        alone = any(effect.on_rig for effect in rung.model.effects)
        return replace(rung, by_laws=power(baseline) - power(rung) if alone else 0.0)
    missed = dict[str, float]()
    for effect in rung.model.effects:
        search.progress(f"is {effect.id} still needed?")
        roughly = without(workshop, rung, effect.id, quick=True)
        if roughly.error_judging > HOPELESS * rung.error_judging:
            missed[effect.id] = min(power(roughly), power(baseline)) - power(rung)
            continue
        without_it = search.best(without(workshop, rung, effect.id))
        base = Incumbent(workshop, without_it).against(rung)
        odds = log_odds(base, rung, workshop.noise)
        if holds_against(base, rung, odds, 1, workshop.noise):
            missed[effect.id] = power(base) - power(rung)
        else:
            rung = without_it
    laws = {e.id: missed[e.id] for e in rung.model.effects if e.on_rig and e.id in missed}
    by_laws = max(laws.values(), default=0.0)
    for name, dropped in laws.items():
        if of_a_law(dropped, by_laws):
            rung = _without(search, rung, name)
    return replace(rung, by_laws=by_laws)


def in_best_forms(search: Search, rung: Rung) -> Rung:
    """A rung that leaves more than a right model may, each of its effects but the last in the form
    that explains most beside the others: what one of them shows is told better once the others are
    there."""
    for effect in rung.model.effects[:-1]:
        more = step_of(search.workshop, rung).unexplained > 0.0
        if more and other_forms(search.workshop, effect):
            search.progress(f"has {effect.id} another form?")
            rung = search.best(in_other_forms(search.workshop, rung, effect))
    return rung


def _without(search: Search, rung: Rung, effect_id: str) -> Rung:
    """The best known model without one of a rung's effects; if none is known yet, fitted from where
    the rung stands."""
    known = search.table.get(ids_of(rung) - {effect_id})
    if known is None:
        return search.best(without(search.workshop, rung, effect_id))
    return with_derivatives(search.workshop, known.rung)


RIVALS = 2
"""So many effects are simulated in full in the place of each one accepted."""

NEAR = 0.03
"""A rival that leaves only this share more is fitted in full before it is held against the effect
it would stand for."""


def exchange(search: Search, rung: Rung) -> Rung | None:
    """The model with one effect of a rung exchanged for a better one; None if none is better. What
    was tried in place of each effect is kept in the table and not tried again."""
    workshop, present = search.workshop, ids_of(rung)
    incumbent, noise = Incumbent(workshop, rung), workshop.noise
    for accepted in rung.model.effects:
        beside = _tried_in_place(search, rung, accepted)
        rivals = [c.rung for c in beside.candidates if c.id not in present]
        if not rivals:
            continue
        quick = best_first(rivals, noise)[0]
        best = _in_full(search, rung, quick)
        found = [replace(c, rung=best) if c.rung is quick else c for c in beside.candidates]
        search.table[ids_of(beside.rung)] = replace(beside, candidates=tuple(found))
        if incumbent.gives_way_to(best):
            return best
    return None


def _in_full(search: Search, rung: Rung, rival: Rung) -> Rung:
    """A rival, fitted in full where its quick fit comes near the rung's, or where the rung leaves
    more than noise: a quick fit may end far above the minimum. A hopeless fit ends early."""
    if known := search.table.get(ids_of(rival)):
        return known.rung
    noise = search.workshop.noise
    close = best_first([rung, rival], noise)[0] is rival or lead(rung, rival) < NEAR
    if not close and all_noise(rung.fit, noise):
        return rival
    bar = -inf if close else least_misfit(rival.model, [rung.fit])
    fitted = refit(search.workshop, rival, bar)
    return search.best(fitted) if close or fitted.fit.misfit < rung.fit.misfit else fitted


def _tried_in_place(search: Search, rung: Rung, accepted: Effect) -> Scored:
    """A rung's effects without the accepted one, and what was tried in its place; if nothing was,
    the most promising effects by screening are tried now."""
    present = ids_of(rung)
    known = search.table.get(present - {accepted.id})
    if known is not None and (known.looked or known.candidates):
        return known
    workshop, library = search.workshop, search.effects
    search.progress(f"could another effect stand for {accepted.id}?")
    base = _without(search, rung, accepted.id)
    bare = Incumbent(workshop, base)
    absent = [effect for name, effect in library.items() if name not in present]
    screened = screen_best(workshop, base.fit, [library[accepted.id], *absent])
    settled = nearly_all(base, rung, workshop.noise)
    # What leaves far more than the effect itself, both to first order, could not stand for it.
    own = next((s.error for s in screened if s.id == accepted.id), inf)
    near = [s for s in screened if s.id != accepted.id and s.error < HOPELESS * own]
    items = worth_simulating(workshop, base, near, at_least=RIVALS, reach=1.0, settled=settled)
    found = [(item, confirm(bare, item, beside=[rung])) for item in items]
    found += [(item, rung) for item in screened if item.id == accepted.id]
    candidates = (judged(bare, item, other, len(screened)) for item, other in found)
    scored = Scored(base, tuple(screened), tuple(candidates))
    search.table[ids_of(base)] = scored
    return scored
