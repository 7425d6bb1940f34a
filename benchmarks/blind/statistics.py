"""What many outcomes say together: rates, reliability, errors, times, and the targets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, isfinite, sqrt

import numpy as np

from benchmarks.blind.reality import REALITY
from benchmarks.blind.score import FAR, SINGLE, Outcome

Z = 1.96  # two-sided 95 %

MIDDLE = (0.1, 0.9)
"""Confidence that is neither a claim nor a refusal: too rare to be judged tenth by tenth."""


@dataclass(frozen=True)
class Rate:
    """A share of right answers with its 95 % interval (Wilson's score interval: E. B. Wilson,
    Probable inference, J. Am. Stat. Assoc. 22 (1927) 209) and its target."""

    label: str
    right: int
    of: int
    target: float
    at_least: bool = True  # or at most

    @property
    def rate(self) -> float:
        """Observed; NaN where nothing was asked."""
        return self.right / self.of if self.of else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """Of the true rate."""
        return wilson(self.right, self.of)

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None where nothing was asked."""
        if not self.of:
            return None
        return self.rate >= self.target if self.at_least else self.rate <= self.target


@dataclass(frozen=True)
class Figure:
    """A number that should not exceed its target."""

    label: str
    value: float
    target: float
    digits: int = 2

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None where nothing was asked."""
        return None if np.isnan(self.value) else self.value <= self.target


@dataclass(frozen=True)
class Decile:
    """Verdicts given with about the same confidence, and how many of their first entries hold."""

    low: float
    high: float
    claimed: float  # mean
    right: int
    of: int

    @property
    def met(self) -> bool:
        """Within 10 points, as far as so few verdicts can tell."""
        low, high = wilson(self.right, self.of)
        return low - RELIABLE <= self.claimed <= high + RELIABLE

    @property
    def within(self) -> bool:
        """Within 10 points as it stands."""
        return abs(self.claimed - self.right / self.of) <= RELIABLE + 1e-9


RELIABLE = 0.10


def wilson(right: int, of: int) -> tuple[float, float]:
    """95 % interval of a probability, from `right` successes."""
    if of == 0:
        return 0.0, 1.0
    p, spread = right / of, Z**2 / of
    middle = (p + spread / 2.0) / (1.0 + spread)
    half = Z / (1.0 + spread) * sqrt(p * (1.0 - p) / of + spread / (4.0 * of))
    return max(middle - half, 0.0), min(middle + half, 1.0)


def rates(outcomes: Sequence[Outcome]) -> list[Rate]:
    """The table's rates with their targets."""

    def rate(
        label: str,
        kinds: str,
        right: Callable[[Outcome], bool],
        target: float,
        at_least: bool = True,
    ) -> Rate:
        chosen = [o for o in outcomes if o.kind in kinds.split()]
        return Rate(label, sum(map(right, chosen)), len(chosen), target, at_least)

    real = [kind for kind in REALITY if any(o.kind == kind for o in outcomes)]
    label = "in reality: a wrong name above 50 %"
    told = [o for o in outcomes if o.tells_mass]
    near = sum(abs(o.mass_off) <= FAR for o in told)
    intervals = [o for o in outcomes if o.tells_intervals]
    inside = int(sum(o.held for o in intervals))
    stated = int(sum(o.intervals for o in intervals))
    wrong = rate(label, " ".join(real), lambda o: o.is_false_claim, 0.05, at_least=False)
    return [
        rate("clear, single: top-1", "clear", lambda o: o.passed, 0.97),
        rate("clear, single: top-3", "clear", lambda o: o.among_three, 0.99),
        rate("clear, single: named alone", "clear", lambda o: o.exact, 0.0),
        rate("weak, single: top-1", "weak", lambda o: o.passed, 0.85),
        rate("weak, single: top-3", "weak", lambda o: o.among_three, 0.95),
        rate("weak, single: named alone", "weak", lambda o: o.exact, 0.0),
        rate("faint, single: top-1", "faint", lambda o: o.passed, 0.0),
        rate("false alarms on none", "none", lambda o: not o.passed, 0.03, at_least=False),
        rate("outside the library", "outside", lambda o: o.passed, 0.90),
        rate("taken out of the library", "without", lambda o: o.passed, 0.90),
        rate("two: both, no third", "two", lambda o: o.passed, 0.85),
        rate("four: three or more, none wrong", "four", lambda o: o.passed, 0.70),
        *(_everything(outcomes) if any(o.kind == "everything" for o in outcomes) else []),
        *(rate(f"in reality: {kind}", kind, lambda o: o.passed, 0.0) for kind in real),
        *([wrong] if real else []),
        *([Rate("all named: body mass within 3 sd", near, len(told), 0.95)] if told else []),
        *([Rate("forces and stiffnesses within 2 sd", inside, stated, 0.90)] if stated else []),
    ]


