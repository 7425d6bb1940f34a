"""Was the answer right? One outcome per case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import isnan, nan
from typing import Any

from benchmarks.blind.everything import is_there
from benchmarks.blind.intervals import held
from benchmarks.blind.plan import Case
from benchmarks.blind.reality import REALITY

SINGLE = ("clear", "weak", "faint")
"""Kinds that hide one effect of the library."""

CONFIDENT = 0.5
"""Below this, a wrong first entry is no claim."""

MASS = "body.mass_kg"
"""Of the vehicle's numbers the one that stands for the common scale of masses and forces."""

FAR = 3.0
"""Standard deviations beyond which a number is not what it is said to be."""


@dataclass(frozen=True)
class Outcome:
    """What was true, what was said, and what follows; a crash is an answer that is wrong."""

    name: str
    kind: str
    hidden: tuple[str, ...]
    preset: str
    verdict: tuple[str, ...]
    confidence: float
    ranking: tuple[str, ...]  # ids, best first
    baseline_over_floor: float
    error_over_floor: float  # last rung's error_validate over that of the true model (its noise)
    seconds: float
    complaint: str = ""
    cpu_seconds: float = nan  # of all threads
    mass_off: float = nan  # body mass less the true one, per standard deviation that was stated
    held: float = nan  # so many 2-sd intervals of forces and stiffnesses hold the truth
    intervals: float = nan  # of so many

    @property
    def named(self) -> tuple[str, ...]:
        """Effects in the verdict."""
        return tuple(v for v in self.verdict if v not in ("none", "unknown"))

    @property
    def first_is_right(self) -> bool:
        """What `confidence` is about: an effect that is there, or rightly none or unknown."""
        if not self.verdict:
            return False
        if self.kind in ("outside", "without"):
            return self.verdict[0] == "unknown"
        if self.kind == "everything" and not self.hidden:
            return self.verdict[0] in ("none", "unknown") or is_there(self.verdict[0])
        return self.verdict[0] in (self.hidden or ("none",)) or self._is_belief(self.verdict[0])

    @property
    def first_is_hidden(self) -> bool:
        """Whether the verdict begins with what is hidden."""
        return self.verdict[:1] == self.hidden[:1]

    def _is_belief(self, name: str) -> bool:
        """Whether a name is that of a belief, or of a small imperfection, which is there in every
        campaign of this kind."""
        if self.kind == "everything":
            return is_there(name)
        belief = REALITY[self.kind].belief if self.kind in REALITY else ""
        return bool(belief) and name.startswith(belief)

    @property
    def is_false_claim(self) -> bool:
        """Says with confidence what is not there, be it beside what is."""
        invented = [n for n in self.named if n not in self.hidden and not self._is_belief(n)]
        return bool(invented) and self.confidence > CONFIDENT

    @property
    def exact(self) -> bool:
        """All that is hidden is named, and nothing else."""
        return set(self.named) == set(self.hidden) and bool(self.verdict)

    @property
    def tells_mass(self) -> bool:
        """Whether the mass counts: all is named, what was believed of it is right, and the answer
        says it."""
        return self.exact and self.kind != "mass-believed" and not isnan(self.mass_off)

    @property
    def tells_intervals(self) -> bool:
        """Whether its intervals count: the first entry is right, and one hidden effect is clear."""
        told = self.kind in ("clear", "everything") and bool(self.hidden)
        return told and self.first_is_hidden and not isnan(self.intervals)

    @property
    def among_three(self) -> bool:
        """The one hidden effect is among the first three of the ranking."""
        return set(self.hidden) <= set(self.ranking[:3])

    @property
    def passed(self) -> bool:
        """As the table counts: see README.md."""
        if not self.verdict:
            return False
        if self.kind in SINGLE:
            return self.first_is_right
        if self.kind == "everything":
            return self.first_is_hidden if self.hidden else not self.is_false_claim
        if self.kind == "none":
            return self.verdict == ("none",)
        if self.kind == "two":
            return self.exact
        if self.kind in REALITY:
            return {n for n in self.named if not self._is_belief(n)} == set(self.hidden)
        if self.kind == "four":
            return len(self.named) >= 3 and set(self.named) <= set(self.hidden)
        return self.verdict[0] in ("unknown", "none") or self.confidence < CONFIDENT

    def to_json(self) -> dict[str, Any]:
        """Plain, with what follows from it."""
        return asdict(self) | {
            "passed": self.passed,
            "exact": self.exact,
            "first_is_right": self.first_is_right,
        }


def outcome(
    case: Case,
    made: Mapping[str, Any],
    ended: Mapping[str, Any],
    diagnosis: Mapping[str, Any] | None,
    truth: Mapping[str, Any],
) -> Outcome:
    """From how the case was made, how the program ended, what it wrote, and the truth."""
    spoke = diagnosis is not None and ended["status"] == 0
    said = diagnosis if spoke and diagnosis is not None else {}
    ladder = said.get("ladder") or [{}]
    error = ladder[-1].get("error_validate")
    mass, deviation = (ladder[-1].get(k, {}).get(MASS) for k in ("parameters", "uncertainties"))
    mass_kg = truth["vehicle_true"]["body"]["mass_kg"]
    inside, intervals = held(ladder[-1], truth)
    return Outcome(
        name=case.name,
        kind=case.kind,
        hidden=case.hidden,
        preset=case.preset,
        verdict=tuple(said.get("verdict", ())),
        confidence=float(said.get("confidence", 1.0)),
        ranking=tuple(r["effect"] for r in said.get("ranking", ())),
        baseline_over_floor=float(made["baseline_over_floor"]),
        error_over_floor=float("inf") if error is None else error / made["oracle_rel_validate"],
        seconds=float(ended["seconds"]),
        complaint=str(ended["complaint"]),
        cpu_seconds=float(ended.get("cpu_seconds", nan)),  # older ones do not say it
        mass_off=(mass - mass_kg) / deviation if mass and deviation else nan,
        held=inside if intervals else nan,
        intervals=intervals or nan,
    )
