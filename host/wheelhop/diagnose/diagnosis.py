"""What a diagnosis says, and its JSON (format 1 of the result contract)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from html import escape
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from wheelhop.compare import Comparison, quantities_to_json, where_to_json
from wheelhop.diagnose.next_run import NextRun
from wheelhop.diagnose.score import EXACT, LAW, Rung
from wheelhop.files.words import percent, unit_of
from wheelhop.gate import Finding
from wheelhop.gate import to_json as findings_to_json
from wheelhop.identify import Linearity

if TYPE_CHECKING:
    from pandas import DataFrame

FORMAT = 1


@dataclass(frozen=True)
class Limit:
    """The smallest amplitudes of an effect that these runs would show, under their names, in the
    form it was screened in. ``unseen`` is the chance that the effect, were it there, would be
    weaker than that. An effect that is there in full or not at all has no amplitudes."""

    effect: str
    form: str
    amplitudes: Mapping[str, float]
    shown: bool  #: False where these runs would not show it at any strength it is believed to have
    unseen: float


@dataclass(frozen=True)
class Ranked:
    """One effect on the first rung.

    ``screened_error`` is E over the fitted runs that first-order screening expects (None: the
    effect does not apply to this campaign),
    ``confirmed_error`` what was reached in full simulation (None: not tried, `reason` says why);
    ``evidence`` is the logarithm of the evidence over the baseline's; ``p_value`` the chance that
    any of the effects tried looks as good on held-out runs without being there.
    """

    effect: str
    place: str
    screened_error: float | None
    confirmed_error: float | None
    validated_error: float | None
    evidence: float | None
    p_value: float | None
    ambiguous_with: tuple[tuple[str, float], ...]  #: effect and angle between signatures, degrees
    parameters: Mapping[str, float | str]
    reason: str  #: why it was accepted or not, in one line


@dataclass(frozen=True)
class Belief:
    """What the campaign or the vehicle's file says and the fit holds to be wrong: `what` by its
    dotted name, what was stated and what was fitted, in the same unit, with its standard deviation;
    `confidence` that it is wrong, None where that was not judged by itself."""

    what: str
    stated: float
    fitted: float
    sd: float
    confidence: float | None


EndedBy = Literal["budget", "interrupted"]


@dataclass(frozen=True)
class Unfinished:
    """A search that ended before it was done: what ended it, "budget" or "interrupted", after how
    much work (seconds of a processor), and which effects were screened beside the last model but
    not simulated, with the error E over the runs fitted that first order expects each to leave;
    the least first."""

    ended_by: EndedBy
    work_s: float
    untried: tuple[tuple[str, float], ...]

    @property
    def sentence(self) -> str:
        """What more time might still change."""
        of = "the budget" if self.ended_by == "budget" else "interrupted"
        said = f"The search ended after {self.work_s:.0f} s of work ({of})."
        if not self.untried:
            return f"{said} More time might still change the verdict."
        names = ", ".join(f"{name} ({percent(error)})" for name, error in self.untried[:3])
        others = f", and {more} more" if (more := len(self.untried[3:])) else ""
        return f"{said} Not simulated, with the error expected of each: {names}{others}."


UNLIKELY = 0.05  # what noise leaves with less chance is said to be more than noise


@dataclass(frozen=True, eq=False)
class Step:
    """One rung of the ladder: the effects added so far, the fitted model, its parameters as
    (value, standard deviation) and how it compares with the records. ``lacked`` is the share of the
    signal's power that the baseline below it leaves unexplained."""

    added: tuple[str, ...]
    rung: Rung
    parameters: Mapping[str, tuple[float, float]]
    comparison: Comparison
    lacked: float = 0.0

    def __repr__(self) -> str:
        model = " + ".join(("baseline", *self.added))
        return f"<Step {model}: E = {percent(self.rung.error)}, floor {percent(self.floor)}>"

    @property
    def floor(self) -> float:
        """E that the sensors alone would leave of the runs that judge."""
        floor = self.comparison.floor
        return floor.error_fit if self.rung.validation is None else floor.error_validate

    @property
    def expected(self) -> float:
        """E that a right model may leave of the runs that judge; see `Floor.expected`."""
        floor = self.comparison.floor
        return floor.expected_fit if self.rung.validation is None else floor.expected_validate

    @property
    def over_floor(self) -> float:
        """Error on the runs that judge over the floor."""
        return self.rung.error_judging / self.floor

    @property
    def left_to(self) -> str:
        """What explains all that a step leaves which lacks nothing, in words."""
        floor = self.comparison.floor
        if floor.beside_noise and self.over_floor > 1.0 + 2.0 * floor.tolerance:
            return f"{floor.in_words} and {floor.beside_noise}"
        return floor.in_words

    @property
    def allowed(self) -> float:
        """Share of the signal's power by which model and scales may be wrong, noise apart."""
        return self.comparison.floor.scales**2 + EXACT**2 + LAW**2 * self.lacked

    @property
    def unexplained(self) -> float:
        """Share of the signal's power left of the runs that judge beyond what a right model is
        expected to leave, what that is uncertain by, and what such models are exact to; negative:
        less than that."""
        tolerated = self.expected * (1.0 + 2.0 * self.comparison.floor.tolerance)
        return self.rung.error_judging**2 - tolerated**2 - EXACT**2

    @property
    def above_expected(self) -> float:
        """Logarithm of E of the runs that judge over what a right model may leave."""
        return float(np.log(self.rung.error_judging / self.expected))

    @property
    def above_floor(self) -> bool:
        """Whether more is left unexplained than the laws added may leave of what they stand for."""
        return self.unexplained > LAW**2 * self.lacked


