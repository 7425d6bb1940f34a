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

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import comb, inf
from typing import NamedTuple

from wheelhop.diagnose.baseline import Progress
from wheelhop.diagnose.confirm.in_full import (
    CONFIRMED,
    SEEN,
    confirm,
    least_cost,
    least_gain,
    refit,
    without,
    worth_simulating,
)
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
from wheelhop.diagnose.search.look import Candidate, Look, contradicted
from wheelhop.effects import Effect
from wheelhop.fit import Workshop

FIRSTS = 5
"""So many effects are taken for granted."""

PAIRS = 3
"""So many pairs, the most promising ones, are simulated in full."""


class _Group(NamedTuple):
    """Effects as they were screened, each beside those before it, and a model that has them."""

    members: tuple[Screened, ...]
    rung: Rung

    @property
    def ids(self) -> list[str]:
        return sorted(s.variant.effect.id for s in self.members)


def look_for_several(
    workshop: Workshop,
    look: Look,
    effects: Mapping[str, Effect],
    room: int,
    progress: Progress,
    visited: Collection[frozenset[str]] = (),
    last: Look | None = None,
) -> Look:
    """The look at a residual no single effect explains, with a group of effects chosen that does,
    at most `room` of them; as it was if there is none, or the way to it leads over effects that
    were `visited` together: what can be added to these is known. What the `last` look has screened
    is not screened again."""
    group = _best_pair(workshop, look, effects, room, visited, progress, last)
    incumbent = Incumbent(workshop, look.rung)
    while group is not None:
        tried = comb(len(effects), len(group.members))
        base = incumbent.against(group.rung)
        odds = log_odds(base, group.rung, workshop.noise)
        if _holds(workshop, base, group, odds, tried):
            return _chosen(look, group, odds, tried)
        if len(group.members) == room:
            break
        group = _grown(workshop, group, effects, visited, progress)
    return look


def _best_pair(
    workshop: Workshop,
    look: Look,
    effects: Mapping[str, Effect],
    room: int,
    visited: Collection[frozenset[str]],
    progress: Progress,
    last: Look | None,
) -> _Group | None:
    found: list[_Group] = []
    for first, second in _promising(workshop, look, effects, room, progress, last):
        pair = _Group((first.screened, second), first.rung)
        progress(f"simulating {' with '.join(pair.ids)}")
        beside = [group.rung for group in found]
        found.append(pair._replace(rung=confirm(Incumbent(workshop, first.rung), second, beside)))
    return _fitted(workshop, found, visited, progress)


def _promising(
    workshop: Workshop,
    look: Look,
    effects: Mapping[str, Effect],
    room: int,
    progress: Progress,
    last: Look | None = None,
) -> Iterator[tuple[Candidate, Screened]]:
    """The pairs that leave least by screening, each once. Those that have no room for a third, and
    could not explain nearly all by themselves, are left out; not those beside an effect the ladder
    has stood on: a look from there simulates the best few alone, and screening may see a fiftieth
    of the one that matters."""
    base = look.rung.fit
    enough = NEARLY_ALL * (base.cost - base.size) if room == 2 and workshop.noise > 0.0 else 0.0
    open_to = [c for c in look.candidates if c.id in effects]
    firsts = [c for c in open_to if c.rung.fit.evidence > base.evidence][:FIRSTS]
    found = []
    for first in firsts:
        least, gain = least_gain(workshop, first.rung), base.cost - least_cost([first.rung])
        found += [
            (first, s)
            for s in _beside(workshop, look, first, effects, gain < least, progress, last)
            if s.score > 0 and s.gain > least and gain + s.gain / SEEN > enough
        ]
    seen = set[frozenset[str]]()
    for first, second in sorted(found, key=lambda pair: pair[1].error):
        ids = frozenset((first.id, second.variant.effect.id))
        if len(seen) < PAIRS and ids not in seen:
            seen.add(ids)
            yield first, second


def _beside(
    workshop: Workshop,
    look: Look,
    first: Candidate,
    effects: Mapping[str, Effect],
    idle: bool,
    progress: Progress,
    last: Look | None,
) -> Iterable[Screened]:
    """The rest of the library screened beside an effect: as it was screened without where that is
    `idle` in the runs fitted, and as the `last` look has done it if it stood there."""
    present = {first.id, *(effect.id for effect in look.rung.model.effects)}
    others = [effect for name, effect in effects.items() if name not in present]
    if idle:
        return [s for s in look.screened if s.variant.effect in others]
    if last is not None and last.rung.fit is first.rung.fit:
        return [s for s in last.screened if s.variant.effect in others]
    progress(f"screening the others beside {first.id}")
    return screen_best(workshop, first.rung.fit, others)


