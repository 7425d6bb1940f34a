"""How sure a verdict is: what speaks for its first entry, against its rivals, noise and chance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import erfc, exp, hypot, inf, log, sqrt, tanh

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from wheelhop.diagnose.diagnosis import UNLIKELY, Grounds, Step
from wheelhop.diagnose.score import (
    EXACT,
    LAW,
    Rung,
    by_chance,
    excess,
    lead,
    left,
    log_odds,
    p_value,
)
from wheelhop.diagnose.search.scored import Scored, Stand
from wheelhop.fit import louder

Array = NDArray[np.float64]

CEILING = 0.99
"""No verdict on a single campaign is surer than this."""

LEAD_SCALE = 0.001
"""Odds are e : 1 against a rival that leaves this share more than the effect accepted, 1 : e
against one that leaves as much less: simulations are no more exact than that near the noise,
whatever the evidence says."""

STEADY = 0.3
"""So much of what speaks for an effect should be left without the run that speaks loudest."""

AS_LIKELY = 0.5
"""The chance that an effect is right whose number sits on its bound, if it is as likely that
another law is what it stands in for; or beside which another as good was not tried."""

ODDS_RIGHT = 2.0
"""Odds, beforehand, that what leaves a part unexplained is the right effect and no stand-in: those
that make the answers of the published blind tables likeliest."""

UNKNOWN_SCALE = 0.3
"""Error over the floor, less one, at which "unknown" is two thirds sure: nearer to the floor an
effect of the library may be too faint to be found."""

PARTS = 4
"""Of the band: a sensor's noise need not be white."""

SURELY_NONE = 0.1
"""Where the likeliest effect has this chance to be worthless, and noise this chance to leave so
much, "none" is as sure as it can be."""


def grounds(
    verdict: Sequence[str],
    steps: Sequence[Step],
    last: Scored,
    stand: Stand | None,
    tried: int,
    noise: float,
) -> Grounds:
    """What the verdict's first entry stands on: what is left, and, if it is one of so many effects
    `tried`, what it was held against (`Search.stand`)."""
    at_floor, final = "unknown" not in verdict, steps[-1].rung
    floor = steps[-1].comparison.floor
    # The noise that a campaign states is taken at its word, unless what is more looks like noise.
    stated = floor.is_stated
    chance = by_chance(final, noise, steps[-1].allowed) if stated else _by_chance(steps[-1])
    more_noise = noisier(steps[-1], noise)
    found = Grounds(
        log_odds=inf,
        lead=inf,
        stability=1.0,
        p_value=min((c.p for c in last.candidates), default=1.0),
        over_floor=steps[-1].over_floor,
        baseline_over_floor=steps[0].over_floor,
        by_chance=max(chance, more_noise),
        louder=chance < UNLIKELY <= more_noise,
        expected_over_floor=steps[-1].expected / steps[-1].floor,
    )
    if stand is None:
        return found
    accepted, base, rivals = stand.accepted, stand.without, stand.rivals
    # A rival may be worse than nothing.
    best = min([*rivals, base], key=lambda r: lead(accepted, r))
    return replace(
        found,
        log_odds=min((_odds(rival, accepted, at_floor) for rival in rivals), default=inf),
        lead=lead(accepted, best),
        stability=_stability(best, accepted),
        p_value=p_value(log_odds(base, accepted, noise), tried),
    )


def _by_chance(step: Step) -> float:
    """Chance that noise, believed to be log-normal about an estimate, leaves at least as much of
    the runs that judge, what model and scales may be wrong by allowed for."""
    left = step.rung.error_judging**2 - step.allowed
    if left <= 0.0 or not step.expected > 0.0:
        return 1.0
    spread = hypot(step.comparison.floor.uncertainty, sqrt(0.5 / step.rung.judging.size))
    return 0.5 * erfc(log(sqrt(left) / step.expected) / spread / sqrt(2.0))


def noisier_sensors(rung: Rung, noise: float) -> float:
    """Chance that sensors noisier than stated are all that a rung leaves: the less of how likely
    they are so loud, and of how likely every channel, in each part of the band, is as loud in every
    run. What tracks and speeds bring about is not. (Equal variances: M. Bartlett, Proc. R. Soc. A
    160 (1937) 268.)"""
    runs = rung.fit.runs if rung.judging is rung.fit else (*rung.fit.runs, *rung.judging.runs)
    cells: dict[tuple[int, int], list[Array]] = {}
    for run in runs:
        channels = np.flatnonzero(run.bench.predicted).tolist()
        left = run.residual.reshape(2, -1, len(channels))  # cosines and sines
        for part, several in enumerate(np.array_split(left, PARTS, axis=1)):
            for channel, data in zip(channels, several.reshape(-1, len(channels)).T, strict=True):
                cells.setdefault((channel, part), []).append(data)
    tests = [_unequal(each) for each in cells.values()]
    freedom = sum(free for _, free in tests)
    even = float(chdtrc(freedom, sum(found for found, _ in tests))) if freedom else 0.0
    return min(even, louder(1.0 + excess(rung, noise)))


