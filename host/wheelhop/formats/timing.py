"""Which column is time and in what unit, and the sample rate: as the file says, or else asked.

Nothing is taken for time because it rises: a counter, a distance and a ramp rise, too.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.units import SECONDS, seconds_in, to_si
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.grid import typical_step
from wheelhop.formats.names import COUNTERS, FREQUENCIES, UNITS, is_time_name, words_in
from wheelhop.formats.stamps import (
    CLOCK,
    DAY_S,
    DIGITS,
    MINUTES,
    SAMPLE,
    Stamps,
    is_epoch,
    of_numbers,
    of_texts,
)

SLOWEST_HZ, FASTEST_HZ = 5.0, 1e5
"""Rates of recordings of a suspension; any other is asked about."""
SHORTEST_S = 1.0
"""A recording lasts so long at least, where its unit of time is in doubt."""
AGREE = 0.02
"""How far, as a share, the stamps' rate may be off the one that the header states."""
COARSE = 0.005
"""Share of stamps equal to the one before from which on they are coarse, not faulty."""
EVEN = 1.01  # greatest step over least
SERIAL_DAYS = (36526.0, 73050.0)  # spreadsheets count days since 1900: 2000 to 2100
NAMELESS = re.compile(r"column \d+")
PLAIN = ("s", "ms", "us", "ns")


@dataclass(frozen=True, eq=False)
class Column:
    """What a column is called, in which unit the file says it is, and what it holds: `values`
    (n,), `stamps`, or `texts`. `stamps` is a text where they cannot be read."""

    label: str
    name: str
    unit: str
    values: NDArray[np.float64] | None = None
    stamps: Stamps | str | None = None
    texts: Sequence[str] = ()


@dataclass(frozen=True)
class Question:
    """What a file does not say: the key of a mapping that does, and what is asked in words."""

    key: str
    words: str


@dataclass(frozen=True)
class Timing:
    """Time is column `index` in `unit`, or there is only `rate_hz`; what is asked is empty there.

    `aside` are columns that are clocks or counters, too, and so no channels; with the reason.
    `guess` says what was taken for granted, "" for nothing.
    """

    index: int | None = None
    unit: str = ""
    rate_hz: float | None = None
    why: str = ""
    guess: str = ""
    questions: tuple[Question, ...] = ()
    aside: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True)
class _Clock:
    """A column that may be time: in which unit, at what rate, why, and what is asked. It is `whole`
    if it stands in every row and never begins again, as the time of a lap does."""

    index: int
    unit: str
    rate_hz: float = 0.0
    why: str = ""
    guess: str = ""
    asked: str = ""
    absolute: bool = False
    jitter: float = 0.0
    whole: bool = True

    @property
    def rank(self) -> tuple[bool, bool, bool, bool]:
        """The best one comes first: sure, whole, even, and one that says the date."""
        return bool(self.guess), not self.whole, self.jitter > 0.1, not self.absolute


def find_timing(columns: Sequence[Column], stated: Mapping[float, int]) -> Timing:
    """Which of the columns is time, by what they are called and hold; `stated` are the rates that
    lines of the file state, each with the number of its line.

    Raises `ExchangeError` for a spectrum.
    """
    clocks = [clock for k, column in enumerate(columns) if (clock := _clock(k, column))]
    counters = [k for k, column in enumerate(columns) if _counts(column)]
    aside = {clock.index: "a clock, too" for clock in clocks}
    aside |= {
        k: "a counter"
        for k in counters
        if words_in(columns[k].label) & COUNTERS or NAMELESS.fullmatch(columns[k].label)
    }
    good = sorted((clock for clock in clocks if not clock.asked), key=lambda clock: clock.rank)
    if good:
        found = _agreeing(good, columns, stated)
    elif clocks:
        best = clocks[0]
        question = Question("time_unit", f"{best.asked} (s, ms, us, …)")
        found = Timing(best.index, why="called so", questions=(question,))
    elif counters:
        named = [k for k in counters if words_in(columns[k].label) & COUNTERS]
        found = _counted((named or counters)[0], columns, stated, sure=bool(named))
    else:
        found = _uncounted(columns, stated)
    return replace(found, aside={k: why for k, why in aside.items() if k != found.index})


