"""Tables without a clock: a counter at the rate that the file states, or that rate alone."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from wheelhop.files.units import to_si
from wheelhop.formats.columns import Column, Question, Stated, Timing, plausible
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.names import COUNTERS, FREQUENCIES, is_time_name, words_in
from wheelhop.formats.stamps import SAMPLE

EVEN = 1.01  # greatest step over least
NAMELESS = re.compile(r"column \d+")


def says(stated: Mapping[float, Stated]) -> str:
    """Where which rates are stated, in words."""
    return " and ".join(f"{said.place} says {rate:g} Hz" for rate, said in stated.items())


def counts(column: Column) -> bool:
    """Whether a column counts by ones, but for gaps and places where it begins again."""
    steps = _whole_steps(column)
    return steps is not None and bool((steps == 1).mean() > 0.8)


def is_counter(column: Column) -> bool:
    """Whether a column is called as counters are."""
    return bool(words_in(column.label) & COUNTERS)


def _whole_steps(column: Column) -> np.ndarray | None:
    """The steps of a column of whole numbers that is no clock and no frequency; else None."""
    values = column.values
    named = is_time_name(column.label) or words_in(column.name) & FREQUENCIES
    if values is None or column.unit or named:
        return None
    there = values[~np.isnan(values)]
    if len(there) < 3 or (there != np.round(there)).any():
        return None
    return np.diff(there)


def by_counter(
    index: int, columns: Sequence[Column], stated: Mapping[float, Stated], sure: bool
) -> Timing:
    """A counter is time once its rate is known."""
    label = columns[index].label
    guesses = [] if sure else [f"{label} counts samples"]
    rate, words, guess = _only(stated)
    if not sure and not NAMELESS.fullmatch(label):
        asked = f"{label} rises by ones: is it time, in s, ms, …, or a counter of samples, {SAMPLE}"
        return Timing(index, why="rises by ones", questions=(Question("time_unit", asked),))
    guesses += [guess] if guess else []
    why = "a counter" if rate is None else f"a counter, at {rate:g} Hz: {words}"
    questions = () if rate is not None else (Question("rate_hz", f"{label} only counts{words}"),)
    return Timing(index, SAMPLE, rate, why, "; ".join(guesses), questions)


def uncounted(columns: Sequence[Column], stated: Mapping[float, Stated]) -> Timing:
    """No clock and no counter: what the file states, or else something rises evenly, or is called a
    counter and rises by other steps than one, and is asked about. Raises `ExchangeError` for a
    spectrum."""
    rate, words, guess = _only(stated)
    for k, column in enumerate(columns):
        steps = _whole_steps(column) if is_counter(column) else None
        if steps is not None and (steps > 0).all():
            asked = f"{column.label} rises by {np.median(steps):g}: is it time, in s, ms, …, or a"
            asked += f" counter of samples, {SAMPLE}, of which most are missing"
            return Timing(k, why="rises", questions=(Question("time_unit", asked),))
        values = column.values
        if values is None or len(values) < 3 or np.isnan(values).any():
            continue
        steps = np.diff(values)
        if not (steps.min() > 0 and steps.max() < EVEN * steps.min()):
            continue
        named = not column.unit and words_in(column.name) & FREQUENCIES
        if named or to_si(column.unit)[0] == "Hz":
            raise ExchangeError(
                f"{column.label} rises evenly, in {column.unit or 'Hz'}: this is a spectrum, "
                "no recording"
            )
        if rate is None and not column.unit:
            asked = (
                f"{column.label} rises evenly by {steps.mean():.4g}: if it is time, in which unit?"
            )
            return Timing(k, why="rises evenly", questions=(Question("time_unit", asked),))
    if rate is not None:
        return Timing(rate_hz=rate, why=words, guess=guess)
    return Timing(questions=(Question("rate_hz", f"no column is time{words}"),))


def _only(stated: Mapping[float, Stated]) -> tuple[float | None, str, str]:
    """The one rate that is stated, where, and what is taken for granted of it; None if there are
    several or none, or one at which suspensions are not recorded, and what is said then."""
    rate = next(iter(stated), 0.0)
    if len(stated) == 1 and plausible(rate):
        said = stated[rate]
        guess = f"{rate:g}, which {said.place} says, is in Hz" if said.bare else ""
        return rate, says(stated), guess
    return None, f"; {says(stated)}" if stated else "", ""
