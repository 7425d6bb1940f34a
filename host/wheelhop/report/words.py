"""Verdicts in an engineer's words; the same on the page and in the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, log, nan

from wheelhop.campaign import TrackSpec
from wheelhop.compare import explains_nothing
from wheelhop.diagnose import Diagnosis, Limit, NextRun, Step
from wheelhop.effects import Effect, Misstatement
from wheelhop.files.words import interval, label_of, listed, percent, significant, unit_of


def headline(diagnosis: Diagnosis) -> str:
    """The verdict in a sentence or two."""
    verdict = diagnosis.verdict
    if verdict == ("none",) and diagnosis.grounds.more_than_noise:
        return (
            "No effect of the library shows, yet the records hold a little more than the baseline"
            " model and the sensors’ noise."
        )
    if verdict == ("none",):
        shown = "" if diagnosis.grounds.shows_all else " that these runs could show"
        return (
            f"Nothing is missing{shown}: the baseline model explains the records"
            f" down to {diagnosis.ladder[-1].left_to}."
        )
    effects = {effect.id: effect for effect in diagnosis.ladder[-1].rung.model.effects}
    accepted = [effects[name] for name in verdict if name != "unknown"]
    if not accepted:
        return "Something is missing, and no effect of the library is confirmed as its cause."
    sentences = [missing(accepted)]
    if diagnosis.grounds.cramped:
        sentences.append(
            "Yet that would have to be more than it can be: a law that the library lacks is as"
            " likely."
        )
    elif verdict[-1] == "unknown":
        sentences.append(
            "Something more is missing, and no effect of the library is confirmed as its cause."
        )
    return " ".join(sentences)


def in_numbers(steps: Sequence[Step]) -> str:
    """What the effects of a ladder came to, ± 2 standard deviations, and how far the error fell:
    of each effect the numbers of the unit that its first one has; "" of the baseline alone."""
    first, last = steps[0].rung.error, steps[-1].rung.error
    parts = [_numbers(name, steps[-1]) for name in steps[-1].added]
    if not parts:
        return ""
    return f"{'; '.join(parts)}. Error {percent(first)} → {percent(last)}."


def _numbers(effect: str, step: Step) -> str:
    prefix = f"{effect}."
    known = {
        name.removeprefix(prefix): interval(*number)
        for name, number in step.parameters.items()
        if name.startswith(prefix)
    }
    units = [unit_of(name) for name in known]
    shown = [
        f"{label_of(name)} {value} {unit}".strip()
        for (name, value), unit in zip(known.items(), units, strict=True)
        if unit == units[0]
    ]
    return f"{effect}: {', '.join(shown)}" if shown else effect


def comparison_headline(steps: Sequence[Step]) -> str:
    """How well the last model does, in a sentence."""
    first, last = steps[0].rung.error, steps[-1].rung.error
    ratio = f"{significant(over_floor(steps[-1]), 2)} times the noise floor"
    if len(steps) == 1:
        return f"The baseline’s error is {percent(last)}, {ratio}."
    added = listed(steps[-1].added)
    return f"With {added} the error goes from {percent(first)} to {percent(last)}, {ratio}."


def chain_words(road: Step, axles: Step) -> str:
    """What the two comparisons say together: on which side of the axle the model fails."""
    start = (
        f"With the measured axle motion driving the body the error is {percent(axles.rung.error)},"
        f" where a right model may leave {percent(axles.expected)}"
    )
    if not fails(road):
        side = "; with the road driving the wheels nothing fails either"
        return f"{start}{side if not fails(axles) else ''}."
    if explains_nothing(road.comparison.breakdown):
        return (
            f"{start}; driven by the road it explains nothing, so no side of the axle is to blame."
        )
    if explains_nothing(axles.comparison.breakdown):
        return f"{start}; neither explains the records, so no side of the axle is to blame."
    if not fails(axles):
        return f"{start}: what fails lies upstream of the axle, in tyre, track or speed."
    return f"{start}: something fails above the axle, in suspension, body or sensors."


def fails(step: Step) -> bool:
    """Whether the error is above what a right model leaves by more than that is uncertain."""
    return step.rung.error > step.expected * (1.0 + 2.0 * step.comparison.floor.tolerance)


def over_floor(step: Step) -> float:
    """Error, as foreseen, over the floor on the runs that judge; NaN where nothing is known of the
    noise."""
    return step.rung.error / step.floor if step.floor > 0 else nan


def missing(effects: Sequence[Effect]) -> str:
    """What the effects are, as a sentence: physics the model lacks, faults of the measurement,
    mistakes in what the campaign says."""
    wrong = [effect for effect in effects if isinstance(effect, Misstatement)]
    faults = [effect for effect in effects if effect.place == "sensor" and effect not in wrong]
    physics = [effect for effect in effects if effect not in wrong and effect not in faults]
    sentences = []
    if physics:
        sentences.append(f"The model lacks {_named(physics)}.")
    if faults:
        sentences.append(f"The measurement is at fault: {_named(faults)}.")
    if wrong:
        sentences.append(f"The campaign is wrong: {listed([e.title for e in wrong])}.")
    return " ".join(sentences)


def _named(effects: Sequence[Effect]) -> str:
    if len(effects) == 1:
        return f"{effects[0].id}: {effects[0].title}"
    return listed([effect.id for effect in effects])


def next_run_words(run: NextRun) -> str:
    """What to record next, and which doubt it settles."""
    first, second = run.separates
    return (
        f"Drive {run.track} as in {run.like} at {run.speed_kmph:.3g} km/h: it tells {first} from"
        f" {second}. Their signatures are {run.angle_deg:.0f}° apart on it,"
        f" {run.present_angle_deg:.0f}° on the runs at hand; expected to change the odds by a"
        f" factor of {_factor(run.expected_log_odds)}."
    )


def limit_words(limit: Limit) -> str:
    """From where on these runs would have shown an effect."""
    if not limit.shown:
        return "not shown by these runs at any strength it is likely to have"
    return listed([_amplitude(*item) for item in limit.amplitudes.items()]) or "if it is there"


def _amplitude(name: str, value: float) -> str:
    label = label_of(name)
    number = f"{significant(value, 2)} {unit_of(name)}".rstrip()
    return f"{label} {number}" if label else number


def _factor(log_odds: float) -> str:
    """As far up as it means anything."""
    return f"{exp(log_odds):.0f}" if log_odds < log(1e6) else "more than 10⁶"


def track_words(track: TrackSpec) -> str:
    """Kind of track and its size in millimetres."""
    if track.kind == "unknown":
        return "unknown track"
    keys = ("amplitude_m", "pitch_m", "height_m", "length_m")
    sizes = [f"{float(track.values[key]) * 1e3:g}" for key in keys if key in track.values]
    return f"{track.kind} {' × '.join(sizes)} mm" if sizes else track.kind
