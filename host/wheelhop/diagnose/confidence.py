"""How sure a verdict is: what it stands on, and the chance that its first entry is right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import exp, inf

from wheelhop.diagnose.confirm import Rung
from wheelhop.diagnose.diagnosis import Grounds, Step
from wheelhop.diagnose.judge import judging, log_odds
from wheelhop.diagnose.look import Look

CEILING = 0.99
"""No verdict on a single campaign is surer than this."""


def grounds(
    verdict: Sequence[str],
    steps: Sequence[Step],
    first: Look,
    last: Look,
    margins: Mapping[str, float],
) -> Grounds:
    """What the verdict's first entry stands on."""
    over = steps[-1].over_floor
    baseline = steps[0].over_floor
    accepted = next((c for c in first.candidates if c.id == verdict[0]), None)
    if accepted is None:
        closest = min((c.p for c in last.candidates), default=1.0)
        margin = margins.get(verdict[0], inf)
        return Grounds(margin, 1.0, closest, over, baseline)
    rivals = [c.rung for c in first.candidates if c.id not in verdict]
    at_floor = "unknown" not in verdict
    odds = {id(r): _odds(r, accepted.rung, at_floor) for r in rivals}
    margin = min([*odds.values(), margins.get(verdict[0], inf)])
    best = min(rivals, key=lambda r: odds[id(r)], default=first.rung)
    return Grounds(margin, _stability(best, accepted.rung), accepted.p, over, baseline)


def confidence(verdict: Sequence[str], grounds: Grounds) -> float:
    """That the verdict's first entry is right."""
    if verdict[0] == "unknown":
        return CEILING * (1.0 - exp(-(grounds.over_floor - 1.0) / 0.05))
    if verdict[0] == "none":
        return CEILING * (0.5 + 0.5 * min(1.0, grounds.p_value / 0.1))
    beaten = 1.0 / (1.0 + exp(-min(max(grounds.log_odds, -700.0), 700.0)))
    sure = CEILING * beaten * (1.0 - grounds.p_value)
    return sure if "unknown" not in verdict else sure / grounds.over_floor


def _odds(rival: Rung, accepted: Rung, at_floor: bool) -> float:
    """Logarithm of the odds for the accepted model.

    Once the residual is down at the white noise of the sensors, the evidence counts in full; while
    something unexplained is left in it, only what blocks of held-out runs say.
    """
    return accepted.evidence - rival.evidence if at_floor else log_odds(rival, accepted)


def _stability(rival: Rung, accepted: Rung) -> float:
    """The share of what speaks for the accepted model that is left when the run that speaks for it
    loudest is left out, fitted runs and held-out ones alike; negative: it turns against it."""
    gains = []
    for before, after in ((rival.fit, accepted.fit), (judging(rival), judging(accepted))):
        gains += [a.rss - b.rss for a, b in zip(before.runs, after.runs, strict=True)]
    total = sum(gains)
    return (total - max(gains)) / total if total > 0.0 else -1.0
