"""The verdict: what was accepted, how sure that is, and what these runs could not have shown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.diagnosis import UNLIKELY, Diagnosis, Step
from wheelhop.diagnose.next_run import NextRun, propose
from wheelhop.diagnose.posterior import confidence, grounds, noisier
from wheelhop.diagnose.score import lead
from wheelhop.diagnose.search.look import beside_other_laws
from wheelhop.diagnose.search.scored import BASELINE, Scored, Search, ids_of
from wheelhop.diagnose.verdict.critic import cramped
from wheelhop.diagnose.verdict.limits import limits, of_the_vehicle, unseen
from wheelhop.diagnose.verdict.ranking import Angles, explanation, ranking
from wheelhop.fit import Workshop

Array = NDArray[np.float64]

DOUBT = 0.03
"""A rival that leaves only this share more than the effect chosen leaves a doubt, whatever the
evidence says: simulations are no more exact than that near the noise."""


def conclude(search: Search, steps: Sequence[Step]) -> Diagnosis:
    """The diagnosis from the ladder's steps and from what the search knows."""
    workshop, effects = search.workshop, list(search.effects.values())
    first, last = search.table[BASELINE].with_together(), search.table[ids_of(steps[-1].rung)]
    steps = [*steps[:-1], beside_other_laws(steps[-1], last)]
    angles = Angles(first.rung.fit, first.screened, first.candidates)
    accepted = steps[-1].added
    on_bounds = cramped(steps[-1])
    not_noise = steps[-1].above_floor and noisier(steps[-1], workshop.noise) < UNLIKELY
    left_over = not_noise or bool(on_bounds)
    verdict = (*accepted, "unknown") if left_over else accepted or ("none",)
    stand = search.stand(steps[-1].rung, verdict[0]) if accepted else None
    shown = limits(last if last.screened else first, accepted)
    stands_on = replace(
        grounds(verdict, steps, last, stand, len(first.screened), workshop.noise),
        unseen=unseen(of_the_vehicle(shown, effects), len(effects)),
        cramped=bool(on_bounds),
    )
    return Diagnosis(
        verdict=verdict,
        confidence=confidence(verdict, stands_on),
        grounds=stands_on,
        ranking=ranking(first, angles, effects, steps[0]),
        ladder=tuple(steps),
        next_run=_next_run(workshop, accepted, first, angles),
        explanation=explanation(
            verdict, steps, first, last, stands_on, of_the_vehicle(shown, effects), on_bounds
        ),
        limits=shown,
    )


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