def unit_of_numbers(label: str, unit: str, values: NDArray[np.float64]) -> tuple[str, str]:
    """The unit of stamps in a column that is known to be time; or "" and why it must be asked."""
    clock = _numbers(0, Column(label, label, unit, values), named=True)
    return clock.unit, clock.asked


def stamps_of(column: Column, unit: str, rate_hz: float | None, file: Path) -> Stamps:
    """The time stamps in a column that is known to be time, in the unit that a mapping says, or
    else the file. Raises `ExchangeError` for what cannot be read, or has no unit."""

    def where(row: int) -> str:
        return f"{file}: row {row + 1}"

    if isinstance(column.stamps, str):
        raise ExchangeError(f"{file}: {column.label}: {column.stamps}")
    if column.stamps is not None:
        return column.stamps
    if column.values is None:
        return of_texts(column.texts, unit or CLOCK, where)
    if unit in (CLOCK, MINUTES):
        raise ExchangeError(
            f"{file}: {column.label} holds numbers, not dates: give their time_unit"
        )
    if not unit:
        unit, asked = unit_of_numbers(column.label, column.unit, column.values)
        if asked and not rate_hz:
            raise ExchangeError(f"{file}: {asked}: give its time_unit in a mapping")
    return of_numbers(column.values, unit or "s", where, rate_hz)


def _clock(index: int, column: Column) -> _Clock | None:
    """The column as a clock, None if it is none."""
    if column.stamps is not None:
        return _dated(index, column.stamps)
    if column.values is None:
        return None
    named, timed = is_time_name(column.label), seconds_in(column.unit) is not None
    there = column.values[~np.isnan(column.values)]
    nameless = not column.unit and NAMELESS.fullmatch(column.label) is not None
    since_1970 = nameless and any(is_epoch(there, SECONDS[unit]) for unit in PLAIN)
    if not (named or timed or since_1970) or (column.unit and not timed and not named):
        return None
    if not len(there) or (len(there) > 1 and not _rises(there)):
        return None
    whole = len(there) == len(column.values) and bool((np.diff(there) >= 0).all())
    found = replace(_numbers(index, replace(column, values=there), named), whole=whole)
    return replace(found, guess=f"{column.label} is {found.why}") if since_1970 else found


def _dated(index: int, stamps: Stamps | str) -> _Clock:
    if isinstance(stamps, str):
        return _Clock(index, CLOCK, asked=stamps)
    rate, jitter = _rate(stamps.time_s)
    found = _Clock(index, CLOCK, rate, "dates or times of day", absolute=True, jitter=jitter)
    return found if _plausible(rate) else replace(found, asked=_odd(found, "as they stand"))


def _rises(values: NDArray[np.float64]) -> bool:
    """But for a few places, where a clock may begin again."""
    steps = np.diff(values)
    return bool((steps < 0).mean() < 0.02 and (steps > 0).any())


def _numbers(index: int, column: Column, named: bool) -> _Clock:
    """Stamps that are numbers, in the unit that is said, or the only one that they can be in."""
    values = column.values
    assert values is not None
    plain = named and not any(char.isdigit() for char in column.label)  # "time (0.1 ms)"
    words = {UNITS[word] for word in words_in(column.label) if word in UNITS} if plain else set()
    said = column.unit or (words.pop() if len(words) == 1 else "")
    size = seconds_in(said)
    if said and size is None:
        return _Clock(index, "", asked=f"{column.label} is in {said}, no unit of time known here")
    if size is not None:
        unit = next(name for name in (said, *SECONDS) if SECONDS.get(name) == size)
        found = replace(_in(index, values, unit), why=f"in {unit}, as it says")
        if _plausible(found.rate_hz) or len(values) < 2:
            return found
        return replace(found, unit="", asked=_odd(found, f"in {unit}, as it says"))
    if epoch := next((unit for unit in PLAIN if is_epoch(values, SECONDS[unit])), None):
        found = replace(_in(index, values, epoch), why=f"{epoch} since 1970", absolute=True)
        if _plausible(found.rate_hz):
            return found
        return replace(found, unit="", asked=_odd(found, f"in {epoch} since 1970"))
    since = _of_day(values, bool(words_in(column.label) & {"utc", "hhmmss"}))
    if since is not None:
        rate, jitter = _rate(since)
        found = _Clock(index, DIGITS, rate, "hours, minutes and seconds", jitter=jitter)
        return found if _plausible(rate) else replace(found, unit="", asked=_odd(found, DIGITS))
    return _guessed(index, values, column.label)


