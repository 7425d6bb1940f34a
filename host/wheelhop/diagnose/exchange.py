"""Exchange: could another effect stand in the place of one that was accepted before?

Effects are accepted one after the other, and the first may have been taken for what only two
together explain. When nothing more can be added, each is therefore taken out again and the whole
library tried in its place, so that the order of acceptance does not decide the outcome.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from wheelhop.diagnose.baseline import Progress
from wheelhop.diagnose.confirm import confirm, refit, without
from wheelhop.diagnose.judge import best_first, lead, nearly_all
from wheelhop.diagnose.look import Look
from wheelhop.diagnose.promising import worth_simulating
from wheelhop.diagnose.rung import Rung
from wheelhop.diagnose.screen import screen
from wheelhop.diagnose.validate import Incumbent
from wheelhop.effects import Effect
from wheelhop.fit import Workshop

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
            base = seen.rung
            rivals = [c.rung for c in seen.candidates if c.id not in present]
        else:
            progress(f"could another effect stand for {accepted.id}?")
            base = shorter.get(accepted.id) or without(workshop, rung, accepted.id)
            found = screen(workshop, base.fit, absent)
            settled = nearly_all(base, rung, workshop.noise)
            screened = worth_simulating(
                workshop, base, found, at_least=RIVALS, reach=1.0, settled=settled
            )
            rivals = [confirm(workshop, base, item, beside=[rung]) for item in screened]
        as_free = Incumbent(workshop, base).against(rung)
        if not rivals:
            stands[accepted.id] = Stand(as_free, as_free)
            continue
        best = best_first(rivals, workshop.noise)[0]
        if best_first([rung, best], workshop.noise)[0] is best or lead(rung, best) < NEAR:
            best = refit(workshop, best)
        if incumbent.gives_way_to(best):
            return Exchange(best)
        stands[accepted.id] = Stand(as_free, best)
    return Exchange(None, stands)
