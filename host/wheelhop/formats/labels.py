"""What a column is called: its name, and the unit that many recorders write behind it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from wheelhop.files.units import is_measured, seconds_in

BEHIND = re.compile(r"(?P<name>.*?\S)\s*(?:\[(?P<b>[^][]*)\]|\((?P<p>[^()]*)\))\s*$")
BEHIND_WORD = re.compile(r"(?P<name>.*?\S)(?:\s+in\s+|\s*,\s+|\s+/\s+)(?P<unit>\S+)\s*$")
RACECAPTURE = re.compile(r'(?P<name>[^|]+)\|"?(?P<unit>[^|"]*)"?(?:\|[-+.\d]*){3}')
"""Name, unit, least, most and rate: `"AccelX"|"G"|-2.0|2.0|25`."""
UNDERSCORED = {
    "_m_s2": "m/s²",
    "_mm_s2": "mm/s²",
    "_deg_s": "deg/s",
    "_rad_s": "rad/s",
    "_km_h": "km/h",
    "_mm_s": "mm/s",
    "_m_s": "m/s",
    "_millis": "ms",
    "_micros": "us",
    "_nanos": "ns",
    "_kmph": "km/h",
    "_kmh": "km/h",
    "_kph": "km/h",
    "_mph": "mph",
    "_dps": "deg/s",
    "_bar": "bar",
    "_deg": "deg",
    "_rad": "rad",
    "_lbf": "lbf",
    "_lbs": "lbs",
    "_kN": "kN",
    "_Nm": "N m",
    "_mg": "mg",
    "_ms": "ms",
    "_us": "us",
    "_ns": "ns",
    "_mm": "mm",
    "_cm": "cm",
    "_mV": "mV",
    "_sec": "s",
    "_g": "g",
    "_G": "g",
    "_s": "s",
    "_m": "m",
    "_V": "V",
    "_N": "N",
}
"""Endings of names, those first that end in another one."""
DOUBTFUL = re.compile(r".*_(?:[A-Za-z]|bar|rad|cm|us)")
"""Endings that may be something else: z_g at the ground, a roll_bar, the centre of mass, the German
wheel, what is unsprung."""


def name_and_unit(label: str, endings: bool = True) -> tuple[str, str]:
    """Split "Acc FL [g]", "Acc FL (g)", "Acc FL / g", "Acc FL, g", "Acc FL in g", "acc_fl_m_s2" or
    what RaceCapture writes; the unit may be empty.

    But for square brackets and RaceCapture's, only a unit that is known is taken for one; without
    `endings`, none behind an underscore.
    """
    if match := RACECAPTURE.fullmatch(label):
        return match["name"].strip('" '), match["unit"].strip()
    match = BEHIND.match(label)
    if match and (match["b"] is not None or is_unit(match["p"])):
        return match["name"], bare_unit(match["b"] or match["p"] or "")
    match = BEHIND_WORD.match(label)
    if match and is_unit(match["unit"]):
        return match["name"], match["unit"]
    for tail, known in UNDERSCORED.items() if endings else ():
        if label.endswith(tail) and len(label) > len(tail):
            return label.removesuffix(tail), known
    return label, ""


def is_doubtful(label: str) -> bool:
    """Whether the unit at the end of a name may be no unit."""
    return DOUBTFUL.fullmatch(label) is not None


NO_UNITS = frozenset(("", "-", "--", "1", "none", "n/a", "*"))
"""What stands in a line of units where there is none."""


def bare_unit(cell: str) -> str:
    """A unit without its brackets, "" where there is none."""
    inside = re.fullmatch(r"\s*(?:\[(.*)\]|\((.*)\))\s*", cell)
    found = ((inside[1] or inside[2] or "") if inside else cell).strip()
    return "" if found.lower() in NO_UNITS else found


def joined_heads(heads: Sequence[Sequence[str]]) -> list[str]:
    """The names of columns that stand in several lines, from above to below."""
    columns = (
        [head[k] for head in heads if k < len(head)] for k in range(max(map(len, heads), default=0))
    )
    return [" ".join(dict.fromkeys(part for part in parts if part)) for parts in columns]


def apart(names: Sequence[str], units: Sequence[str], numbers: Sequence[int]) -> list[str]:
    """Names of columns, those that occur several times kept apart by their unit, "Force (N)", or
    else by the number of their column."""
    count = Counter(names)
    told = [f"{n} ({u})" if u and count[n] > 1 else n for n, u in zip(names, units, strict=True)]
    again = Counter(told)
    return [
        name if again[name] == 1 else f"{name} (column {number})"
        for name, number in zip(told, numbers, strict=True)
    ]


def is_unit(text: str) -> bool:
    """Whether this is a unit that is known here."""
    return is_measured(text) or seconds_in(text) is not None