@dataclass(frozen=True)
class Grounds:
    """What the verdict's first entry stands on.

    ``log_odds`` over its best rival; ``lead``, by how many times what it leaves itself that rival
    leaves more; ``stability``, the share of what speaks for it against that rival that is left when
    the run that speaks loudest is left out; ``p_value`` on held-out runs; errors of the last rung
    and of the baseline over the floor; ``by_chance``, the chance that noise alone leaves as much as
    the last rung; ``unseen``, the chance that something is there which these runs could not show;
    ``cramped``, whether a number of an effect sits on its bound; ``louder``, whether that is noise
    only if the sensors are noisier than stated; ``expected_over_floor``, what a right model may
    leave over the floor (`Floor.expected`); ``untried``, the chance that another entry would come
    first had the search not been ended; ``is_law``, whether it is a law of the struts.
    """

    log_odds: float
    lead: float
    stability: float
    p_value: float
    over_floor: float
    baseline_over_floor: float
    by_chance: float
    unseen: float = 0.0
    cramped: bool = False
    louder: bool = False
    expected_over_floor: float = 1.0
    untried: float = 0.0
    is_law: bool = False

    @property
    def over_expected(self) -> float:
        """Error of the last rung over what a right model may leave."""
        return self.over_floor / self.expected_over_floor

    @property
    def baseline_over_expected(self) -> float:
        """Error of the baseline over what a right model may leave."""
        return self.baseline_over_floor / self.expected_over_floor

    @property
    def more_than_noise(self) -> bool:
        """Whether noise alone hardly leaves as much as the last rung."""
        return self.by_chance < UNLIKELY

    @property
    def shows_all(self) -> bool:
        """Whether hardly anything of the library could be there unseen."""
        return self.unseen < UNLIKELY


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Verdict, ranking on the first rung, and the ladder from the baseline to the last rung.

    ``axle_to_body`` says whether what lies between the measured axles and the body is linear; None
    where nothing is missing there, or not all axles were recorded.
    """

    verdict: tuple[str, ...]
    confidence: float
    grounds: Grounds
    ranking: tuple[Ranked, ...]
    ladder: tuple[Step, ...]
    next_run: NextRun | None
    explanation: tuple[str, ...]
    axle_to_body: Linearity | None = None
    limits: tuple[Limit, ...] = ()  #: what else these runs would have shown, and from where on
    findings: tuple[Finding, ...] = ()  #: of the gate before the fit and of the critic after it
    beliefs: tuple[Belief, ...] = ()  #: what was stated and is held to be what is wrong
    unfinished: Unfinished | None = None  #: None where the search came to its end

    def __repr__(self) -> str:
        first, last = self.ladder[0], self.ladder[-1]
        fall = f"E {percent(first.rung.error)} → {percent(last.rung.error)}"
        verdict = ", ".join(self.verdict)
        sure = f"confidence {100 * self.confidence:.0f} %"
        return f"<Diagnosis: {verdict}; {sure}; {fall}, floor {percent(last.floor)}>"

    def _repr_html_(self) -> str:
        tables = ranking_frame(self.ranking).head(6), ladder_frame(self.ladder)
        return f"<p>{escape(repr(self))}</p>" + "".join(
            table.to_html(float_format="%.3g", na_rep="") for table in tables
        )


def ranking_frame(ranking: Sequence[Ranked]) -> DataFrame:
    """The effects on the first rung, best first; NaN where one was not tried so far. See `Ranked`;
    `angle_deg` is that to the effect hardest to tell from it."""
    import pandas

    rows = [
        {
            "effect": item.effect,
            "place": item.place,
            "screened_error": item.screened_error,
            "confirmed_error": item.confirmed_error,
            "validated_error": item.validated_error,
            "log_evidence": item.evidence,
            "p_value": item.p_value,
            "hard_to_tell_from": ", ".join(name for name, _ in item.ambiguous_with),
            "angle_deg": min((angle for _, angle in item.ambiguous_with), default=None),
            "reason": item.reason,
        }
        for item in ranking
    ]
    words = {"effect", "place", "hard_to_tell_from", "reason"}
    table = pandas.DataFrame(rows)
    return table.astype({k: float for k in table if k not in words}).set_index("effect")


def ladder_frame(ladder: Sequence[Step]) -> DataFrame:
    """The rungs from the baseline on: the effects in the model, E over the runs fitted and held
    out (NaN without such), E that the sensors' noise leaves, and the error over that floor."""
    import pandas

    rows = [
        {
            "model": " + ".join(("baseline", *step.added)),
            "error_fit": step.rung.error_fit,
            "error_validate": step.rung.error_validate,
            "floor": step.floor,
            "over_floor": step.rung.error / step.floor if step.floor > 0 else np.nan,
        }
        for step in ladder
    ]
    return pandas.DataFrame(rows).set_index("model")


