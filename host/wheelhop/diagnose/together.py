"""Two effects that show only together: none is seen while the other is not in the model.

A loose sensor on an axle with friction, for one: the mount magnifies what friction excites, and
neither explains anything alone. Where no single effect holds and something is left, the most
promising ones are therefore taken for granted one after the other, and the rest of the library
screened beside each.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import comb
from typing import NamedTuple

from wheelhop.diagnose.baseline import Progress
from wheelhop.diagnose.confirm import Rung, confirm, refit
from wheelhop.diagnose.judge import best_first, excess, holds_against, log_odds
from wheelhop.diagnose.look import Candidate, Look, contradicted
from wheelhop.diagnose.screen import Screened, screen
from wheelhop.effects import Effect
from wheelhop.fit import Workshop

FIRSTS = 5
"""So many effects are taken for granted."""

PAIRS = 3
"""So many pairs, the most promising ones, are simulated in full."""


NEARLY_ALL = 0.9
"""A pair must explain this share of the power above the noise: two wrong effects together explain
more by chance than one does."""


class _Pair(NamedTuple):
    first: Candidate
    second: Screened

    @property
    def ids(self) -> frozenset[str]:
        return frozenset((self.first.id, self.second.variant.effect.id))


def look_for_two(
    workshop: Workshop, look: Look, effects: Mapping[str, Effect], progress: Progress
) -> Look:
    """The look at a residual no single effect explains, with the pair of effects chosen that does;
    as it was if there is none."""
    pairs = list(_promising(workshop, look, effects, progress))
    if not pairs:
        return look
    rungs = []
    for pair in pairs:
        progress(f"simulating {' with '.join(sorted(pair.ids))}")
        rungs.append(confirm(workshop, pair.first.rung, pair.second))
    best = best_first(rungs, workshop.noise)[0]
    pair = pairs[next(i for i, rung in enumerate(rungs) if rung is best)]
    progress(f"fitting the vehicle with {' and '.join(sorted(pair.ids))}")
    best = refit(workshop, best)
    return _with_pair(workshop, look, pair, best, comb(len(effects), 2))


def _promising(
    workshop: Workshop, look: Look, effects: Mapping[str, Effect], progress: Progress
) -> Iterator[_Pair]:
    """The pairs that leave least by screening, each once."""
    present = {effect.id for effect in look.rung.model.effects}
    firsts = [c for c in look.candidates if c.rung.evidence > look.rung.evidence][:FIRSTS]
    found = []
    for first in firsts:
        progress(f"screening the others beside {first.id}")
        others = [e for e in effects.values() if e.id not in present | {first.id}]
        screened = screen(workshop, first.rung.fit, others)
        found += [_Pair(first, s) for s in screened if s.score > 0]
    seen = set[frozenset[str]]()
    for pair in sorted(found, key=lambda p: p.second.error):
        if len(seen) < PAIRS and pair.ids not in seen:
            seen.add(pair.ids)
            yield pair


def _with_pair(workshop: Workshop, look: Look, pair: _Pair, rung: Rung, tried: int) -> Look:
    odds = log_odds(look.rung, rung, workshop.noise)
    first, second = pair.first.screened, pair.second
    if (
        excess(rung, workshop.noise) > (1.0 - NEARLY_ALL) * excess(look.rung, workshop.noise)
        or not holds_against(look.rung, rung, odds, tried, workshop.noise)
        or any(contradicted(rung, s.variant.effect) for s in (first, second))
    ):
        return look
    one = Candidate(first, rung, odds, tried, True, beside=second.variant.effect.id)
    # What screening said of the second effect by itself is what the ranking shows.
    alone = next((s for s in look.screened if s.variant.effect.id == one.beside), second)
    other = Candidate(replace(second, error=alone.error), rung, odds, tried, True, beside=one.id)
    rest = [c for c in look.candidates if c.id not in pair.ids]
    return replace(look, candidates=(one, other, *rest), chosen=one)