def noisier(step: Step, noise: float) -> float:
    """`noisier_sensors` for a step of a campaign that states its noise; 0 where none is stated."""
    return noisier_sensors(step.rung, noise) if step.comparison.floor.is_stated else 0.0


def _unequal(samples: Sequence[Array]) -> tuple[float, int]:
    """Bartlett's statistic of samples, χ² if their variances are equal, and its freedom."""
    count = np.array([len(each) for each in samples], float)
    power = np.array([np.mean(each**2) for each in samples])
    if len(samples) < 2 or not (power > 0.0).all():
        return 0.0, 0
    n, k = count.sum(), len(samples)
    unequal = n * np.log(count @ power / n) - count @ np.log(power)
    return float(unequal / (1.0 + ((1.0 / count).sum() - 1.0 / n) / (3.0 * (k - 1)))), k - 1


def confidence(
    verdict: Sequence[str], grounds: Grounds, missing: float = 0.0, of_laws: float = 0.0
) -> float:
    """That the verdict's first entry is right; `missing` is the chance that something is left where
    the verdict does not say so, `of_laws` as for `Floor`.

    Of an effect: how clearly it leads its best rival, times the chance that it does not hold at
    all; where something is left, times the chance that it is no stand-in (a wrong effect may
    explain a part, hardly ever nearly everything), less where a single run speaks for it, and where
    a number of an effect sits on its bound, so that a law the library lacks is as likely. Of
    "none": how far the likeliest effect is from being accepted, whether noise alone leaves as much,
    and what these runs could have shown. Of "unknown": how far the residual is above the floor's
    own uncertainty. All of it less where the search was ended before it was done.
    """
    return (1.0 - grounds.untried) * _of_what_was_tried(verdict, grounds, missing, of_laws)


def _of_what_was_tried(
    verdict: Sequence[str], grounds: Grounds, missing: float, of_laws: float
) -> float:
    if verdict[0] == "unknown":
        return CEILING * (1.0 - exp(-(grounds.over_expected - 1.0) / UNKNOWN_SCALE))
    if verdict[0] == "none":
        nothing_holds = 0.5 + 0.5 * min(1.0, grounds.p_value / SURELY_NONE)
        only_noise = min(1.0, grounds.by_chance / SURELY_NONE)
        return CEILING * nothing_holds * only_noise * (1.0 - grounds.unseen)
    leads = 0.5 + 0.5 * tanh(0.5 * grounds.lead / LEAD_SCALE)
    sure = CEILING * leads * (1.0 - grounds.p_value)
    steady = min(max(grounds.stability / STEADY, 0.0), 1.0)
    beside = (
        sure * steady * _no_stand_in(grounds, of_laws) * (AS_LIKELY if grounds.cramped else 1.0)
    )
    return beside if "unknown" in verdict else sure - missing * (sure - beside)


def _no_stand_in(grounds: Grounds, of_laws: float) -> float:
    """Chance that what leaves a part unexplained is no stand-in for something unknown.

    A stand-in leaves any share s of the power above the floor, and above what no law was found to
    leave less than, alike, density 1. What is right may leave something small beside it, no size
    likelier than another down to ε², the power that such models are exact to, density 1 / (s
    ln(1/ε²)): a law of the struts leaves a tenth of the amplitude, under its right name, as
    machines part from textbooks. Beforehand the odds for what is right are `ODDS_RIGHT`.
    """
    least = max(of_laws, 1.0) ** 2
    excess = grounds.baseline_over_expected**2 - least
    left = max(grounds.over_expected**2 - least, 0.0)
    if left >= excess:
        return 0.0
    exact = LAW if grounds.is_law else EXACT
    return ODDS_RIGHT / (ODDS_RIGHT + left / excess * log(1.0 / exact**2))


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
    for before, after in ((rival.fit, accepted.fit), (rival.judging, accepted.judging)):
        gains += [left(a) - left(b) for a, b in zip(before.runs, after.runs, strict=True)]
    total = sum(gains)
    return (total - max(gains)) / total if total > 0.0 else -1.0
