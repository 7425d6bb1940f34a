"""What became of every effect, and why: ranking, what cannot be told apart, and sentences."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from wheelhop.compare import describe
from wheelhop.diagnose.diagnosis import Grounds, Limit, Ranked, Step
from wheelhop.diagnose.next_run import angle_deg
from wheelhop.diagnose.score import SIGNIFICANT
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.diagnose.search.look import contradicted, summary_of
from wheelhop.diagnose.search.scored import Candidate, Scored
from wheelhop.effects import Effect, Misstatement
from wheelhop.files.words import chance, listed
from wheelhop.fit import Fit
from wheelhop.vehicle import Drive

Array = NDArray[np.float64]

AMBIGUOUS_DEG = 20.0
"""Signatures closer than this differ by less than a third of their size."""


class Angles:
    """Angles between what effects change in the records of the runs fitted.

    Of two effects that were simulated in full it is what each fitted model changes, at the strength
    it was fitted with and with every other number where it then lies: a small friction looks like
    no damper, a damper that has grown to explain the residual may look much like friction. Of
    others it is the first-order signature, after everything the baseline could absorb has been
    taken out of it.
    """

    def __init__(
        self, base: Fit, screened: Sequence[Screened], candidates: Sequence[Candidate] = ()
    ) -> None:
        weight = base.believed * base.sigma**2
        stack = np.vstack([run.weighed[:, : run.derivatives.shared] for run in base.runs])
        inner = np.linalg.pinv(stack.T @ stack + weight, hermitian=True)
        self._signatures: dict[str, Array] = {}
        for item in screened:
            if any(part.any() for part in item.contribution.values()):
                whole = np.concatenate([item.contribution[run.bench.run.id] for run in base.runs])
                whole = whole - stack @ (inner @ (stack.T @ whole))
                self._signatures[item.id] = whole
        self._changes = {c.id: _change(base, c.rung.fit) for c in candidates if not c.beside}

    def between(self, first: str, second: str) -> float:
        """Angle on all runs, degrees, 0 to 90; 90 where one of them was not screened."""
        both = {first, second}
        for known in (self._changes, self._signatures):
            if both <= known.keys():
                return angle_deg(known[first], known[second])
        return 90.0

    def near(self, effect: str) -> tuple[tuple[str, float], ...]:
        """The effects whose change nearly coincides with this one's, nearest first."""
        others = (self._signatures | self._changes).keys() - {effect}
        angles = [(other, self.between(effect, other)) for other in sorted(others)]
        return tuple(sorted((a for a in angles if a[1] < AMBIGUOUS_DEG), key=lambda a: a[1]))


def _change(base: Fit, fitted: Fit) -> Array:
    """What a fitted model changes in the records of the base's runs, per their spread."""
    residual = {run.bench.run.id: run.residual for run in fitted.runs}
    return np.concatenate(
        [(run.residual - residual[run.bench.run.id]) / run.spread for run in base.runs]
    )


def ranking(
    scored: Scored, angles: Angles, effects: Sequence[Effect], baseline: Step
) -> tuple[Ranked, ...]:
    """Every effect of the library on the first rung, best first; last those that do not apply.
    None where the search was ended before it had screened any."""
    if not scored.screened:
        return ()
    return (*ranked_so_far(scored, angles), *_not_applicable(scored, effects, baseline))


def ranked_so_far(scored: Scored, angles: Angles) -> tuple[Ranked, ...]:
    """The effects screened beside a set, best first, and what is known of each by now."""
    confirmed = {c.id: c for c in scored.candidates}
    order = [c.screened for c in scored.candidates]
    order += [s for s in scored.screened if s.id not in confirmed]
    return tuple(_ranked(s, confirmed.get(s.id), scored, angles) for s in order)


def _not_applicable(scored: Scored, effects: Sequence[Effect], baseline: Step) -> list[Ranked]:
    """The effects screening left out, with the reason."""
    screened = {s.id for s in scored.screened}
    drives = {run.bench.drive for run in baseline.rung.fit.runs}
    return [
        Ranked(
            effect=effect.id,
            place=effect.place,
            screened_error=None,
            confirmed_error=None,
            validated_error=None,
            evidence=None,
            p_value=None,
            ambiguous_with=(),
            parameters={},
            reason=f"does not apply: {why_not(effect, drives)}",
        )
        for effect in effects
        if effect.id not in screened
    ]


def why_not(effect: Effect, drives: Collection[Drive]) -> str:
    """In a few words, why screening leaves an effect out."""
    if "rig" in drives and not effect.on_rig:
        return "it acts on a vehicle, not on one component on a rig"
    if "rig" not in drives and not effect.on_vehicle:
        return "only one component on a rig tells it from its likes; wheelhop law finds its force"
    if "rig" not in drives and "road" not in drives and effect.needs_road:
        return "it acts upstream of the axle, and no run drives over a known track"
    return "the vehicle, its speed and the channels give it nothing to act on"


