"""Which of the effects screened are worth simulating in full."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.diagnose.judge import all_noise, material, noticeable, unforeseen
from wheelhop.diagnose.rung import Rung
from wheelhop.diagnose.screen import Screened
from wheelhop.fit import Workshop

CONFIRMED = 5
"""At least so many effects are simulated in full on every rung."""

REACH = 0.5
"""And every one that screening expects to explain this share of what the best explains."""


def least_gain(workshop: Workshop, rung: Rung) -> float:
    """What screening must expect at least of an effect that could be material: a quarter of that,
    as it may see half the amplitude."""
    return material(rung) / 4 * rung.fit.size


def worth_simulating(
    workshop: Workshop,
    rung: Rung,
    screened: Sequence[Screened],
    *,
    at_least: int = CONFIRMED,
    reach: float = REACH,
    settled: bool = False,
) -> list[Screened]:
    """The most promising effects, the best first.

    Effects that even by screening could take nothing material out of the residual are left alone:
    where it is `settled` that a model explains nearly all, they are no rivals of that one. Else
    first order may mislead, and what it cannot judge is simulated all the same.
    """
    promising = [s for s in screened if s.score > 0 and s.gain > least_gain(workshop, rung)]
    enough = reach * promising[0].gain if promising else 0.0
    chosen = [s for i, s in enumerate(promising) if i < at_least or s.gain >= enough]
    if settled:
        return chosen
    surprising = unforeseen(rung, workshop.noise)
    explained = all_noise(rung.fit, workshop.noise)
    if surprising or (not explained and noticeable(rung, workshop.noise)):
        # What has no number to fit may show in held-out runs alone: only there the wheels leave
        # the ground. Of sensors screening already says all.
        switches = [s for s in screened if s.freedom == 0 and s.variant.effect.place != "sensor"]
        chosen += [s for s in switches if s not in chosen]
    if surprising:
        # So may what is free in every run: a driver need not be unsteady in all of them.
        own = [s for s in screened if s.freedom > 0 and not s.variant.parameters]
        chosen += [s for s in own if s not in chosen]
    return chosen
