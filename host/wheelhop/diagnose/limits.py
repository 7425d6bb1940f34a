"""Detection limits: how strong an effect has to be for these runs to show it.

"Nothing is missing" is worth what the runs could have shown. The signatures that screening made
say it beforehand, to first order: an effect s times as strong as its scales takes s² G out of the
fitted runs' sum of squares per noise power, G = dᵀI d with the scales d of its amplitudes and
what the runs tell of these, I.
"""

from __future__ import annotations

from collections.abc import Collection
from math import inf, isfinite, log

import numpy as np

from wheelhop.diagnose.diagnosis import Limit
from wheelhop.diagnose.judge import SIGNIFICANT, material
from wheelhop.diagnose.look import Look
from wheelhop.diagnose.screen import Screened


def limits(look: Look, accepted: Collection[str]) -> tuple[Limit, ...]:
    """The limits of all effects a look screened, in the order of their names, but for those
    accepted, and those that leave every run numbers of its own and nothing else."""
    found = [
        _limit(look, item)
        for item in look.screened
        if item.variant.amplitudes and item.variant.effect.id not in accepted
    ]
    return tuple(sorted(found, key=lambda limit: limit.effect))


def _limit(look: Look, item: Screened) -> Limit:
    variant = item.variant
    scale = np.array([p.scale for p in variant.amplitudes])
    gain = float(scale @ item.information @ scale)
    strength = float(np.sqrt(_needed(look, item) / gain)) if gain > 0.0 else inf
    shown = isfinite(strength) and all(
        strength <= 1.0 if p.switch else p.lower <= p.absent + strength * p.scale <= p.upper
        for p in variant.amplitudes
    )
    found = {p.name: p.absent + strength * p.scale for p in variant.amplitudes if not p.switch}
    return Limit(variant.effect.id, variant.choice, found if shown else {}, shown)


def _needed(look: Look, item: Screened) -> float:
    """The drop of the fitted runs' sum of squares, per noise power, with which an effect would be
    simulated in full and then hold on the runs that judge."""
    fitted, judging = look.rung.fit.size, look.rung.judging.size
    by_chance = 2.0 * log(len(look.screened) / SIGNIFICANT) * fitted / judging
    return max(item.price, by_chance, material(look.rung) * fitted)
