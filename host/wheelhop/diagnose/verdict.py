"""The verdict: what was accepted, how sure that is, and why everything else was not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import exp, inf

from wheelhop.compare import describe
from wheelhop.diagnose.ambiguity import Angles
from wheelhop.diagnose.baseline import comparison_of
from wheelhop.diagnose.confirm import Rung
from wheelhop.diagnose.diagnosis import Diagnosis, Ranked, Step
from wheelhop.diagnose.judge import log_odds, p_value
from wheelhop.diagnose.screen import Screened
from wheelhop.effects import Effect
from wheelhop.fit import Workshop
from wheelhop.simulate import Model

CEILING = 0.99
"""No verdict on a single campaign is surer than this."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """An effect simulated in full: its log-odds over the rung's model on held-out runs, of how many
    effects tried it is one, and whether that is significant and material."""

    screened: Screened
    rung: Rung
    log_odds: float
    tried: int
    holds: bool

    @property
    def id(self) -> str:
        """The effect's id."""
        return self.screened.variant.effect.id

    @property
    def p(self) -> float:
        """Chance that any of the effects tried does so well without being there."""
        return p_value(self.log_odds, self.tried)


@dataclass(frozen=True, eq=False)
class Look:
    """What one look at a rung's residual found: all effects screened, those simulated in full
    (the chosen one first), and the one to accept, or none."""

    rung: Rung
    screened: tuple[Screened, ...]
    candidates: tuple[Candidate, ...]
    chosen: Candidate | None


def step_of(workshop: Workshop, rung: Rung) -> Step:
    """A rung with its parameters and its comparison with the records."""
    names = tuple(effect.id for effect in rung.model.effects)
    return Step(names, rung, parameters_of(rung), comparison_of(workshop, rung))


def parameters_of(rung: Rung) -> dict[str, tuple[float, float]]:
    """Every fitted number and its standard deviation; switches, and numbers that stand for what is
    free in each run, have none (NaN)."""
    values, fitted = rung.model.values, rung.fit
    found = {f.name: (values[f.name], fitted.uncertainty(f.name)) for f in fitted.shared}
    for effect in rung.model.effects:
        fixed = rung.model.theta(effect) | _summary(rung.model, rung, effect)
        for name, value in fixed.items():
            found.setdefault(f"{effect.id}.{name}", (value, float("nan")))
    return found


def _summary(model: Model, rung: Rung, effect: Effect) -> dict[str, float]:
    return effect.summary(
        [
            (run.bench.simulator.setting, model.theta(effect, run.bench.run.id))
            for run in rung.fit.runs
            if run.bench.simulator.acts(effect)
        ]
    )


def conclude(
    steps: Sequence[Step], first: Look, last: Look, effects: Sequence[Effect]
) -> Diagnosis:
    """The diagnosis from the ladder's steps, the first look, the last one, and the library."""
    angles = Angles(first.rung.fit, first.screened)
    accepted = steps[-1].added
    unexplained = _unexplained(steps[-1])
    verdict = (*accepted, "unknown") if unexplained else accepted or ("none",)
    next_run = None
    if first.chosen is not None:
        near = angles.near(first.chosen.id)
        next_run = angles.next_run(first.chosen.id, near[0][0]) if near else None
    return Diagnosis(
        verdict=verdict,
        confidence=_confidence(verdict, steps[-1], first, last),
        ranking=(*_ranking(first, angles), *_not_applicable(first, effects, steps[0])),
        ladder=tuple(steps),
        next_run=next_run,
        explanation=tuple(_explanation(verdict, steps)),
    )


def _unexplained(step: Step) -> bool:
    """Whether held-out runs (fitted ones, if there are no others) stay above the floor."""
    return _over_floor(step) > 1.0 + 2.0 * step.comparison.floor.tolerance


def _over_floor(step: Step) -> float:
    floor = step.comparison.floor
    if step.rung.validation is None:
        return step.rung.error_fit / floor.error_fit
    return step.rung.error_validate / floor.error_validate