def _grown(
    workshop: Workshop,
    group: _Group,
    effects: Mapping[str, Effect],
    visited: Collection[frozenset[str]],
    progress: Progress,
) -> _Group | None:
    """The group with the effect that explains most beside it; None where none makes it likelier."""
    present = {effect.id for effect in group.rung.model.effects}
    others = [effect for effect in effects.values() if effect.id not in present]
    progress(f"screening the others beside {' and '.join(group.ids)}")
    screened = screen_best(workshop, group.rung.fit, others)
    fitted = group.rung.fit
    hope = max((s.gain for s in screened), default=0.0) > worth_seeking(fitted)
    incumbent = Incumbent(workshop, group.rung)
    found: list[_Group] = []
    # Where the best is no more than a part, many explain nearly as much: not all are simulated.
    # Where all are next to nothing, only what first order cannot judge is.
    for item in worth_simulating(
        workshop,
        group.rung,
        screened,
        at_least=CONFIRMED if hope else 0,
        reach=1.0 if hope else inf,
    ):
        progress(f"simulating {item.variant.effect.id} with {' and '.join(group.ids)}")
        beside = [grown.rung for grown in found]
        rung = confirm(incumbent, item, beside)
        found.append(_Group((*group.members, item), rung))
    found = [grown for grown in found if grown.rung.fit.evidence > fitted.evidence]
    return _fitted(workshop, found, visited, progress)


def _fitted(
    workshop: Workshop,
    found: Sequence[_Group],
    visited: Collection[frozenset[str]],
    progress: Progress,
) -> _Group | None:
    """The group that is likeliest in the runs fitted and those held out, fitted with all
    derivatives, unless it was `visited`. The runs fitted alone would favour numbers that are free
    in each of them."""
    group = max(found, key=lambda group: group.rung.evidence, default=None)
    if group is None or frozenset(group.ids) in visited:
        return None
    progress(f"fitting the vehicle with {' and '.join(group.ids)}")
    return group._replace(rung=refit(workshop, group.rung))


def _holds(workshop: Workshop, base: Rung, group: _Group, odds: float, tried: int) -> bool:
    """Two wrong effects together explain more by chance than one does: a pair must explain nearly
    all, more than two all of it."""
    rung, noise = group.rung, workshop.noise
    if len(group.members) > 2:
        enough = at_noise(rung, noise)
    else:
        enough = noise == 0.0 or nearly_all(base, rung, noise)
    return (
        enough
        and holds_against(base, rung, odds, tried, noise)
        and not any(contradicted(rung, s.variant.effect) for s in group.members)
    )


def _chosen(look: Look, group: _Group, odds: float, tried: int) -> Look:
    """The look with the group's first effect chosen, and the others held, too."""
    found = []
    for member in group.members:
        others = ", ".join(s.variant.effect.id for s in group.members if s is not member)
        # What screening said of an effect by itself is what the ranking shows.
        name = member.variant.effect.id
        alone = next((s for s in look.screened if s.variant.effect.id == name), member)
        item = replace(member, error=alone.error)
        found.append(Candidate(item, group.rung, odds, tried, True, beside=others))
    rest = [c for c in look.candidates if c.id not in group.ids]
    return replace(look, candidates=(*found, *rest), chosen=found[0])


