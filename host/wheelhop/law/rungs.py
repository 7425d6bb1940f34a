"""The last rungs of a ladder: what no name explains, as a formula and as a free law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from wheelhop.campaign import ComponentCampaign
from wheelhop.diagnose import Baseline, Diagnosis, Progress, Step, comparison_of
from wheelhop.diagnose.search.look import step_of
from wheelhop.effects import Effect
from wheelhop.fit import OutOfBudget
from wheelhop.law.search import Found, find_law_beside


@dataclass(frozen=True)
class Nearest:
    """The names that come nearest to the force of a component, what they leave of the runs that
    judge, E, and why they do not do, as far as the ranking says so."""

    name: str
    error: float
    why: str = ""


@dataclass(frozen=True, eq=False)
class LastRungs:
    """The law a component's baseline lacks, whatever its name; the models with it as steps of the
    ladder, the formula, if there is one, before the free law; and the names that come nearest."""

    found: Found
    steps: tuple[Step, ...]
    nearest: Nearest | None


def last_rungs(
    base: Baseline,
    diagnosis: Diagnosis,
    library: Sequence[Effect],
    progress: Progress,
    budget_s: float | None = None,
) -> LastRungs | None:
    """What follows where the names of a component end above the floor; None where they do not, of a
    vehicle, and where the work allowed is done before a law is found."""
    workshop, first, last = base.workshop, diagnosis.ladder[0], diagnosis.ladder[-1]
    ended = diagnosis.unfinished is not None or not last.above_floor
    if not isinstance(workshop.campaign, ComponentCampaign) or ended:
        return None
    try:
        with workshop.work.limited(budget_s):
            found = find_law_beside(workshop, first.rung, library, progress, names=False)
    except (OutOfBudget, KeyboardInterrupt):
        return None  # the diagnosis is there
    floor = last.comparison.floor
    steps = (
        replace(
            step_of(workshop, rival.rung),
            added=("free law" if rival is found.free else rival.name,),
            comparison=comparison_of(workshop, rival.rung, floor=floor),
            lacked=last.lacked,
        )
        for rival in (found.formula, found.free)
        if rival is not None
    )
    return LastRungs(found, tuple(steps), _nearest(diagnosis))


def _nearest(diagnosis: Diagnosis) -> Nearest | None:
    last = diagnosis.ladder[-1]
    if last.added:
        return Nearest(" + ".join(last.added), last.rung.error)
    tried = [r for r in diagnosis.ranking if r.validated_error is not None]
    best = min(tried, key=lambda r: r.validated_error or 0.0, default=None)
    return None if best is None else Nearest(best.effect, best.validated_error or 0.0, best.reason)