def parameters_frame(step: Step) -> DataFrame:
    """Every fitted number of a rung under its name: value and one standard deviation (NaN for what
    is fixed, or stands for what each run leaves free), in `unit`, SI."""
    import pandas

    names = list(step.parameters)
    values = list(step.parameters.values())
    table = pandas.DataFrame(values, index=names, columns=["value", "uncertainty"], dtype=float)
    return table.rename_axis("number").assign(unit=[unit_of(name) for name in names])


def to_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """Plain dictionaries, lists, strings and numbers; what is undetermined is None."""
    last = diagnosis.ladder[-1].comparison
    floor = last.floor
    return {
        "format": FORMAT,
        "verdict": list(diagnosis.verdict),
        "confidence": round(diagnosis.confidence, 4),
        "grounds": {
            k: v if isinstance(v, bool) else _number(v)
            for k, v in asdict(diagnosis.grounds).items()
        },
        "explanation": list(diagnosis.explanation),
        "floor": {
            "error": _number(floor.error),
            "error_fit": _number(floor.error_fit),
            "error_validate": _number(floor.error_validate),
            "expected": _number(floor.expected),
            "expected_fit": _number(floor.expected_fit),
            "expected_validate": _number(floor.expected_validate),
            "source": floor.source,
            "basis": floor.origin,
            "uncertainty": floor.tolerance,
        },
        **quantities_to_json(last),
        "ranking": [_ranked(r) for r in diagnosis.ranking],
        "ladder": [
            {
                "added": list(step.added),
                "error_fit": _number(step.rung.error_fit),
                "error_validate": _number(step.rung.error_validate),
                "parameters": {k: _number(v) for k, (v, _) in step.parameters.items()},
                "uncertainties": {k: _number(s) for k, (_, s) in step.parameters.items()},
            }
            for step in diagnosis.ladder
        ],
        "where": {
            "baseline": where_to_json(diagnosis.ladder[0].comparison.breakdown),
            "last": where_to_json(last.breakdown),
        },
        "next_run": _next_run(diagnosis.next_run),
        "limits": [asdict(limit) for limit in diagnosis.limits],
        "axle_to_body": diagnosis.axle_to_body and diagnosis.axle_to_body.to_json(),
        "beliefs": [
            {k: v if isinstance(v, str) else _number(v) for k, v in asdict(belief).items()}
            for belief in diagnosis.beliefs
        ],
        "findings": findings_to_json(diagnosis.findings),
        "unfinished": _unfinished(diagnosis.unfinished),
    }


def _unfinished(found: Unfinished | None) -> dict[str, Any] | None:
    if found is None:
        return None
    untried = [{"effect": name, "screened_error": _number(e)} for name, e in found.untried]
    return {"ended_by": found.ended_by, "work_s": round(found.work_s, 1), "untried": untried}


def _ranked(ranked: Ranked) -> dict[str, Any]:
    return {
        "effect": ranked.effect,
        "place": ranked.place,
        "screened_error": _number(ranked.screened_error),
        "confirmed_error": _number(ranked.confirmed_error),
        "validated_error": _number(ranked.validated_error),
        "evidence": _number(ranked.evidence),
        "p_value": _number(ranked.p_value),
        "ambiguous_with": [name for name, _ in ranked.ambiguous_with],
        "angles_deg": {name: _number(angle) for name, angle in ranked.ambiguous_with},
        "parameters": {
            k: v if isinstance(v, str) else _number(v) for k, v in ranked.parameters.items()
        },
        "reason": ranked.reason,
    }


def _next_run(run: NextRun | None) -> dict[str, Any] | None:
    if run is None:
        return None
    return {
        "like": run.like,
        "track": run.track,
        "speed_kmph": round(run.speed_kmph, 2),
        "separates": list(run.separates),
        "angle_deg": round(run.angle_deg, 1),
        "present_angle_deg": round(run.present_angle_deg, 1),
        "expected_log_odds": round(run.expected_log_odds, 1),
    }


def _number(value: float | None) -> float | None:
    return None if value is None or not np.isfinite(value) else float(value)
