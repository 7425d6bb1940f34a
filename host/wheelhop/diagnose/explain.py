"""The verdict in sentences."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from wheelhop.compare import describe
from wheelhop.diagnose.diagnosis import Grounds, Step
from wheelhop.diagnose.look import Look
from wheelhop.diagnose.ranking import percent

IDEAS = 3
"""So many physical ideas are named whose signature comes nearest to what nothing explains."""

LEAST_LIKENESS = 0.03
"""An effect that could explain less than this share of the rest is no idea."""


def explanation(
    verdict: Sequence[str], steps: Sequence[Step], last: Look, grounds: Grounds
) -> tuple[str, ...]:
    """What was found and, where something is left, what it looks like."""
    lines = []
    if tuple(verdict) == ("none",):
        lines += _none(steps[0], last, grounds)
    for before, after in pairwise(steps):
        lines.append(_change(before, after))
    if verdict[-1] == "unknown":
        lines.append(
            f"The residual stays at {steps[-1].over_floor:.2f} times the floor and no effect of the"
            " library explains it:"
        )
        lines.extend(describe(steps[-1].comparison.breakdown))
        lines.extend(_nearest(last))
        lines.extend(_held_out_only(steps[-1]))
        known = [e.id for e in steps[-1].rung.model.effects if not e.is_belief]
        beside = f" --with {' '.join(known)}" if known else ""
        lines.append(
            f"wheelhop law{beside} looks for the missing force: where it acts, how it looks,"
            " which name comes nearest and what to record next."
        )
    for effect in steps[-1].rung.model.effects:
        if remedy := effect.remedy(steps[-1].rung.model.theta(effect)):
            lines.append(f"What to correct in campaign.toml: {remedy}.")
    if verdict[-1] != "unknown" and len(steps) > 1:
        lines.extend(caveats(steps[-1]))
        lines.append("Where the baseline failed:")
        lines.extend(describe(steps[0].comparison.breakdown))
    return tuple(lines)


def _none(baseline: Step, last: Look, grounds: Grounds) -> list[str]:
    if not grounds.more_than_noise:
        return ["The baseline explains the records down to the noise."]
    return [
        f"The baseline comes to {baseline.over_floor:.3f} times the floor. Noise hardly leaves that"
        f" (p = {grounds.by_chance:.1g}): there is a little more of it than stated, or something"
        " faint is missing that these runs do not name.",
        *_nearest(last),
    ]


def caveats(step: Step) -> list[str]:
    """Why a model that lacks nothing may leave the held-out runs above the floor, if it does."""
    if step.rung.update is None or step.above_floor:
        return []
    floor = step.comparison.floor
    foreseen = step.rung.error_validate / floor.error_validate
    if foreseen <= 1.0 + 2.0 * floor.tolerance:
        return []
    return [
        f"Held-out runs are foreseen to {foreseen:.2f} times the floor, because the fitted ones do"
        " not tell the vehicle's numbers better: within their uncertainty the same model comes to"
        f" {step.over_floor:.2f} times the floor."
    ]


def _change(before: Step, after: Step) -> str:
    added = [name for name in after.added if name not in before.added]
    taken = [name for name in before.added if name not in after.added]
    change = f"the error from {percent(before.rung.error)} to {percent(after.rung.error)}."
    if added and taken:
        return f"Putting {', '.join(added)} in place of {', '.join(taken)} changes {change}"
    if not added:
        return f"{', '.join(taken)} is idle."
    verb = "lowers" if after.rung.error < before.rung.error else "raises"
    return f"Adding {', '.join(added)} {verb} {change}"


def _held_out_only(step: Step) -> list[str]:
    """Where only held-out runs show the rest, what would let it be found."""
    floor, rung = step.comparison.floor, step.rung
    if rung.validation is None or rung.error_fit > floor.error_fit * (1.0 + floor.tolerance):
        return []
    loudest = max(rung.validation.runs, key=lambda run: run.rss)
    return [
        "The fitted runs do not show it, so nothing could be fitted to it: give"
        f' {loudest.bench.run.id} the role "fit", or record another like it.'
    ]


def _nearest(last: Look) -> list[str]:
    """The ideas whose first-order signature takes most out of the residual, none of them enough."""
    left = last.rung.fit.error
    shares = [
        (1.0 - (s.error / left) ** 2, s.variant.effect)
        for s in last.screened
        if s.score > 0 and left > 0
    ]
    ideas = [
        f"{effect.id} ({effect.title}; {100 * share:.0f} %)"
        for share, effect in sorted(shares, key=lambda item: -item[0])[:IDEAS]
        if share > LEAST_LIKENESS
    ]
    if not ideas:
        return ["No effect's signature resembles it."]
    return [
        f"To first order it resembles most, with the share of it explained: {'; '.join(ideas)}."
    ]
