"""Time stamps as seconds: numbers in a unit of time, dates, times of day, and counters."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, date, datetime

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.units import SECONDS
from wheelhop.formats.error import ExchangeError

CLOCK, MINUTES, DIGITS, SAMPLE = "clock", "mm:ss", "hhmmss", "sample"
"""Units of time beside those of `SECONDS`: dates or times of day; minutes and seconds; a time of
day in one number, 102133.25; and a counter of samples, whose rate must be known."""
UNITS = (*("s", "ms", "us", "ns", "min", "h", "day"), CLOCK, MINUTES, DIGITS, SAMPLE)
"""What errors and drafts offer; every spelling of `SECONDS` is understood."""
EPOCH_S = (1e9, 3e9)
"""Seconds since 1970 from 2001 to 2065; LabVIEW counts since 1904, which is more than that."""
NOTHING: tuple[str, ...] = ()
HOUR_S, DAY_S = 3600.0, 86400.0
STAMP = re.compile(
    r"(?:(?P<date>\d{1,4}([-./])(?:\d{1,2}|[A-Za-z]{3,9})\2\d{1,4})[T ,;]\s*)?"
    r"(?P<a>\d{1,3}):(?P<b>[0-5]\d)(?::(?P<c>[0-5]\d))?(?:[.,](?P<f>\d+)|:(?P<ms>\d{3}))?"
    r"(?:\s*(?P<half>[AaPp])\.?[Mm]\.?)?"
    r"\s*(?P<zone>Z|UTC|GMT|[+-]\d{2}:?\d{2})?"
)
MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
GERMAN = {"mär": 3, "mrz": 3, "mai": 5, "okt": 10, "dez": 12}
ORDERS = ((0, 1, 2), (2, 1, 0), (2, 0, 1))
"""Where year, month and day stand in a date."""


@dataclass(frozen=True, eq=False)
class Stamps:
    """Seconds (n,) of a clock, the Unix time of its zero if it is known, and what is worth a line
    in the history."""

    time_s: NDArray[np.float64]
    start_unix_s: float | None = None
    remarks: tuple[str, ...] = field(default=())


def is_stamp(cell: str) -> bool:
    """Whether a cell is a date with a time, or a time of day."""
    return STAMP.fullmatch(cell.strip()) is not None or _iso(cell) is not None


def of_numbers(
    values: NDArray[np.float64], unit: str, where: Callable[[int], str], rate_hz: float | None
) -> Stamps:
    """Stamps that are numbers (n,), in a unit of `SECONDS`, `DIGITS` or `SAMPLE`.

    Raises `ExchangeError` for a counter without a rate, or numbers that are no such stamps.
    """
    if unit == SAMPLE:
        return _counted(values, where, rate_hz)
    if unit == DIGITS:
        return _digits(values, where)
    size = SECONDS[unit]
    if is_epoch(values[:1], size):
        return Stamps((values - values[0]) * size, float(values[0]) * size)
    counted, remarks = values, NOTHING
    if len(values) and unit in ("ms", "us"):
        counted, remarks = _onwards(values, 2.0**32, "the clock overflows", where)
    return Stamps(counted * size, None, remarks)


def is_epoch(values: NDArray[np.float64], size: float) -> bool:
    """Whether all of these are seconds since 1970, counted in units of `size` seconds."""
    since = values * size
    return bool(len(values)) and bool(((since > EPOCH_S[0]) & (since < EPOCH_S[1])).all())


def of_texts(cells: Sequence[str], unit: str, where: Callable[[int], str]) -> Stamps:
    """Stamps that are texts: dates with a time, times of day, or (as `MINUTES` says, or their
    fractions show) minutes and seconds.

    Raises `ExchangeError` for one that is none, or may be minutes or hours.
    """
    seconds, days, zones = np.empty(len(cells)), [], []
    kinds = set()
    for row, cell in enumerate(cells):
        found = STAMP.fullmatch(cell.strip()) or _iso(cell)
        if found is None:
            raise ExchangeError(
                f"{where(row)}: '{cell.strip()[:40]}' is no time: write 2026-05-01 12:34:56.789 or "
                "12:34:56.789"
            )
        a, b, c = (int(found[key] or 0) for key in ("a", "b", "c"))
        fraction = float(f"0.{found['f'] or found['ms'] or 0}")
        if found["c"] is None:
            kinds.add("fraction" if found["f"] else "two")
            seconds[row] = 60 * a + b + fraction
        else:
            kinds.add("three")
            if found["half"]:
                a = a % 12 + (12 if found["half"].lower() == "p" else 0)
            seconds[row] = HOUR_S * a + 60 * b + c + fraction
        days.append(found["date"] or "")
        zones.append(found["zone"] or "")
    dated = bool(days and days[0])
    if len(kinds - {"fraction", "two"}) and kinds != {"three"}:
        raise ExchangeError(f"{where(0)}: some times have hours, minutes and seconds, others not")
    span = DAY_S
    if "three" not in kinds:
        if dated or (kinds == {"two"} and unit != MINUTES):
            raise ExchangeError(
                f"{where(0)}: '{cells[0].strip()[:40]}' may be hours and minutes, or minutes and "
                f'seconds: say time_unit = "{MINUTES}", or give the time with its seconds'
            )
        span = HOUR_S
    if len({bool(day) for day in days}) > 1:
        raise ExchangeError(f"{where(0)}: only some of the times have a date")
    if len({bool(zone) for zone in zones}) > 1:
        row = next(k for k, zone in enumerate(zones) if bool(zone) != bool(zones[0]))
        raise ExchangeError(f"{where(row)}: only some of the times have a time zone")
    seconds -= np.array([_offset_s(zone) for zone in zones])
    if dated:
        first, since_s = _dates(days, seconds, where)
        seconds = seconds + since_s
        zero = first.timestamp() + float(seconds[0]) if zones[0] and first else None
        return Stamps(seconds - seconds[0], zero)
    what = "the clock passes midnight" if span == DAY_S else "the clock passes a full hour"
    onwards, remarks = _onwards(seconds, span, what, where)
    return Stamps(onwards - (onwards[0] if len(onwards) else 0.0), None, remarks)


def _dates(
    days: list[str], seconds: NDArray[np.float64], where: Callable[[int], str]
) -> tuple[datetime | None, NDArray[np.float64]]:
    """The first day, None if it may be one of several, and since then the days (n,) in seconds; the
    order of day and month is the one in which time rises."""
    found = []
    for order in ORDERS:
        try:
            known = {text: _day(text, order) for text in set(days)}
        except ValueError:
            continue
        first = known[days[0]]
        since = np.array([DAY_S * (known[text] - first).days for text in days])
        if (np.diff(since + seconds) >= 0).all():
            found.append((first, since))
    if not found:
        known_days = next(iter(dict.fromkeys(days)))
        raise ExchangeError(f"{where(0)}: '{known_days}': these dates do not rise, or are none")
    if any(not np.array_equal(found[0][1], since) for _, since in found):
        raise ExchangeError(
            f"{where(0)}: '{days[0]}' may be day and month, or month and day: write 2026-05-01"
        )
    first = found[0][0]
    if any(other != first for other, _ in found):
        return None, found[0][1]
    return datetime(first.year, first.month, first.day, tzinfo=UTC), found[0][1]


def _day(text: str, order: tuple[int, int, int]) -> date:
    parts = re.split(r"[-./]", text)
    year, month, day = (parts[k] for k in order)
    if not month.isdigit():
        name = month[:3].lower()
        month = str(GERMAN.get(name) or MONTHS.index(name) + 1)
    if len(day) > 2 or len(year) not in (2, 4):
        raise ValueError
    return date(int(year) + (2000 if len(year) == 2 else 0), int(month), int(day))


def _iso(cell: str) -> re.Match[str] | None:
    """A date and time of ISO 8601 in one of its shorter forms, as `STAMP` has it."""
    try:
        found = datetime.fromisoformat(cell.strip())
    except ValueError:
        return None
    if "T" not in cell and " " not in cell.strip():
        return None  # a day alone
    return STAMP.fullmatch(found.isoformat(sep=" ", timespec="microseconds"))


def _offset_s(zone: str) -> float:
    if zone in ("", "Z", "UTC", "GMT"):
        return 0.0
    offset = HOUR_S * int(zone[1:3]) + 60.0 * int(zone[-2:])
    return -offset if zone[0] == "-" else offset


def _digits(values: NDArray[np.float64], where: Callable[[int], str]) -> Stamps:
    hours, minutes, seconds = values // 10000, values // 100 % 100, values % 100
    wrong = ~((hours < 24) & (minutes < 60) & (seconds < 60) & (values >= 0))
    if wrong.any():
        row = int(np.argmax(wrong))
        raise ExchangeError(f"{where(row)}: {values[row]:.10g} is no time of day as {DIGITS}")
    since = HOUR_S * hours + 60 * minutes + seconds
    onwards, remarks = _onwards(since, DAY_S, "the clock passes midnight", where)
    return Stamps(onwards - onwards[0], None, remarks)


def _counted(
    values: NDArray[np.float64], where: Callable[[int], str], rate_hz: float | None
) -> Stamps:
    if rate_hz is None:
        raise ExchangeError(
            f"{where(0)}: a counter says no time: give rate_hz, how many samples a second has"
        )
    broken = values != np.round(values)
    if broken.any():
        row = int(np.argmax(broken))
        raise ExchangeError(f"{where(row)}: {values[row]:.10g} is no whole number: no counter")
    top = float(values.max(initial=0.0)) + 1
    sizes = (*(2.0**bits for bits in (8, 10, 12, 16, 24, 32)), *(10.0**k for k in range(2, 10)))
    counted, remarks = values, NOTHING
    if top in sizes:
        counted, remarks = _onwards(values, top, "the counter begins again", where)
    return Stamps((counted - counted[0]) / rate_hz, None, remarks)


def _onwards(
    values: NDArray[np.float64], span: float, what: str, where: Callable[[int], str]
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Values that go on where they fall by most of `span`, after which they begin again."""
    falls = np.concatenate([[False], np.diff(values) < -span / 2]) if len(values) else values > 0
    if not falls.any():
        return values, ()
    place = where(int(np.argmax(falls))).rpartition(": ")[2]
    return values + span * np.cumsum(falls), (f"{what} at {place}: counted on",)
