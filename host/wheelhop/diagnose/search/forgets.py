"""Runs that do not forget how they began: no model can foresee them, the true one included.

Wheels that leave the ground at every wave may move in more than one way over the same track, or in
no periodic way at all. Which, and in what phase, is decided by how the run began, and nobody
recorded that. The model itself says so: begun earlier, it moves otherwise.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from wheelhop.campaign import Campaign, Run
from wheelhop.diagnose.score import LAW, Rung, unforeseen
from wheelhop.files.words import percent
from wheelhop.fit import RunFit, Workshop
from wheelhop.gate import Finding, Gated

FORGETS = "forgets"
"""The kind of this finding."""

EARLIER = (1.5, 2.0)
"""The model's run-up is made so many times as long. Twice, as one beginning may end in the same
motion by chance."""

SLOWER = "Drive it slower: wheels that bounce from wave to wave move in several ways."


def begun_otherwise(workshop: Workshop, rung: Rung, run: RunFit) -> float:
    """How much the modelled motion of a run depends on when it began, relative to the measured
    motion."""
    model, bench = rung.model, run.bench
    systems = workshop.systems(model)
    first = bench.modelled(model, systems)
    others = [workshop.bench(bench.run, earlier).modelled(model, systems) for earlier in EARLIER]
    most = max(float(np.linalg.norm(other - first)) for other in others)
    return most / float(np.sqrt(bench.energy))


@dataclass(frozen=True, eq=False)
class Widened:
    """The simulation error of a rung, as power, plus `more`."""

    rung: Rung
    more: float

    def __call__(self) -> float:
        """That power."""
        return self.rung.inexact + self.more


def never_forgotten(workshop: Workshop, rung: Rung) -> list[Finding]:
    """Findings for runs whose residual exceeds what a law of the right name may leave, and whose
    modelled motion depends by as much on how they began."""
    runs = [*rung.fit.runs, *(() if rung.validation is None else rung.validation.runs)]
    poor = [run for run in runs if LAW**2 * run.bench.energy < run.rss < np.inf]
    shares = workshop.each(lambda run: begun_otherwise(workshop, rung, run), poor)
    told = zip(poor, shares, strict=True)
    return [_finding(run.bench.run.id, share) for run, share in told if share > LAW]


def beginning_allowed_for(workshop: Workshop, rung: Rung) -> Rung:
    """Widen the rung's simulation error by the spread over unknown initial states, where it
    explains the fitted runs and not the held-out ones."""
    if not unforeseen(rung, workshop.noise):
        return rung
    judging = rung.judging
    shares = workshop.each(lambda run: begun_otherwise(workshop, rung, run), judging.runs)
    told = zip(judging.runs, shares, strict=True)
    power = sum(share**2 * run.bench.energy for run, share in told)
    more = power / (judging.size * workshop.noise**2)
    return replace(rung, simulated_wrong=Widened(rung, more))


def remaining(campaign: Campaign, bounced: Collection[Finding]) -> tuple[Run, ...]:
    """The runs without findings; none if no run to fit is among them."""
    names = {finding.about for finding in bounced}
    runs = tuple(run for run in campaign.runs if run.id not in names)
    return runs if any(run.role == "fit" for run in runs) else ()


def without_runs(gated: Gated, bounced: Collection[Finding]) -> Gated:
    """The gated campaign without these runs, and findings that say so."""
    left_out = (replace(finding, remedy=f"It is left out. {SLOWER}") for finding in bounced)
    campaign = replace(gated.campaign, runs=remaining(gated.campaign, bounced))
    return replace(gated, campaign=campaign, findings=(*gated.findings, *left_out))


def _finding(run: str, share: float) -> Finding:
    return Finding(
        "after",
        FORGETS,
        run,
        f"{run} does not forget how it began: started earlier, the same model moves otherwise by"
        f" {percent(share, 2)} of what was measured. What is left of this run tells nothing of what"
        " is missing.",
        f"Leave it out and diagnose again. {SLOWER}",
        "certain",
    )
