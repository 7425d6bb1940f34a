"""The sample rate that the lines above a table state."""

from __future__ import annotations

import re
from collections.abc import Sequence

from wheelhop.files.units import seconds_in
from wheelhop.formats.columns import Stated
from wheelhop.formats.digits import tell

SAMPLED = r"(?:sampl\w*?|abtast\w*?|scan\w*?|logg?\w*?|acqui\w*?|daq)"
RATED = rf"(?:{SAMPLED}|data|record\w*?|output|mess\w*?|measur\w*?)"
MARKS = r"[\s:=;,|\"'._]*"
"""What may stand between the words, the number and its unit; any other word there makes it another
statement: "sample rate divider: 4"."""
UNIT = r"(?:1/s|[a-zµμ]+(?:\s?/\s?[a-z]+|\sper\s[a-z]+)?)"
VALUE = (
    rf"(?:[\s_]*[\[(]?(?P<before>(?:k|m)?hz|k?s/s|sps|1/s|samples/s|m?s|[uµμ]s)\b[\])]?)?{MARKS}"
    r"(?:(?:is|of|at|von|ist)\s+)?(?P<number>\d[\d.,]*+(?:e[+-]?\d+)?)"
    rf"(?!\s*(?:[/*:×%+]|-\s*\d))[\s\",;\[(]*(?P<unit>{UNIT})?"
)
RATE = re.compile(
    rf"\b(?:{RATED}[\s_.-]*(?:rate|fr\w{{0,4}}q\w*?)(?:[\s_]*\(?\bodr\)?)?|odr|fs){VALUE}",
    re.IGNORECASE,
)
INTERVAL = re.compile(
    rf"\b(?:{SAMPLED}[\s_.-]*(?:interval\w*?|period)|(?:sampl\w*?|abtast)[\s_.-]*(?:time|zeit)"
    rf"|time[\s_.-]*(?:interval|step)|zeitschritt|dt|delta[\s_]?[tx]){VALUE}",
    re.IGNORECASE,
)
OPENERS = re.compile(r"[,;|:=\t\"'#%({\[]")
NEUTRAL = frozenset(
    (
        *("the", "a", "an", "output", "data", "input", "sensor", "logger", "logging", "log", "raw"),
        *("system", "adc", "daq", "imu", "acc", "accel", "accelerometer", "signal", "channel"),
        *("channels", "device", "file", "recording", "analog", "analogue", "measurement", "test"),
        *("effective", "actual", "current", "main", "hz", "at", "with", "die", "der"),
    )
)
"""Words before a rate that leave it the table's own; "GPS sample rate" and "max sample rate" are
other statements."""
PER_SECOND = {
    **dict.fromkeys(("hz", "sps", "s/s", "1/s"), 1.0),
    **{
        f"{what}{per}": 1.0
        for what in ("samples", "scans", "sample", "scan")
        for per in ("/s", "/sec", "/second", " per second", " per sec", " per s")
    },
    **dict.fromkeys(("khz", "ks/s", "ksps"), 1e3),
    "mhz": 1e6,
}


def stated_rates(lines: Sequence[str], decimal: str) -> dict[float, Stated]:
    """The sample rates, Hz, that these lines state, each with the number of its line from 1;
    `decimal` is the sign that the numbers of the file have, "" if they have none."""
    found: dict[float, Stated] = {}
    for number, line in enumerate(lines, start=1):
        for pattern in (RATE, INTERVAL):
            for match in pattern.finditer(line):
                before = OPENERS.split(line[: match.start()])[-1]
                others = set(re.findall(r"[^\W\d_]+", before.lower())) - NEUTRAL
                value = None if others else _number(match["number"], decimal)
                rate = value and _rate(value, match, pattern is RATE)
                if rate:
                    bare = not (match["before"] or match["unit"])
                    found.setdefault(float(f"{rate:.9g}"), Stated(f"line {number}", bare))
    return found


def _rate(value: float, match: re.Match[str], is_rate: bool) -> float | None:
    """Samples per second; None where the unit is not known, or not said of an interval or of what
    may be bits per second."""
    said = (match["unit"] or match["before"] or "").lower()
    unit = re.sub(r"\s?/\s?", "/", said)
    size = PER_SECOND.get(unit, PER_SECOND.get(unit.partition(" per ")[0]))
    if is_rate and size is not None:
        return value * size
    if seconds := seconds_in(unit):  # "sample rate 10 ms"
        return 1.0 / (value * seconds)
    bits = re.match(r"(?:data|output)[\s_.-]*rate", match[0], re.IGNORECASE)
    return value if is_rate and not unit and not bits else None


def _number(text: str, decimal: str) -> float | None:
    """The number, None if its marks can be read in two ways and the file's others do not tell."""
    text = text.rstrip(".,")
    digits = tell([[text]], None)
    mark, thousands = digits.decimal, digits.thousands
    if digits.asked:
        if not decimal:
            return None
        mark, thousands = decimal, "." if decimal == "," else ","
    plain = text.replace(thousands, "") if thousands else text
    try:
        return float(plain.replace(mark, ".")) or None
    except ValueError:
        return None
