"""The verdict: what was accepted, how sure that is, and why everything else was not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from wheelhop.diagnose.ambiguity import Angles
from wheelhop.diagnose.confidence import confidence, grounds
from wheelhop.diagnose.diagnosis import Diagnosis, Step
from wheelhop.diagnose.exchange import Stand
from wheelhop.diagnose.explain import explanation
from wheelhop.diagnose.judge import lead
from wheelhop.diagnose.limits import limits
from wheelhop.diagnose.look import Look
from wheelhop.diagnose.next_run import NextRun, propose
from wheelhop.diagnose.ranking import ranking
from wheelhop.effects import Effect
from wheelhop.fit import Workshop

DOUBT = 0.03
"""A rival that leaves only this share more than the effect chosen leaves a doubt, whatever the
evidence says: simulations are no more exact than that near the noise."""


def conclude(
    workshop: Workshop,
    steps: Sequence[Step],
    first: Look,
    last: Look,
    stands: Mapping[str, Stand],
    effects: Sequence[Effect],
) -> Diagnosis:
    """The diagnosis from the ladder's steps, the first look, the last one, what exchanging effects
    showed, and the library."""
    angles = Angles(first.rung.fit, first.screened, first.candidates)
    accepted = steps[-1].added
    verdict = (*accepted, "unknown") if steps[-1].above_floor else accepted or ("none",)
    stands_on = grounds(verdict, steps, first, last, stands, workshop.noise)
    return Diagnosis(
        verdict=verdict,
        confidence=confidence(verdict, stands_on),
        grounds=stands_on,
        ranking=ranking(first, angles, effects, steps[0]),
        ladder=tuple(steps),
        next_run=_next_run(workshop, accepted, first, angles),
        explanation=explanation(verdict, steps, last, stands_on),
        limits=limits(last if last.screened else first, accepted),
    )


def _next_run(
    workshop: Workshop, accepted: Sequence[str], first: Look, angles: Angles
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