def _ranked(
    screened: Screened, candidate: Candidate | None, scored: Scored, angles: Angles
) -> Ranked:
    effect = screened.variant.effect
    parameters: dict[str, float | str] = {}
    form = screened.variant.choice if candidate is None else candidate.form
    if form:
        parameters["form"] = form
    if candidate is None:
        parameters |= {**screened.variant.shapes, **screened.amplitudes}
    else:
        parameters |= candidate.rung.model.theta(effect)
        parameters |= summary_of(candidate.rung, effect)
    return Ranked(
        effect=effect.id,
        place=effect.place,
        screened_error=screened.error,
        confirmed_error=candidate.rung.error_fit if candidate else None,
        validated_error=candidate.rung.error_validate if candidate else None,
        evidence=candidate.rung.evidence - scored.rung.evidence if candidate else None,
        p_value=candidate.p if candidate else None,
        ambiguous_with=angles.near(effect.id) if screened.score > 0 else (),
        parameters=parameters,
        reason=_reason(screened, candidate, scored),
    )


def _reason(screened: Screened, candidate: Candidate | None, scored: Scored) -> str:
    chosen = scored.chosen
    if candidate is None:
        if screened.score <= 0:
            return "its signature is not in the residual: no gain worth its parameters"
        if any(c.rung.error_fit < screened.error for c in scored.candidates):
            return "screened: others explain far more"
        return "screened, not simulated"
    before, after = scored.rung.error_judging, candidate.rung.error_judging
    change = f"error {percent(before)} → {percent(after)}"
    odds = f"p = {chance(candidate.p)}".replace("= <", "<")
    if candidate.beside:
        return f"accepted together with {candidate.beside}: {change}, {odds}"
    if chosen is not None and candidate.id == chosen.id:
        return f"accepted: {change}, {odds}"
    if not candidate.holds:
        return f"{_why_not_believed(candidate)}: {change}, {odds}"
    if chosen is not None:
        best = percent(chosen.rung.error_judging)
        if after > chosen.rung.error_judging and percent(after) != best:
            return f"explains part: {change}, but {chosen.id} reaches {best}"
        less = chosen.rung.evidence - candidate.rung.evidence
        if less < 0.0:
            return f"{change}, but {chosen.id} leaves less of the runs"
        return f"{change}, but all runs speak for {chosen.id}: log evidence {less:.0f} more"
    return f"{change}, {odds}"


def _why_not_believed(candidate: Candidate) -> str:
    if candidate.p >= SIGNIFICANT:
        if candidate.rung.validation is None:
            return "not confirmed by its runs, each left out of the fit in turn"
        return "not confirmed by held-out runs"
    if contradicted(candidate.rung, candidate.effect):
        return "its numbers, run by run, are against its nature"
    return "takes nothing material out of the runs held out"


def percent(error: float) -> str:
    """An error as people read it."""
    return f"{100 * error:.{2 if error >= 0.01 else 3}f} %"


def _of_the_law(steps: Sequence[Step]) -> str:
    """What is left is no more than laws of one name differ by."""
    last = steps[-1]
    share = (last.unexplained / last.lacked) ** 0.5
    return (
        f"{percent(last.rung.error)} is left, {last.over_floor:.2f} times the floor and"
        f" {100 * share:.0f} % of what the baseline lacks. Machines differ from textbook laws by"
        f" about as much; {_law_command(last)} shows how this one does."
    )


def _of_what_is_expected(last: Step) -> str:
    """What is left is no more than a right model may leave, though more than noise."""
    return (
        f"{percent(last.rung.error_judging)} is left, {last.over_floor:.2f} times the floor. With"
        f" {last.comparison.floor.beside_noise} a right model may leave up to"
        f" {percent(last.expected)}."
    )


def _law_command(step: Step) -> str:
    known = [e.id for e in step.rung.model.effects if not isinstance(e, Misstatement)]
    return f"wheelhop law --with {' '.join(known)}" if known else "wheelhop law"


IDEAS = 3
"""So many physical ideas are named whose signature comes nearest to what nothing explains."""

LEAST_LIKENESS = 0.03
"""An effect that could explain less than this share of the rest is no idea."""


