"""What a file does not say of its time: what is asked, the answers, and the keys of a mapping."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from wheelhop.files import quoted
from wheelhop.files.units import SECONDS
from wheelhop.formats.columns import Column, Question, Timing
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.grid import UnevenError, fit_grid
from wheelhop.formats.stamps import SAMPLE
from wheelhop.formats.table import Table
from wheelhop.formats.timing import stamps_of

FASTEST_ANSWER_HZ = 1e12
EMPTY = np.empty((0, 0))


def answered(timing: Timing, answers: Mapping[str, str]) -> Timing:
    """Timing with the answers to what it asked; a unit that counts samples asks for the rate."""
    unit = answers.get("time_unit")
    rate = _rate("rate_hz", answers) or timing.rate_hz
    asked = {question.key: question for question in timing.questions}
    if unit and "time_unit" in asked:
        timing = replace(timing, unit=unit, why="as you said")
        del asked["time_unit"]
        if unit == SAMPLE and rate is None:
            asked["rate_hz"] = Question("rate_hz", "a counter says no time")
    resampled = "resample_hz" in answers and timing.index is not None and timing.unit != SAMPLE
    if rate is not None or resampled:  # stamps that several rows share are taken as they stand
        asked.pop("rate_hz", None)
    return replace(timing, rate_hz=rate, questions=tuple(asked.values()))


def _rate(key: str, answers: Mapping[str, str]) -> float | None:
    """The rate that was answered, None if there is no answer. Raises `ExchangeError`."""
    if key not in answers:
        return None
    try:
        rate = float(answers[key])
    except ValueError:
        rate = 0.0
    if not 0.0 < rate < FASTEST_ANSWER_HZ:
        raise ExchangeError(f"{key} = {answers[key]} is no number of samples a second")
    return rate


def uneven(table: Table) -> str:
    """Why the stamps of a table are no equal steps, "" if they are."""
    if table.time_s is None or not len(table.time_s):
        return ""
    try:
        fit_grid(table.time_s, table.where, table.rate_hz)
    except UnevenError as error:
        return str(error).removeprefix(f"{table.file}: ")
    except ExchangeError:
        pass  # reading says so
    return ""


def uneven_stamps(column: Column, timing: Timing, file: Path, first_row: int) -> str:
    """What is uneven about a column of time stamps whose rows begin in line `first_row`; "" for
    none."""
    try:
        stamps = stamps_of(column, timing.unit, timing.rate_hz, file)
    except ExchangeError:
        return ""
    lines = range(first_row, first_row + len(stamps.time_s))
    return uneven(Table(file, "text", (), EMPTY, stamps.time_s, timing.rate_hz, lines=lines))


def resample_keys(
    words: str, answers: Mapping[str, str]
) -> tuple[list[tuple[str, str, str]], list[Question]]:
    """The key `resample_hz`, blank where `words` ask for it, and the question."""
    rate = _rate("resample_hz", answers)
    if rate is not None:
        return [("resample_hz", repr(rate), "between its samples each channel is uncertain")], []
    if not words:
        return [], []
    return [("resample_hz", '""', words)], [Question("resample_hz", words)]


def timing_keys(timing: Timing, names: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """The keys of a mapping that say what is time, with comments; those that are asked for are
    blank."""
    asked = {question.key: question.words for question in timing.questions}
    if timing.index is not None:
        yield "time", names[timing.index], ""
        notes = {SAMPLE: "a counter of samples: its gaps are kept"}
        note = asked.get("time_unit") or notes.get(timing.unit, "")
        if timing.guess and timing.unit != SAMPLE:
            note = "not said: s, ms?" if timing.unit in SECONDS else timing.why
        if timing.guess and timing.unit == SAMPLE:
            note = f"{timing.guess}: is it so?"
        yield "time_unit", quoted(timing.unit), note
    if timing.rate_hz is not None:
        yield "rate_hz", repr(timing.rate_hz), timing.why
    elif "rate_hz" in asked:
        yield "rate_hz", '""', f"{asked['rate_hz']}: how many samples has a second?"
