"""What is known of every set of effects that was fitted: the search asks here before it fits.

A set goes by the ids of its effects; the baseline's is empty. Whether an effect is still needed,
whether another could stand for it and what a verdict was held against are questions about
neighbouring sets.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from wheelhop.compare import Floor
from wheelhop.diagnose.confirm.in_full import refit
from wheelhop.diagnose.confirm.validate import Incumbent
from wheelhop.diagnose.diagnosis import Step
from wheelhop.diagnose.score import Rung, enough_held_out, lead, p_value
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.effects import Effect, form_of
from wheelhop.files import Progress
from wheelhop.fit import Workshop

SAME = 1e-3
"""Fits that end within this share of the cost of each other, or of what noise costs, have ended in
the same minimum: ten steps as small as the last one lead no further (`fit.CONVERGED`)."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """An effect simulated in full: its log-odds over the rung's model on held-out runs, of how many
    effects tried it is one, and whether that is significant and material; and beside which other
    effect, if that was needed for it to show."""

    screened: Screened
    rung: Rung
    log_odds: float
    tried: int
    holds: bool
    beside: str = ""

    @property
    def id(self) -> str:
        """The effect's id."""
        return self.screened.id

    @property
    def effect(self) -> Effect:
        """The effect in the form that the full simulation came to."""
        return next(e for e in self.rung.model.effects if e.id == self.id)

    @property
    def form(self) -> str:
        """The name of that form."""
        return form_of(self.effect, self.rung.fit.runs[0].bench.simulator.campaign.channels)

    @property
    def p(self) -> float:
        """Chance that any of the effects tried does so well without being there."""
        return p_value(self.log_odds, self.tried)


@dataclass(frozen=True, eq=False)
class Scored:
    """What is known of a set of effects: the best model fitted in full so far, the other effects
    screened beside it, those of them simulated in full (best first), and the one to accept, if any.

    ``looked`` says whether the ladder has stood here, screened the whole library, and come to what
    to accept. ``together``
    are effects that only together explain what is left here: None until they were sought, empty if
    there are none."""

    rung: Rung
    screened: tuple[Screened, ...] = ()
    candidates: tuple[Candidate, ...] = ()
    chosen: Candidate | None = None
    looked: bool = False
    together: tuple[Candidate, ...] | None = None

    def candidate(self, effect_id: str) -> Candidate | None:
        """An effect as it was simulated in full beside this set, if it was."""
        return next((c for c in self.candidates if c.id == effect_id), None)

    def with_together(self) -> Scored:
        """If a group was accepted: its effects as candidates, the first of them as the choice."""
        if not self.together:
            return self
        ids = {c.id for c in self.together}
        rest = (c for c in self.candidates if c.id not in ids)
        return replace(self, candidates=(*self.together, *rest), chosen=self.together[0])

    def remembered(self) -> Scored:
        """Copy for later comparisons: how well each effect did, without signatures and derivatives,
        which dominate memory, and without the choice, which is in the model by then."""
        candidates = (
            replace(c, screened=replace(c.screened, contribution={}), rung=remembered(c.rung))
            for c in self.candidates
        )
        screened, rung = (replace(s, contribution={}) for s in self.screened), remembered(self.rung)
        together = self.together and ()
        return Scored(rung, tuple(screened), tuple(candidates), None, self.looked, together)


@dataclass(frozen=True, eq=False)
class Stand:
    """What an effect was held against: the model accepted with it, the one without it as judged
    beside that, and those with another effect in its place (if none was tried, the one without);
    and all that is known of the effects `beside` it. ``there`` is the model with it and these
    alone."""

    accepted: Rung
    without: Rung
    rivals: Sequence[Rung]
    beside: Scored
    there: Rung

    @property
    def is_behind(self) -> bool:
        """Whether a rival did better there, and was not tried beside the effects that came after
        them."""
        tried = self.there is self.accepted
        return not tried and any(lead(self.there, rival) < 0.0 for rival in self.rivals)


Watch = Callable[[Scored], None]
Beyond = Callable[[Workshop, Sequence[Step]], Floor]
"""What is asked of a ladder that came to its end: the noise floor by what laws without names leave.
"""
Table = dict[frozenset[str], Scored]
BASELINE = frozenset[str]()


@dataclass(frozen=True, eq=False)
class Search:
    """A campaign's search: the library by id, how many effects a model may have, whom to tell, and
    what is known by now."""

    workshop: Workshop
    effects: Mapping[str, Effect]
    max_effects: int
    progress: Progress
    watch: Watch = lambda scored: None
    to_the_end: bool = False  #: small things, too, are made part of the model
    table: Table = field(default_factory=dict)

    def told(self, scored: Scored) -> None:
        """Store the state of a set of effects and tell the watcher."""
        self.table[ids_of(scored.rung)] = scored
        self.watch(scored)

    def room(self, rung: Rung) -> int:
        """How many effects more the rung's model may have."""
        return self.max_effects - len(rung.model.effects)

    def best(self, rung: Rung) -> Rung:
        """The better of a model fitted in full and of the one known of the same effects, with its
        derivatives. A better one than was known takes its place; what was screened and simulated
        beside that is then forgotten. The baseline stays: all that is ranked was tried beside it.
        """
        ids, known = ids_of(rung), self.table.get(ids_of(rung))
        if known is None:
            self.table[ids] = Scored(rung)
            return rung
        before, after = known.rung.fit.cost, rung.fit.cost
        neglected = SAME * max(min(before, after), rung.fit.size)
        if ids and after < before - neglected:
            self.table[ids] = Scored(rung)
        better = known.rung if before < after - neglected else rung
        return with_derivatives(self.workshop, better)

    def stand(self, rung: Rung, effect_id: str) -> Stand:
        """What an effect of a rung stands against: in place of it beside the rung's other effects
        or, where the search was ended before it asked that, beside as many of them as it was
        simulated with."""
        present = ids_of(rung)
        if present - {effect_id} in self.table:
            beside = present - {effect_id}
        else:
            simulated = (i for i, s in self.table.items() if i < present and s.candidate(effect_id))
            beside = max(simulated, key=len, default=BASELINE)
        known = self.table[beside]
        rivals = [c.rung for c in known.candidates if c.id not in present]
        base = Incumbent(self.workshop, known.rung).against(rung)
        then = known.candidate(effect_id) if beside | {effect_id} != present else None
        return Stand(rung, base, rivals or [base], known, rung if then is None else then.rung)

    def settle(self) -> None:
        """Drop derivatives of all sets that are only compared against from now on. The baseline
        keeps what was tried beside it, which the ranking shows."""
        for ids, scored in self.table.items():
            self.table[ids] = scored.remembered() if ids else scored


def ids_of(rung: Rung) -> frozenset[str]:
    """The set of effects that a model has."""
    return frozenset(effect.id for effect in rung.model.effects)


def with_derivatives(workshop: Workshop, rung: Rung) -> Rung:
    """The rung, fitted again if it was `remembered` without derivatives."""
    return rung if rung.fit.has_derivatives else refit(workshop, rung)


def remembered(rung: Rung) -> Rung:
    """Copy without derivatives, which dominate memory, where enough runs are held out to judge
    without them."""
    if not enough_held_out(rung):
        return rung
    return replace(
        rung,
        fit=rung.fit.without_derivatives,
        validation=rung.validation and rung.validation.without_derivatives,
        update=rung.update and rung.update.without_derivatives,
    )
