"""The first rung's ranking: what became of every effect, each with its reason in one line."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from wheelhop.diagnose.ambiguity import Angles
from wheelhop.diagnose.diagnosis import Ranked, Step
from wheelhop.diagnose.judge import SIGNIFICANT
from wheelhop.diagnose.look import Candidate, Look, contradicted, summary_of
from wheelhop.diagnose.screen import Screened
from wheelhop.effects import Effect
from wheelhop.vehicle import Drive


def ranking(
    look: Look, angles: Angles, effects: Sequence[Effect], baseline: Step
) -> tuple[Ranked, ...]:
    """Every effect of the library on the first rung, best first; last those that do not apply."""
    return (*ranked_so_far(look, angles), *_not_applicable(look, effects, baseline))


def ranked_so_far(look: Look, angles: Angles) -> tuple[Ranked, ...]:
    """The effects that a look has screened, best first, and what is known of each by now."""
    confirmed = {c.id: c for c in look.candidates}
    order = [c.screened for c in look.candidates]
    order += [s for s in look.screened if s.variant.effect.id not in confirmed]
    return tuple(_ranked(s, confirmed.get(s.variant.effect.id), look, angles) for s in order)


def _not_applicable(look: Look, effects: Sequence[Effect], baseline: Step) -> list[Ranked]:
    """The effects screening left out, with the reason."""
    screened = {s.variant.effect.id for s in look.screened}
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


def _ranked(screened: Screened, candidate: Candidate | None, look: Look, angles: Angles) -> Ranked:
    effect = screened.variant.effect
    parameters: dict[str, float | str] = {}
    variant = screened.variant if candidate is None else candidate.variant
    if variant.choice:
        parameters["form"] = variant.choice
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
        evidence=candidate.rung.evidence - look.rung.evidence if candidate else None,
        p_value=candidate.p if candidate else None,
        ambiguous_with=angles.near(effect.id) if screened.score > 0 else (),
        parameters=parameters,
        reason=_reason(screened, candidate, look),
    )


def _reason(screened: Screened, candidate: Candidate | None, look: Look) -> str:
    chosen = look.chosen
    if candidate is None:
        if screened.score <= 0:
            return "its signature is not in the residual: no gain worth its parameters"
        return "screened: others explain far more"
    before, after = look.rung.error_judging, candidate.rung.error_judging
    change = f"error {percent(before)} → {percent(after)}"
    if candidate.beside:
        return f"accepted together with {candidate.beside}: {change}, p = {candidate.p:.1g}"
    if chosen is not None and candidate.id == chosen.id:
        return f"accepted: {change}, p = {candidate.p:.1g}"
    if not candidate.holds:
        return f"{_why_not_believed(candidate)}: {change}, p = {candidate.p:.1g}"
    if chosen is not None:
        best = percent(chosen.rung.error_judging)
        if after > chosen.rung.error_judging and percent(after) != best:
            return f"explains part: {change}, but {chosen.id} reaches {best}"
        less = chosen.rung.evidence - candidate.rung.evidence
        if less < 0.0:
            return f"{change}, but {chosen.id} leaves less of the runs"
        return f"{change}, but all runs speak for {chosen.id}: log evidence {less:.0f} more"
    return f"{change}, p = {candidate.p:.1g}"


def _why_not_believed(candidate: Candidate) -> str:
    if candidate.p >= SIGNIFICANT:
        return "not confirmed by held-out runs"
    if contradicted(candidate.rung, candidate.variant.effect):
        return "its numbers, run by run, are against its nature"
    return "takes nothing material out of the runs held out"


def percent(error: float) -> str:
    """An error as people read it."""
    return f"{100 * error:.{2 if error >= 0.01 else 3}f} %"
