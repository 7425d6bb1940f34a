"""What a look at a residual found, and the rungs of the ladder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot

from wheelhop.diagnose.baseline import comparison_of
from wheelhop.diagnose.diagnosis import Step
from wheelhop.diagnose.judge import Rung, enough_held_out, p_value
from wheelhop.diagnose.screen import Screened
from wheelhop.effects import Effect, OwnValues, form_of
from wheelhop.fit import Workshop


@dataclass(frozen=True, eq=False)
class Candidate:
    """An effect simulated in full: its log-odds over the rung's model on held-out runs, of how many
    effects tried it is one, and whether that is significant and material; and beside which other
    effect, if that was needed for it to show."""

    screened: Screened
    rung: Rung
    log_odds: float
    tried: int
    holds: bool
    beside: str = ""

    @property
    def id(self) -> str:
        """The effect's id."""
        return self.screened.variant.effect.id

    @property
    def effect(self) -> Effect:
        """The effect in the form that the full simulation came to."""
        return next(e for e in self.rung.model.effects if e.id == self.id)

    @property
    def form(self) -> str:
        """The name of that form."""
        return form_of(self.effect, self.rung.fit.runs[0].bench.simulator.campaign.channels)

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

    def remembered(self) -> Look:
        """The look as later ones ask for it: how well each candidate did. Signatures serve but
        once."""
        candidates = [
            replace(c, screened=replace(c.screened, contribution={}), rung=remembered(c.rung))
            for c in self.candidates
        ]
        rung = remembered(self.rung)
        return replace(self, rung=rung, screened=(), candidates=tuple(candidates))


def remembered(rung: Rung) -> Rung:
    """A rung that is no more than held against others: without derivatives, by far most of it,
    where enough runs are held out to judge without."""
    if not enough_held_out(rung):
        return rung
    return replace(
        rung,
        fit=rung.fit.without_derivatives,
        validation=rung.validation and rung.validation.without_derivatives,
        update=rung.update and rung.update.without_derivatives,
    )


def step_of(workshop: Workshop, rung: Rung, baseline: Step | None = None) -> Step:
    """A rung with its parameters and its comparison with the records; `baseline` is the first."""
    names = tuple(effect.id for effect in rung.model.effects)
    lacked = 0.0 if baseline is None else max(baseline.unexplained, 0.0)
    return Step(names, rung, parameters_of(rung), comparison_of(workshop, rung), lacked)


def with_step(steps: Sequence[Step], step: Step) -> list[Step]:
    """The ladder with one more step. The same effects in a better fit are no new one; what lies
    between the baseline and the new step is remembered."""
    below = [s for s in steps if s.added != step.added]
    return [*(replace(s, rung=remembered(s.rung)) if s.added else s for s in below), step]


def steps_of(workshop: Workshop, rungs: Sequence[Rung]) -> list[Step]:
    """The same of a whole ladder, its baseline first."""
    return on_one_floor(workshop, [step_of(workshop, rung) for rung in rungs])


def on_one_floor(workshop: Workshop, steps: Sequence[Step]) -> list[Step]:
    """The steps of one ladder, held against the same floor. Noise that is estimated is what a model
    leaves where that is quietest: the least that any of them tells is nearest to it."""
    least = min((step.comparison.floor for step in steps), key=lambda floor: floor.error)
    comparisons = [step.comparison for step in steps]
    if not least.is_stated:
        comparisons = [comparison_of(workshop, step.rung, floor=least) for step in steps]
    baseline, *others = map(lambda s, c: replace(s, comparison=c), steps, comparisons)
    lacked = max(baseline.unexplained, 0.0)
    return [baseline, *(replace(step, lacked=lacked) for step in others)]


def parameters_of(rung: Rung) -> dict[str, tuple[float, float]]:
    """Every fitted number and its standard deviation; switches, and numbers that stand for what is
    free in each run, have none (NaN)."""
    values, fitted = rung.model.values, rung.fit
    found = {f.name: (values[f.name], fitted.uncertainty(f.name)) for f in fitted.shared}
    for effect in rung.model.effects:
        fixed = rung.model.theta(effect) | summary_of(rung, effect)
        for name, value in fixed.items():
            found.setdefault(f"{effect.id}.{name}", (value, float("nan")))
    return found


def beside_other_laws(step: Step, look: Look) -> Step:
    """The step, its intervals as wide as what else was tried makes of each number.

    An effect that makes the runs fitted and those held out likelier, and yet does not hold, is one
    way to account for what the model is wrong by. Each number then varies by as much as the effect
    that moves it furthest would move it.
    """
    rung = step.rung
    others = [
        c.rung.model.values
        for c in look.candidates
        if look.rung is rung
        and c.rung.evidence > rung.evidence
        and c.rung.error_judging < rung.error_judging
    ]
    parameters = {
        name: (
            value,
            hypot(sd, max((abs(o.get(name, value) - value) for o in others), default=0.0)),
        )
        for name, (value, sd) in step.parameters.items()
    }
    return replace(step, parameters=parameters)


def summary_of(rung: Rung, effect: Effect) -> dict[str, float]:
    """Numbers that stand for what an effect leaves free per run."""
    return effect.summary(_run_by_run(rung, effect))


def contradicted(rung: Rung, effect: Effect) -> bool:
    """Whether what an effect leaves free per run came out against its nature."""
    return effect.contradicted(_run_by_run(rung, effect))


def _run_by_run(rung: Rung, effect: Effect) -> list[OwnValues]:
    found, prefix = [], f"{effect.id}."
    for run in rung.fit.runs:
        if run.bench.simulator.acts(effect):
            theta = {**rung.model.values, **rung.model.theta(effect, run.bench.run.id)}
            own = run.uncertainties(rung.fit.sigma)
            known_to = {k.removeprefix(prefix): v for k, v in own.items() if k.startswith(prefix)}
            found.append(OwnValues(run.bench.simulator.setting, theta, known_to))
    return found