def _everything(outcomes: Sequence[Outcome]) -> list[Rate]:
    asked = [o for o in outcomes if o.kind == "everything"]
    hidden, nothing = [o for o in asked if o.hidden], [o for o in asked if not o.hidden]
    first, wrong = (sum(o.passed for o in hidden), sum(o.is_false_claim for o in asked))
    invented = sum(o.is_false_claim for o in nothing)
    return [
        Rate("everything: the hidden one first", first, len(hidden), 0.90),
        Rate("everything: a wrong name above 50 %", wrong, len(asked), 0.05, at_least=False),
        Rate(
            "everything, nothing hidden: such a name", invented, len(nothing), 0.0, at_least=False
        ),
    ]


def figures(outcomes: Sequence[Outcome], short: bool) -> list[Figure]:
    """Errors over the true model's floor, and times."""
    single = [o.error_over_floor for o in outcomes if o.kind in (*SINGLE, "none")]
    every = [o.error_over_floor for o in outcomes if o.kind in ("two", "four")]
    seconds = [o.seconds for o in outcomes if o.kind in SINGLE]
    middle, longest = (inf, inf) if short else (30.0, 60.0)
    spent = [o.cpu_seconds for o in outcomes if o.kind == "everything"]
    of_everything = [
        Figure("CPU seconds, everything: median", _median(spent), 20.0, 1),
        Figure("CPU seconds, everything: longest", max(spent, default=np.nan), 60.0, 1),
    ]
    return [
        Figure("error / floor, single and none: median", _median(single), 1.02, 3),
        Figure("error / floor, single and none: worst", max(single, default=np.nan), 1.3, 3),
        Figure("error / floor, two and four: median", _median(every), inf, 3),
        Figure("error / floor, two and four: worst", max(every, default=np.nan), inf, 3),
        Figure("seconds per campaign, single: median", _median(seconds), middle, 1),
        Figure("seconds per campaign, single: longest", max(seconds, default=np.nan), longest, 1),
        *(of_everything if spent else []),
    ]


def reliability(outcomes: Sequence[Outcome]) -> list[Decile]:
    """All answers by tenths of confidence, then those of the middle together; empty ones are left
    out."""
    tenths = [(tenth / 10.0, (tenth + 1) / 10.0) for tenth in range(10)]
    table = []
    for low, high in (*tenths, MIDDLE):
        inside = [
            o for o in outcomes if low <= o.confidence < high or (o.confidence == 1.0 == high)
        ]
        if inside:
            claimed = float(np.mean([o.confidence for o in inside]))
            right = sum(o.first_is_right for o in inside)
            table.append(Decile(low, high, claimed, right, len(inside)))
    return table


def confusion(outcomes: Sequence[Outcome]) -> dict[str, Counter[str]]:
    """What was said first, by what was true: single effects, none, and whatever has no name."""
    rows: dict[str, Counter[str]] = {}
    for o in outcomes:
        if o.kind in ("two", "four"):
            continue
        truth = o.hidden[0] if o.hidden else "none"
        if o.kind == "without":
            truth = f"without {truth}"
        rows.setdefault(truth, Counter())[o.verdict[0] if o.verdict else "no answer"] += 1
    return rows


def _median(values: Sequence[float]) -> float:
    finite = [v for v in values if isfinite(v)]
    return float(np.median(values)) if finite else float("nan")
