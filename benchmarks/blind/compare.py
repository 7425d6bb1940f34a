"""Two versions of the program, asked the same: what they say otherwise, and how long they take."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, isfinite, log, nan

from benchmarks.blind.score import Outcome

Pair = tuple[Outcome, Outcome]
"""What was said of one campaign before and after."""


def differing(pairs: Sequence[Pair]) -> list[Pair]:
    """Those with another verdict."""
    return [pair for pair in pairs if pair[0].verdict != pair[1].verdict]


def text(pairs: Sequence[Pair]) -> str:
    """A line for every other verdict, then what both have right and the ratios, after / before."""
    other = differing(pairs)
    lines = [_line(*pair) for pair in other]
    right = [sum(outcome.passed for outcome in side) for side in zip(*pairs, strict=True)]
    changed = max(abs(before.confidence - after.confidence) for before, after in pairs)
    lines += [
        f"{len(pairs)} campaigns asked of both: {len(pairs) - len(other)} verdicts the same",
        f"right: {right[0]} before, {right[1]} after",
        f"largest change of confidence: {changed:.3f}",
    ]
    for label, field in (
        ("error / floor", "error_over_floor"),
        ("seconds", "seconds"),
        ("CPU seconds", "cpu_seconds"),
    ):
        both = [(getattr(a, field), getattr(b, field)) for a, b in pairs]
        lines.append(f"{label}, geometric mean, after / before: {_ratio(both):.3f}")
    return "\n".join(lines) + "\n"


def _line(before: Outcome, after: Outcome) -> str:
    said = [f"{' + '.join(o.verdict) or 'no answer'} ({o.confidence:.2f})" for o in (before, after)]
    judged = {(True, False): "  WORSE", (False, True): "  better"}
    return f"{before.name}: {said[0]} -> {said[1]}{judged.get((before.passed, after.passed), '')}"


def _ratio(both: Sequence[tuple[float, float]]) -> float:
    logs = [log(b / a) for a, b in both if a > 0.0 and b > 0.0 and isfinite(a) and isfinite(b)]
    return exp(sum(logs) / len(logs)) if logs else nan
