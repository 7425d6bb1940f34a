"""The last rungs of a ladder: what no name explains, as a formula and as a free law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

from wheelhop.campaign import ComponentCampaign
from wheelhop.compare import Floor
from wheelhop.diagnose import Diagnosis, Progress, Step, comparison_of
from wheelhop.diagnose.search.look import step_of
from wheelhop.effects import Effect
from wheelhop.fit import OutOfBudget, Workshop
from wheelhop.law.regression import AS_WELL
from wheelhop.law.search import Found, find_law_beside


@dataclass(frozen=True)
class Nearest:
    """The names that come nearest to the force of a component, what they leave of the runs that
    judge, E, and why they do not do, as far as the ranking says so; nothing where they do."""

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

    @property
    def names_do(self) -> bool:
        """Whether the names leave as little as any law without one."""
        least = min((step.rung.error for step in self.steps), default=inf)
        return self.nearest is not None and self.nearest.error <= AS_WELL * least

    @property
    def shown(self) -> tuple[Step, ...]:
        """The rungs that lead further down than names."""
        return () if self.names_do else self.steps


@dataclass(eq=False)
class BeyondNames:
    """Looks for the law of a component whose names end above the floor, and remembers it: the end
    of a ladder that is climbed (`Beyond`)."""

    library: Sequence[Effect]
    progress: Progress
    budget_s: float | None = None
    found: Found | None = None

    def __call__(self, workshop: Workshop, steps: Sequence[Step]) -> Floor:
        """The floor of the ladder, or, where it is a guess, what the law that leaves least leaves,
        if the names leave as little: then nothing shows that they should leave less."""
        self.found = None
        first, last = steps[0], steps[-1]
        floor = last.comparison.floor
        if not isinstance(workshop.campaign, ComponentCampaign) or not last.above_floor:
            return floor
        try:
            with workshop.work.limited(self.budget_s):
                found = find_law_beside(
                    workshop, first.rung, self.library, self.progress, names=False
                )
        except (OutOfBudget, KeyboardInterrupt):
            return floor  # the diagnosis is there
        self.found = found
        laws = [rival.rung for rival in (found.formula, found.free) if rival is not None]
        if not laws:
            return floor
        least = min(rung.error_judging for rung in (last.rung, *laws))
        return floor.beside_laws(least / last.expected)

    def last_rungs(self, diagnosis: Diagnosis) -> LastRungs | None:
        """What follows where the names of a component end above the floor; None where they do not,
        of a vehicle, and where the work allowed is done before a law is found."""
        found, last = self.found, diagnosis.ladder[-1]
        if found is None:
            return None
        steps = (
            replace(
                step_of(found.workshop, rival.rung),
                added=("free law" if rival is found.free else rival.name,),
                comparison=comparison_of(found.workshop, rival.rung, floor=last.comparison.floor),
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
