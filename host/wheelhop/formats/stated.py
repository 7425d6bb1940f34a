"""The sample rate that the lines above a table state."""

from __future__ import annotations

import re
from collections.abc import Sequence

from wheelhop.files.units import seconds_in
from wheelhop.formats.digits import tell

SAMPLED = r"(?:sampl\w*|abtast\w*|scan\w*|logg?\w*|acqui\w*|daq)"
RATED = rf"(?:{SAMPLED}|data|record\w*|output|mess\w*|measur\w*)"
NUMBER = r"[^\d\n+-]{0,20}?(?P<number>\d[\d.,]*(?:e[+-]?\d+)?)"
RATE = re.compile(
    rf"(?:\b{RATED}[\s_.-]*(?:rate|fr\w*q\w*)|\b(?:odr|fs)\b)"
    rf"(?:[\s_]*[\[(]?hz[\])]?)?{NUMBER}[\s\",;]*(?P<unit>[a-zµμ]*(?:/[a-z]+)?)",
    re.IGNORECASE,
)
INTERVAL = re.compile(
    rf"(?:\b(?:{SAMPLED}[\s_.-]*(?:interval\w*|period)|(?:sampl\w*|abtast)[\s_.-]*(?:time|zeit)"
    rf"|time[\s_.-]*(?:interval|step)|zeitschritt|dt|delta[\s_]?[tx])\b){NUMBER}"
    r"[\s\",;]*(?P<unit>[a-zµμ]+)",
    re.IGNORECASE,
)
PER_SECOND = {
    **dict.fromkeys(("", "hz", "sps", "samples/s", "scans/s", "s/s"), 1.0),
    "khz": 1e3,
}


def stated_rates(lines: Sequence[str]) -> dict[float, int]:
    """The sample rates, Hz, that these lines state, each with the number of its line from 1."""
    found: dict[float, int] = {}
    for number, line in enumerate(lines, start=1):
        for match in RATE.finditer(line):
            rate = _number(match["number"])
            unit = match["unit"].lower()
            if rate and unit in PER_SECOND:
                found.setdefault(rate * PER_SECOND[unit], number)
            elif rate and (seconds := seconds_in(unit)):  # "sample rate 10 ms"
                found.setdefault(float(f"{1.0 / (rate * seconds):.9g}"), number)
        for match in INTERVAL.finditer(line):
            step, size = _number(match["number"]), seconds_in(match["unit"])
            if step and size:
                found.setdefault(float(f"{1.0 / (step * size):.9g}"), number)
    return found


def _number(text: str) -> float | None:
    """The number, None if its marks can be read in two ways."""
    text = text.rstrip(".,")
    digits = tell([[text]], None)
    if digits.asked and "." not in text:
        return None
    plain = text.replace(digits.thousands, "") if digits.thousands else text
    try:
        return float(plain.replace(digits.decimal, "."))
    except ValueError:
        return None
