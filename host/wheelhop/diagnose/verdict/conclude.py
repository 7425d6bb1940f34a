"""The verdict: what was accepted, how sure that is, and what these runs could not have shown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.diagnosis import UNLIKELY, Diagnosis, EndedBy, Step, Unfinished
from wheelhop.diagnose.next_run import NextRun, propose
from wheelhop.diagnose.posterior import AS_LIKELY, confidence, grounds, noisier
from wheelhop.diagnose.score import lead, runs_away
from wheelhop.diagnose.search.look import beside_other_laws
from wheelhop.diagnose.search.scored import BASELINE, Scored, Search, Stand, ids_of
from wheelhop.diagnose.verdict.critic import cramped
from wheelhop.diagnose.verdict.limits import limits, of_the_vehicle, unseen
from wheelhop.diagnose.verdict.ranking import Angles, explanation, ranking
from wheelhop.fit import Workshop

Array = NDArray[np.float64]

DOUBT = 0.03
"""A rival that leaves only this share more than the effect chosen leaves a doubt, whatever the
evidence says: simulations are no more exact than that near the noise."""


def conclude(search: Search, steps: Sequence[Step], ended_by: EndedBy | None = None) -> Diagnosis:
    """The diagnosis from the ladder's steps and from what the search knows, which may have been
    ended before it was done."""
    workshop, effects = search.workshop, list(search.effects.values())
    first = search.table[BASELINE].with_together()
    last = search.table.get(ids_of(steps[-1].rung)) or Scored(steps[-1].rung)
    steps = [*steps[:-1], beside_other_laws(steps[-1], last)]
    stable = [c for c in first.candidates if not runs_away(c.rung)]
    angles = Angles(first.rung.fit, first.screened, stable)
    accepted = steps[-1].added
    on_bounds = cramped(steps[-1])
    not_noise = steps[-1].above_floor and noisier(steps[-1], workshop.noise) < UNLIKELY
    left_over = not_noise or bool(on_bounds)
    verdict = (*accepted, "unknown") if left_over else accepted or ("none",)
    stand = search.stand(steps[-1].rung, verdict[0]) if accepted else None
    shown = limits(last if last.screened else first, accepted)
    ended = _unfinished(search, last, ended_by) if ended_by else None
    stands_on = replace(
        grounds(verdict, steps, last, stand, len(first.screened), workshop.noise),
        unseen=unseen(of_the_vehicle(shown, effects), len(effects)),
        cramped=bool(on_bounds),
        is_law=bool(accepted) and search.effects[accepted[0]].on_rig,
        untried=_untried(steps[-1], verdict[0], last, stand) if ended else 0.0,
    )
    # Noise that is stated is taken at its word.
    floor = steps[-1].comparison.floor
    missing = 0.0 if floor.is_stated else 1.0 - stands_on.by_chance
    return Diagnosis(
        verdict=verdict,
        confidence=confidence(verdict, stands_on, missing, floor.of_laws),
        grounds=stands_on,
        ranking=ranking(first, angles, effects, steps[0]),
        ladder=tuple(steps),
        next_run=_next_run(workshop, accepted, first, angles),
        explanation=(
            *([ended.sentence] if ended else []),
            *explanation(
                verdict, steps, first, last, stands_on, of_the_vehicle(shown, effects), on_bounds
            ),
        ),
        limits=shown,
        unfinished=ended,
    )


def _untried(step: Step, first: str, last: Scored, stand: Stand | None) -> float:
    """Chance that another entry would come first had all been simulated. What first order puts
    ahead of the effect accepted is as likely, and so is any where nothing was screened, unless the
    search had come to its choice there, and passed it over; what did better than the effect by
    itself may do as well beside the others; of what nothing explains so far, the best of them may
    explain the share that first order says."""
    if stand is not None:
        if stand.is_behind:
            return AS_LIKELY
        if stand.beside.looked:
            return 0.0
        present, left = ids_of(step.rung), stand.there.fit.error
        waiting = _not_simulated(stand.beside)
        ahead = any(error < left for name, error in waiting if name not in present)
        return AS_LIKELY if ahead or not stand.beside.screened else 0.0
    if not last.screened:
        return AS_LIKELY if first == "none" else 1.0
    floor, left = step.comparison.floor.expected_fit, last.rung.fit.error
    expected = min((error for _, error in _not_simulated(last)), default=inf)
    return min(max((left**2 - expected**2) / max(left**2 - floor**2, 1e-12), 0.0), 1.0)


def _not_simulated(scored: Scored) -> list[tuple[str, float]]:
    """Effects that are worth their numbers to first order and were not simulated in full beside a
    set, with the error each is expected to leave; the least first."""
    found = [
        (s.id, s.error) for s in scored.screened if s.score > 0 and scored.candidate(s.id) is None
    ]
    return sorted(found, key=lambda item: item[1])


def _unfinished(search: Search, last: Scored, ended_by: EndedBy) -> Unfinished:
    return Unfinished(ended_by, search.workshop.work.seconds, tuple(_not_simulated(last)))


def _next_run(
    workshop: Workshop, accepted: Sequence[str], first: Scored, angles: Angles
) -> NextRun | None:
    """The run that tells the effect accepted first from the rival that comes nearest to it, if any
    comes near."""
    chosen = next((c for c in first.candidates if c.id in accepted), None)
    if chosen is None:
        return None
    near = dict(angles.near(chosen.id))
    rivals = [c for c in first.candidates if c is not chosen]
    close = [c for c in rivals if c.id in near or lead(chosen.rung, c.rung) < DOUBT]
    if not close:
        return None
    nearest = min(close, key=lambda c: lead(chosen.rung, c.rung))
    return propose(
        workshop,
        (chosen.id, chosen.rung),
        (nearest.id, nearest.rung),
        angles.between(chosen.id, nearest.id),
    )