def explanation(
    verdict: Sequence[str],
    steps: Sequence[Step],
    first: Scored,
    last: Scored,
    grounds: Grounds,
    limits: Sequence[Limit],
    on_bounds: Sequence[str],
) -> tuple[str, ...]:
    """What was found and, where something is left, what it looks like; `on_bounds` are numbers of
    effects that sit on their bounds."""
    lines = []
    if tuple(verdict) == ("none",):
        lines += _none(steps[0], first, last, grounds, limits)
    for before, after in pairwise(steps):
        lines.append(_fall(before, after))
    small = [c for c in last.candidates if c.holds and c.id not in verdict]
    if small and len(steps) > 1:
        each = [f"{c.id} (error to {percent(c.rung.error_judging)})" for c in small]
        lines.append(
            "Small things besides, which lower the error by little beside what the first step did:"
            f" {listed(each)}; --all adds them."
        )
    if on_bounds:
        plural = "s" * (len(on_bounds) == 1)
        lines.append(
            f"{listed(on_bounds)} sit{plural} on the bound of what is possible: a law that the"
            " library lacks may be what these runs show."
        )
    left_over = verdict[-1] == "unknown" and steps[-1].above_floor
    if left_over:
        lines.append(
            f"The residual stays at {steps[-1].over_floor:.2f} times the floor and no effect of the"
            " library is confirmed as the cause:"
        )
        lines.extend(describe(steps[-1].comparison.breakdown))
        lines.extend(_nearest(first, last))
        lines.extend(_held_out_only(steps[-1]))
        if not steps[-1].comparison.floor.of_laws:
            lines.append(
                f"{_law_command(steps[-1])} looks for the missing force: where it acts, how it"
                " looks, which name comes nearest and what to record next."
            )
    elif grounds.louder:
        lines.append(
            f"{steps[-1].over_floor:.3f} times the floor is left, as much in every run, whatever"
            " track and speed: that is noise, and more of it than stated."
        )
    elif steps[-1].unexplained > 0.0:
        lines.append(_of_the_law(steps))
    elif steps[-1].comparison.floor.beside_noise:
        lines.append(_of_what_is_expected(steps[-1]))
    for effect in steps[-1].rung.model.effects:
        if isinstance(effect, Misstatement):
            remedy = effect.remedy(steps[-1].rung.model.theta(effect))
            lines.append(f"What to correct in campaign.toml: {remedy}.")
    if not left_over and len(steps) > 1:
        lines.extend(caveats(steps[-1]))
        lines.append("Where the baseline failed:")
        lines.extend(describe(steps[0].comparison.breakdown))
    return tuple(lines)


def _none(
    baseline: Step, first: Scored, last: Scored, grounds: Grounds, limits: Sequence[Limit]
) -> list[str]:
    if grounds.more_than_noise:
        return [
            f"The baseline comes to {baseline.over_floor:.3f} times the floor. Noise hardly leaves"
            f" that (p = {grounds.by_chance:.1g}): there is a little more of it than stated, or"
            " something faint is missing that these runs do not name.",
            *_nearest(first, last),
        ]
    lines = [f"The baseline explains the records down to {baseline.left_to}."]
    hardly = [limit.effect for limit in limits if limit.unseen > 0.5]
    if hardly:
        lines.append(
            f"These runs would hardly have shown {listed(hardly)}: other tracks or speeds would."
        )
    return lines


def caveats(step: Step) -> list[str]:
    """Why a model that lacks nothing may leave the held-out runs above the floor, if it does."""
    if step.rung.update is None or step.above_floor:
        return []
    floor = step.comparison.floor
    if step.rung.error_validate <= floor.expected_validate * (1.0 + 2.0 * floor.tolerance):
        return []
    foreseen = step.rung.error_validate / floor.error_validate
    return [
        f"Held-out runs are foreseen to {foreseen:.2f} times the floor, because the fitted ones do"
        " not tell the vehicle's numbers better: within their uncertainty the same model comes to"
        f" {step.over_floor:.2f} times the floor."
    ]


def _fall(before: Step, after: Step) -> str:
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
    if rung.validation is None or rung.error_fit > floor.expected_fit * (1.0 + floor.tolerance):
        return []
    loudest = max(rung.validation.runs, key=lambda run: run.rss)
    return [
        "The fitted runs do not show it, so nothing could be fitted to it: give"
        f' {loudest.bench.run.id} the role "fit", or record another like it.'
    ]


def _nearest(first: Scored, last: Scored) -> list[str]:
    """The ideas whose first-order signature takes most out of the residual, and what came of them:
    none is in the verdict."""
    left = last.rung.fit.error
    shares = [
        (1.0 - (s.error / left) ** 2, s.variant.effect)
        for s in last.screened
        if s.score > 0 and left > 0
    ]
    ideas = [
        f"{effect.id} ({effect.title}; {100 * share:.0f} %, {_came_of(effect.id, first, last)})"
        for share, effect in sorted(shares, key=lambda item: -item[0])[:IDEAS]
        if share > LEAST_LIKENESS
    ]
    if not ideas:
        return ["No effect's signature resembles it."]
    return [
        "To first order it resembles most, with the share of it that each would take:"
        f" {'; '.join(ideas)}."
    ]


def _came_of(effect: str, first: Scored, last: Scored) -> str:
    """What became of an idea in full simulation, in a few words."""
    tried = next((c for c in last.candidates if c.id == effect), None)
    if tried is not None:
        why = "it holds" if tried.holds else _why_not_believed(tried)
        return f"in full {percent(tried.rung.error_judging)} is left: {why}"
    alone = next((c for c in first.candidates if c.id == effect), None)
    if alone is not None:
        return f"alone it leaves {percent(alone.rung.error_judging)}"
    return "not simulated in full"
