"""Exchange: could another effect stand in the place of one that was accepted before?

Effects are accepted one after the other, and the first may have been taken for what only two
together explain. When nothing more can be added, each is therefore taken out again and the whole
library tried in its place, so that the order of acceptance does not decide the outcome.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from wheelhop.diagnose.baseline import Progress
from wheelhop.diagnose.confirm import Rung, confirm, refit, without
from wheelhop.diagnose.judge import log_odds
from wheelhop.diagnose.screen import Screened, screen
from wheelhop.effects import Effect
from wheelhop.fit import Workshop

RIVALS = 2
"""So many effects are simulated in full in the place of each one accepted."""

REACH = 0.3
"""A rival is tried if screening expects this share of what the effect accepted brings."""


@dataclass(frozen=True, eq=False)
class Exchange:
    """What became of the attempt: ``rung`` with one effect exchanged for a better one, or None;
    ``margins`` by how much the logarithm of the evidence favours each accepted effect over the
    best rival in its place."""

    rung: Rung | None
    margins: Mapping[str, float] = field(default_factory=dict)


def exchange(
    workshop: Workshop,
    rung: Rung,
    shorter: Mapping[str, Rung],
    effects: Mapping[str, Effect],
    progress: Progress,
) -> Exchange:
    """Try the library in the place of each effect of `rung`; `shorter` holds the models fitted
    without one of them, as far as they are known."""
    present = {effect.id for effect in rung.model.effects}
    absent = [effect for effect in effects.values() if effect.id not in present]
    margins: dict[str, float] = {}
    for accepted in rung.model.effects:
        progress(f"could another effect stand for {accepted.id}?")
        base = shorter.get(accepted.id) or without(workshop, rung, accepted.id)
        rivals = [
            confirm(workshop, base, item)
            for item in _worth_trying(base, rung, screen(workshop, base.fit, absent))
        ]
        if not rivals:
            margins[accepted.id] = rung.evidence - base.evidence
            continue
        best = max(rivals, key=lambda rival: rival.evidence)
        if _better(best, rung, workshop.noise):
            best = refit(workshop, best)
            if _better(best, rung, workshop.noise):
                return Exchange(best)
        margins[accepted.id] = rung.evidence - best.evidence
    return Exchange(None, margins)


def _worth_trying(base: Rung, rung: Rung, screened: Sequence[Screened]) -> Sequence[Screened]:
    brought = (base.fit.rss - rung.fit.rss) / base.fit.sigma**2
    return [s for s in screened if s.score > 0 and s.gain > REACH * brought][:RIVALS]


def _better(rival: Rung, rung: Rung, noise: float) -> bool:
    """By evidence on the runs fitted and by odds on the runs held out."""
    return rival.evidence > rung.evidence and log_odds(rung, rival, noise) > 0.0