def _confidence(verdict: Sequence[str], last_step: Step, first: Look, last: Look) -> float:
    """That the verdict's first entry is right.

    For an effect: the odds against the best of its rivals, times the chance that it is not
    mistaken altogether; with something unexplained left, less by as many times as the error stays
    above the floor: what explains that may explain the rest too. For "none": how far the likeliest
    effect is from being accepted. For "unknown": how far the residual is above the floor's own
    uncertainty.
    """
    if verdict[0] == "unknown":
        excess = _over_floor(last_step) - 1.0
        return CEILING * (1.0 - exp(-excess / last_step.comparison.floor.tolerance))
    if verdict[0] == "none":
        closest = min((c.p for c in last.candidates), default=1.0)
        return CEILING * (0.5 + 0.5 * min(1.0, closest / 0.1))
    accepted = next((c for c in first.candidates if c.id == verdict[0]), None)
    if accepted is None:
        return 0.5 * CEILING
    rivals = [c for c in first.candidates if c.id not in verdict]
    at_floor = "unknown" not in verdict
    odds = min((_odds(c.rung, accepted.rung, at_floor) for c in rivals), default=inf)
    beaten = 1.0 / (1.0 + exp(-min(max(odds, -700.0), 700.0)))
    sure = CEILING * beaten * (1.0 - accepted.p)
    return sure if at_floor else sure / _over_floor(last_step)


def _odds(rival: Rung, accepted: Rung, at_floor: bool) -> float:
    """Logarithm of the odds for the accepted model.

    Once the residual is down at the white noise of the sensors, the evidence counts in full; while
    something unexplained is left in it, only what whole seconds of held-out runs say.
    """
    return accepted.evidence - rival.evidence if at_floor else log_odds(rival, accepted)


def _ranking(look: Look, angles: Angles) -> list[Ranked]:
    confirmed = {c.id: c for c in look.candidates}
    order = [c.screened for c in look.candidates]
    order += [s for s in look.screened if s.variant.effect.id not in confirmed]
    return [_ranked(s, confirmed.get(s.variant.effect.id), look, angles) for s in order]


def _not_applicable(look: Look, effects: Sequence[Effect], baseline: Step) -> list[Ranked]:
    """The effects screening left out, with the reason."""
    screened = {s.variant.effect.id for s in look.screened}
    on_road = any(run.bench.simulator.setting.on_road for run in baseline.rung.fit.runs)
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
            reason=f"does not apply: {why_not(effect, on_road)}",
        )
        for effect in effects
        if effect.id not in screened
    ]


def why_not(effect: Effect, on_road: bool) -> str:
    """In a few words, why screening leaves an effect out."""
    if effect.needs_road and not on_road:
        return "it acts upstream of the axle, and no run drives over a known track"
    return "the vehicle, its speed and the channels give it nothing to act on"


def _ranked(screened: Screened, candidate: Candidate | None, look: Look, angles: Angles) -> Ranked:
    effect = screened.variant.effect
    parameters: dict[str, float | str] = {}
    if screened.variant.choice:
        parameters["form"] = screened.variant.choice
    if candidate is None:
        parameters |= {**screened.variant.shapes, **screened.amplitudes}
    else:
        parameters |= candidate.rung.model.theta(effect)
        parameters |= _summary(candidate.rung.model, candidate.rung, effect)
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
    before, after = look.rung.error_validate, candidate.rung.error_validate
    change = f"held-out error {_percent(before)} → {_percent(after)}"
    if chosen is not None and candidate.id == chosen.id:
        return f"accepted: {change}, p = {candidate.p:.1g}"
    if not candidate.holds:
        return f"not confirmed by held-out runs: {change}, p = {candidate.p:.1g}"
    if chosen is not None:
        best = chosen.rung.error_validate
        return f"explains part: {change}, but {chosen.id} reaches {_percent(best)}"
    return f"{change}, p = {candidate.p:.1g}"


def _percent(error: float) -> str:
    return f"{100 * error:.2f} %"


def _explanation(verdict: Sequence[str], steps: Sequence[Step]) -> list[str]:
    start, last = steps[0], steps[-1]
    lines = []
    if verdict == ("none",):
        lines.append("The baseline explains the records down to the noise.")
    for before, after in pairwise(steps):
        added = [name for name in after.added if name not in before.added]
        lines.append(
            f"Adding {', '.join(added)} lowers the held-out error from"
            f" {_percent(before.rung.error_validate)} to {_percent(after.rung.error_validate)}."
        )
    if verdict[-1] == "unknown":
        lines.append(
            f"The residual stays at {_over_floor(last):.2f} times the floor and no effect of the"
            " library explains it:"
        )
        lines.extend(describe(last.comparison.breakdown))
    elif len(steps) > 1:
        lines.append("Where the baseline failed:")
        lines.extend(describe(start.comparison.breakdown))
    return lines
