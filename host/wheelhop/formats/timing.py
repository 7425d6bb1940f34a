"""Which column is time and in what unit, and the sample rate: as the file says, or else asked.

Nothing is taken for time because it rises: a counter, a distance and a ramp rise, too.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.units import SECONDS, is_measured, seconds_in
from wheelhop.formats.columns import Column, Question, Stated, Timing, plausible
from wheelhop.formats.counted import NAMELESS, by_counter, counts, is_counter, says, uncounted
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.grid import STRAY, typical_step
from wheelhop.formats.names import UNITS, is_time_name, time_words
from wheelhop.formats.stamps import (
    CLOCK,
    DAY_S,
    DIGITS,
    MINUTES,
    Stamps,
    is_epoch,
    of_numbers,
    of_texts,
)

SHORTEST_S = 1.0
"""A recording lasts so long at least, where its unit of time is in doubt."""
AGREE = 0.02
"""How far, as a share, the stamps' rate may be off the one that the header states."""
COARSE = 0.005
"""Share of stamps equal to the one before from which on they are coarse, not faulty."""
SERIAL_DAYS = (36526.0, 73050.0)  # spreadsheets count days since 1900: 2000 to 2100
PLAIN = ("s", "ms", "us", "ns")
OWN_CLOCKS = "channels with times of their own cannot be one table: save it on one time"


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
    def uneven(self) -> bool:
        """Whether its steps are not equal."""
        return self.jitter > 0.1

    @property
    def doubtful(self) -> bool:
        """Whether it may be anything that rises, such as a temperature that is called T."""
        return bool(self.guess) and self.uneven

    @property
    def rank(self) -> tuple[bool, bool, bool, bool]:
        """The best one comes first: sure, whole, even, and one that says the date."""
        return bool(self.guess), not self.whole, self.uneven, not self.absolute


def find_timing(columns: Sequence[Column], stated: Mapping[float, Stated]) -> Timing:
    """Which of the columns is time, by what they are called and hold; `stated` are the rates, Hz,
    that the file states.

    Raises `ExchangeError` for a spectrum.
    """
    clocks = [clock for k, column in enumerate(columns) if (clock := _clock(k, column))]
    _check_own_clocks(clocks, columns)
    counters = [k for k, column in enumerate(columns) if counts(column)]
    aside = {clock.index: "a clock, too" for clock in clocks if not clock.doubtful}
    aside |= {
        k: "a counter"
        for k in counters
        if is_counter(columns[k]) or NAMELESS.fullmatch(columns[k].label)
    }
    good = sorted((clock for clock in clocks if not clock.asked), key=lambda clock: clock.rank)
    if good:
        found = _agreeing(good, columns, stated)
    elif clocks:
        best = clocks[0]
        question = Question("time_unit", f"{best.asked} (s, ms, us, …)")
        found = Timing(best.index, why="called so", questions=(question,))
    elif counters:
        named = [k for k in counters if is_counter(columns[k])]
        found = by_counter((named or counters)[0], columns, stated, sure=bool(named))
    else:
        found = uncounted(columns, stated)
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
    if not (named or timed or since_1970) or (not timed and is_measured(column.unit)):
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
    return found if plausible(rate) else replace(found, asked=_odd(found, "as they stand"))


def _rises(values: NDArray[np.float64]) -> bool:
    """But for a few places, where a clock may begin again."""
    steps = np.diff(values)
    return bool((steps < 0).mean() < 0.02 and (steps > 0).any())


