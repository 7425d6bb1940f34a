"""Limits: what these runs could not have shown.

"Nothing is missing" is worth what the runs could have shown. The signatures that screening made
say it beforehand, to first order: an effect s times as strong as its scales takes s² G out of the
fitted runs' sum of squares per noise power, G = dᵀI d with the scales d of its amplitudes and
what the runs tell of these, I.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import erf, inf, log, prod, sqrt

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.diagnosis import Limit
from wheelhop.diagnose.posterior import CEILING
from wheelhop.diagnose.score import SIGNIFICANT, material
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.diagnose.screen.signatures import Variant
from wheelhop.diagnose.search.scored import Scored
from wheelhop.effects import Effect, Misstatement, Switch
from wheelhop.fit import BROAD

Array = NDArray[np.float64]


def limits(scored: Scored, accepted: Collection[str]) -> tuple[Limit, ...]:
    """The limits of all effects screened beside a set, in the order of their names, but for those
    accepted, and those that leave every run numbers of its own and nothing else."""
    found = [
        _limit(scored, item)
        for item in scored.screened
        if item.variant.amplitudes and item.id not in accepted
    ]
    return tuple(sorted(found, key=lambda one: one.effect))


def unseen(limits: Sequence[Limit], tried: int) -> float:
    """Chance that an effect is there, weaker than its limit, if of the effects `tried` a machine
    has one on the average and all are as likely."""
    return 1.0 - prod(1.0 - one.unseen / tried for one in limits)


def of_the_vehicle(limits: Sequence[Limit], effects: Sequence[Effect]) -> list[Limit]:
    """The limits of physics. What sensors and surveys do to none of these runs is not missing; a
    vehicle has its bar on other runs, too."""
    physics = {e.id for e in effects if e.place != "sensor" and not isinstance(e, Misstatement)}
    return [one for one in limits if one.effect in physics]


def least_strength(variant: Variant, information: Array, needed: float) -> float:
    """How many times its scales the amplitudes of a variant are where they take as much out of the
    sum of squares, per noise power, as is `needed`; `information` (a, a) is what the runs have on
    them."""
    scale = np.array([p.scale for p in variant.amplitudes])
    gain = float(scale @ information @ scale)
    return float(np.sqrt(needed / gain)) if gain > 0.0 else inf


def limit(variant: Variant, strength: float) -> Limit:
    """The limit of an effect that is seen from a strength on, in scales of its amplitudes.

    Nothing is believed of amplitudes but that they lie within `BROAD` scales, one standard
    deviation. A switch is there or it is not."""
    fitted = [p for p in variant.amplitudes if not isinstance(p, Switch)]
    there = {p.name: p.absent + strength * p.scale for p in fitted}
    possible = all(p.lower <= there[p.name] <= p.upper for p in fitted)
    if len(fitted) < len(variant.amplitudes):
        possible &= strength <= 1.0
    weaker = erf(strength / BROAD / sqrt(2.0)) if fitted else 0.0
    weaker = weaker if possible else 1.0
    shown = weaker < CEILING
    return Limit(variant.effect.id, variant.choice, there if shown else {}, shown, weaker)


def drop_needed(price: float, fitted: int, judging: int, tried: int, least: float) -> float:
    """The drop of the fitted runs' sum of squares, per noise power, with which an effect of this
    `price`, one of so many `tried`, would be simulated in full and then hold on the runs that
    judge; so many data are `fitted` and `judging`, and each leaves the `least` share of its noise
    to what is immaterial."""
    by_chance = 2.0 * log(tried / SIGNIFICANT) * fitted / judging
    return max(price, by_chance, least * fitted)


def _limit(scored: Scored, item: Screened) -> Limit:
    rung = scored.rung
    sizes = rung.fit.size, rung.judging.size
    needed = drop_needed(item.price, *sizes, len(scored.screened), material(rung))
    return limit(item.variant, least_strength(item.variant, item.information, needed))