def _guessed(index: int, values: NDArray[np.float64], label: str) -> _Clock:
    """Stamps of which nothing says the unit: seconds, or days of a spreadsheet, if they can be
    nothing else."""
    if len(values) < 2:
        return _Clock(index, "", asked=f"the unit of {label} is not said")
    days = _in(index, values, "day")
    if SERIAL_DAYS[0] < values[0] < SERIAL_DAYS[1] and _plausible(days.rate_hz):
        return replace(days, why="a spreadsheet's days", guess=f"{label} counts days")
    span, able = float(values[-1] - values[0]), []
    for unit in PLAIN:
        found = _in(index, values, unit)
        if _plausible(found.rate_hz) and (unit == "s" or span * SECONDS[unit] >= SHORTEST_S):
            able.append(found)
    if [found.unit for found in able] == ["s"] and abs(values[0]) < 1e9:
        return replace(able[0], why="its unit is not said", guess=f"{label} is in s")
    steps = f"its steps are {typical_step(np.diff(values)):.6g}"
    return _Clock(index, "", asked=f"the unit of {label} is not said, and {steps}")


def _in(index: int, values: NDArray[np.float64], unit: str) -> _Clock:
    rate, jitter = _rate((values - values[0]) * SECONDS[unit])
    return _Clock(index, unit, rate, jitter=jitter, absolute=is_epoch(values, SECONDS[unit]))


def _rate(time_s: NDArray[np.float64]) -> tuple[float, float]:
    """Samples per second of all steps that are no gaps, 0 if there is none; and how much the steps
    scatter, in steps."""
    steps = np.diff(time_s)
    forward = steps[steps > 0]
    if not len(forward):
        return 0.0, 0.0
    if (steps == 0).mean() > COARSE:  # several samples each
        return float((len(time_s) - 1) / (time_s[-1] - time_s[0])), 1.0
    step = typical_step(forward)
    return 1.0 / step, float(np.median(np.abs(forward - step)) / step)


def _plausible(rate_hz: float) -> bool:
    return SLOWEST_HZ <= rate_hz <= FASTEST_HZ


def _odd(clock: _Clock, read: str) -> str:
    return f"read {read}, the stamps go at {clock.rate_hz:.4g} Hz"