def _numbers(index: int, column: Column, named: bool) -> _Clock:
    """Stamps that are numbers, in the unit that is said, or the only one that they can be in."""
    values = column.values
    assert values is not None
    plain = named and not any(char.isdigit() for char in column.label)  # "time (0.1 ms)"
    words = {UNITS[word] for word in time_words(column.label) if word in UNITS} if plain else set()
    said = column.unit or (words.pop() if len(words) == 1 else "")
    size = seconds_in(said)
    if said and size is None:
        return _Clock(index, "", asked=f"{column.label} is in {said}, no unit of time known here")
    if size is not None:
        unit = next(name for name in (said, *SECONDS) if SECONDS.get(name) == size)
        found = replace(_in(index, values, unit), why=f"in {unit}, as it says")
        if plausible(found.rate_hz) or len(values) < 2:
            return found
        return replace(found, unit="", asked=_odd(found, f"in {unit}, as it says"))
    if epoch := next((unit for unit in PLAIN if is_epoch(values, SECONDS[unit])), None):
        found = replace(_in(index, values, epoch), why=f"{epoch} since 1970", absolute=True)
        if plausible(found.rate_hz):
            return found
        return replace(found, unit="", asked=_odd(found, f"in {epoch} since 1970"))
    since = _of_day(values, bool(time_words(column.label) & {"utc", "hhmmss"}))
    if since is not None:
        rate, jitter = _rate(since)
        found = _Clock(index, DIGITS, rate, "hours, minutes and seconds", jitter=jitter)
        return found if plausible(rate) else replace(found, unit="", asked=_odd(found, DIGITS))
    return _guessed(index, values, column.label)


def _guessed(index: int, values: NDArray[np.float64], label: str) -> _Clock:
    """Stamps of which nothing says the unit: seconds, or days of a spreadsheet, if they can be
    nothing else."""
    if len(values) < 2:
        return _Clock(index, "", asked=f"the unit of {label} is not said")
    days = _in(index, values, "day")
    if SERIAL_DAYS[0] < values[0] < SERIAL_DAYS[1] and plausible(days.rate_hz):
        return replace(days, why="a spreadsheet's days", guess=f"{label} counts days")
    span, able = float(values[-1] - values[0]), []
    for unit in PLAIN:
        found = _in(index, values, unit)
        if plausible(found.rate_hz) and (unit == "s" or span * SECONDS[unit] >= SHORTEST_S):
            able.append(found)
    plain = NAMELESS.fullmatch(label) or not re.search(r"[\d(]", label)  # "Time (0.1 ms)"
    if [found.unit for found in able] == ["s"] and abs(values[0]) < 1e9 and plain:
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
    good: Sequence[_Clock], columns: Sequence[Column], stated: Mapping[float, Stated]
) -> Timing:
    """The best clock, if no other and no line of the file says another rate. Raises `ExchangeError`
    where two of them are called alike and differ."""
    best = good[0]
    for other in good[1:]:
        one, two = columns[best.index], columns[other.index]
        if one.label == two.label and not _same(one, two):
            raise ExchangeError(
                f"columns {best.index + 1} and {other.index + 1} are both called {one.label} and"
                f" differ: {OWN_CLOCKS}"
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
    wrong = {r: said for r, said in stated.items() if abs(r / best.rate_hz - 1) > AGREE}
    questions: tuple[Question, ...] = ()
    if wrong and len(wrong) == len(stated):
        words = f"{says(wrong)}, the stamps go at {best.rate_hz:.6g} Hz: which is right?"
        questions = (Question("rate_hz", words),)
    return Timing(best.index, best.unit, None, best.why, best.guess, questions)


def _check_own_clocks(clocks: Sequence[_Clock], columns: Sequence[Column]) -> None:
    """Raise `ExchangeError` where each clock stands before as many channels as every other one and
    tells another time."""
    times = {
        clock.index: held * SECONDS.get(clock.unit, 1.0)
        for clock in clocks
        if (held := columns[clock.index].values) is not None
    }
    at = sorted(times)
    if len(at) < 2:
        return
    numbers = [k for k, column in enumerate(columns) if column.values is not None]
    behind = {
        sum(k < j < end for j in numbers)
        for k, end in zip(at, [*at[1:], len(columns)], strict=True)
    }
    if at[0] != numbers[0] or len(behind) > 1 or behind == {0}:
        return
    first = times[at[0]]
    step = float(np.median(np.diff(first)))
    if any(not np.abs(times[k] - first).max() < STRAY * step for k in at[1:]):
        names = " and ".join(f"{columns[k].label} (column {k + 1})" for k in at[:2])
        raise ExchangeError(f"{names} differ, each before its own channels: {OWN_CLOCKS}")


def _same(one: Column, two: Column) -> bool:
    """Whether two columns hold the same numbers."""
    if one.values is None or two.values is None:
        return False
    return np.array_equal(one.values, two.values, equal_nan=True)