def without_idle(
    workshop: Workshop, rung: Rung, baseline: Rung, progress: Progress
) -> tuple[Rung, Mapping[str, Rung]]:
    """Drop effects whose contribution vanished when the last one joined, the last one included:
    it may have done no more than help the others' fit out of a side valley. Of the laws of the
    struts drop those that take no more than another may leave.

    Returns the models without one of the effects that stayed, too, as far as they were fitted in
    full: not where a quick fit leaves so much that a full one could not hold.
    """
    shorter: dict[str, Rung] = {}
    if len(rung.model.effects) < 2:
        alone = any(effect.on_rig for effect in rung.model.effects)
        return replace(rung, by_laws=power(baseline) - power(rung) if alone else 0.0), shorter
    missed = dict[str, float]()
    for effect in rung.model.effects:
        progress(f"is {effect.id} still needed?")
        roughly = without(workshop, rung, effect.id, quick=True)
        if roughly.error_judging > HOPELESS * rung.error_judging:
            missed[effect.id] = min(power(roughly), power(baseline)) - power(rung)
            continue
        without_it = without(workshop, rung, effect.id)
        base = Incumbent(workshop, without_it).against(rung)
        odds = log_odds(base, rung, workshop.noise)
        if holds_against(base, rung, odds, 1, workshop.noise):
            shorter[effect.id] = without_it
            missed[effect.id] = power(base) - power(rung)
        else:
            rung, shorter = without_it, {}
    laws = {e.id: missed[e.id] for e in rung.model.effects if e.on_rig and e.id in missed}
    by_laws = max(laws.values(), default=0.0)
    for name, dropped in laws.items():
        if of_a_law(dropped, by_laws):
            rung, shorter = shorter.get(name) or without(workshop, rung, name), {}
    return replace(rung, by_laws=by_laws), shorter


RIVALS = 2
"""So many effects are simulated in full in the place of each one accepted."""

NEAR = 0.03
"""A rival that leaves only this share more is fitted in full before it is held against the effect
it would stand for."""


@dataclass(frozen=True, eq=False)
class Stand:
    """What an accepted effect stands against: the model without it, and the best one with another
    effect in its place (the same, if nothing could stand there)."""

    without: Rung
    rival: Rung


@dataclass(frozen=True, eq=False)
class Exchange:
    """What became of the attempt: ``rung`` with one effect exchanged for a better one, or None;
    ``stands`` of the accepted effects looked at, by id."""

    rung: Rung | None
    stands: Mapping[str, Stand] = field(default_factory=dict)


def exchange(
    workshop: Workshop,
    rung: Rung,
    shorter: Mapping[str, Rung],
    looks: Sequence[Look],
    effects: Mapping[str, Effect],
    progress: Progress,
) -> Exchange:
    """Try the library in the place of each effect of `rung`; `shorter` holds the models fitted
    without one of them, as far as they are known. What one of the `looks` has tried beside the same
    effects is not tried again."""
    present = {effect.id for effect in rung.model.effects}
    absent = [effect for effect in effects.values() if effect.id not in present]
    stands: dict[str, Stand] = {}
    incumbent = Incumbent(workshop, rung)
    for accepted in rung.model.effects:
        others = present - {accepted.id}
        seen = next((k for k in looks if {e.id for e in k.rung.model.effects} == others), None)
        if seen is not None:
            bare = Incumbent(workshop, seen.rung)
            rivals = [c.rung for c in seen.candidates if c.id not in present]
        else:
            progress(f"could another effect stand for {accepted.id}?")
            base = shorter.get(accepted.id) or without(workshop, rung, accepted.id)
            bare = Incumbent(workshop, base)
            found = screen_best(workshop, base.fit, [effects[accepted.id], *absent])
            settled = nearly_all(base, rung, workshop.noise)
            near = _near(found, accepted)
            screened = worth_simulating(
                workshop, base, near, at_least=RIVALS, reach=1.0, settled=settled
            )
            rivals = [confirm(bare, item, beside=[rung]) for item in screened]
        as_free = bare.against(rung)
        if not rivals:
            stands[accepted.id] = Stand(as_free, as_free)
            continue
        best = best_first(rivals, workshop.noise)[0]
        close = best_first([rung, best], workshop.noise)[0] is best or lead(rung, best) < NEAR
        # Where something is left, a rival may be what is missing, however far above it a quick fit
        # has ended; one without hope ends early.
        if close or not all_noise(rung.fit, workshop.noise):
            best = refit(workshop, best, -inf if close else rung.fit.cost)
        if incumbent.gives_way_to(best):
            return Exchange(best)
        stands[accepted.id] = Stand(as_free, best)
    return Exchange(None, stands)


def _near(screened: Sequence[Screened], accepted: Effect) -> list[Screened]:
    """What could stand for the accepted effect: not what leaves far more, both to first order."""
    own = min((s.error for s in screened if s.variant.effect.id == accepted.id), default=inf)
    others = (s for s in screened if s.variant.effect.id != accepted.id)
    return [s for s in others if s.error < HOPELESS * own]