def _of_day(values: NDArray[np.float64], named: bool) -> NDArray[np.float64] | None:
    """Stamps as 102133.25, seconds since midnight, where their steps show it: 59.99 is followed by
    100. None where they do not, unless they are `named` so."""
    hours, minutes, seconds = values // 10000, values // 100 % 100, values % 100
    if not ((values >= 0) & (hours < 24) & (minutes < 60) & (seconds < 60)).all():
        return None
    since = 3600 * hours + 60 * minutes + seconds
    since = since + DAY_S * np.concatenate([[0.0], np.cumsum(np.diff(since) < -DAY_S / 2)])
    steps = np.diff(since)
    if not len(steps) or not (steps > 0).any():
        return None
    crossed = np.diff(values // 100) != 0
    step = typical_step(steps[steps > 0])
    shown = bool(crossed.any()) and bool((steps[crossed] < 3 * step).any())
    return since if shown or (named and values[0] >= 100) else None


def _agreeing(
    good: Sequence[_Clock], columns: Sequence[Column], stated: Mapping[float, int]
) -> Timing:
    """The best clock, if no other and no line of the file says another rate. Raises `ExchangeError`
    where columns have clocks of their own."""
    best = good[0]
    for other in good[1:]:
        one, two = columns[best.index], columns[other.index]
        if one.label == two.label and not _same(one, two):
            raise ExchangeError(
                f"columns {best.index + 1} and {other.index + 1} are both called {one.label} and"
                " differ: channels with times of their own cannot be one table: save it on one time"
            )
        belies = other.whole and not other.guess
        if abs(other.rate_hz / best.rate_hz - 1) > AGREE and belies:
            words = " and ".join(
                f"{columns[clock.index].label} goes at {clock.rate_hz:.6g} Hz"
                for clock in (best, other)
            )
            question = Question("rate_hz", f"{words}: which is right?")
            return Timing(best.index, best.unit, None, best.why, best.guess, (question,))
    if best.jitter >= 1.0:
        words = f"several rows share a stamp: it is about {best.rate_hz:.4g} Hz, if the rows are"
        words += " equally spaced (if not, say resample_hz)"
        question = Question("rate_hz", words)
        return Timing(best.index, best.unit, None, best.why, best.guess, (question,))
    wrong = {r: line for r, line in stated.items() if abs(r / best.rate_hz - 1) > AGREE}
    questions: tuple[Question, ...] = ()
    if wrong and len(wrong) == len(stated):
        words = f"{_lines(wrong)}, the stamps go at {best.rate_hz:.6g} Hz: which is right?"
        questions = (Question("rate_hz", words),)
    return Timing(best.index, best.unit, None, best.why, best.guess, questions)


def _same(one: Column, two: Column) -> bool:
    """Whether two columns hold the same numbers."""
    if one.values is None or two.values is None:
        return False
    return np.array_equal(one.values, two.values, equal_nan=True)


def _lines(stated: Mapping[float, int]) -> str:
    return " and ".join(f"line {line} says {rate:g} Hz" for rate, line in stated.items())


def _counts(column: Column) -> bool:
    """Whether a column counts by ones, but for gaps and places where it begins again."""
    values = column.values
    named = is_time_name(column.label) or words_in(column.name) & FREQUENCIES
    if values is None or column.unit or named or len(values) < 3:
        return False
    steps = np.diff(values)
    return bool((values == np.round(values)).all() and (steps == 1).mean() > 0.8)


def _counted(
    index: int, columns: Sequence[Column], stated: Mapping[float, int], sure: bool
) -> Timing:
    """A counter is time once its rate is known."""
    label = columns[index].label
    guess = "" if sure else f"{label} counts samples"
    rate, words = _only(stated)
    if not sure and not NAMELESS.fullmatch(label):
        asked = f"{label} rises by ones: is it time, in s, ms, …, or a counter of samples, {SAMPLE}"
        return Timing(index, why="rises by ones", questions=(Question("time_unit", asked),))
    why = "a counter" if rate is None else f"a counter, at {rate:g} Hz: {words}"
    questions = () if rate is not None else (Question("rate_hz", f"{label} only counts{words}"),)
    return Timing(index, SAMPLE, rate, why, guess, questions)


def _uncounted(columns: Sequence[Column], stated: Mapping[float, int]) -> Timing:
    """No clock and no counter: what the header states, or else something rises evenly, and is asked
    about."""
    rate, words = _only(stated)
    for k, column in enumerate(columns):
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
        return Timing(rate_hz=rate, why=words)
    return Timing(questions=(Question("rate_hz", f"no column is time{words}"),))


def _only(stated: Mapping[float, int]) -> tuple[float | None, str]:
    """The one rate that is stated, and where; else None, and what is said of several."""
    if len(stated) == 1:
        return next(iter(stated)), _lines(stated)
    return None, f"; {_lines(stated)}" if stated else ""
