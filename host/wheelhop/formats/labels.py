"""What a column is called: its name, and the unit that many recorders write behind it."""

from __future__ import annotations

import re

from wheelhop.files.units import SECONDS, SPELT

BEHIND = re.compile(r"(?P<name>.*?\S)\s*(?:\[(?P<b>[^][]*)\]|\((?P<p>[^()]*)\))\s*$")
UNDERSCORED = {
    "_m_s2": "m/s²",
    "_g": "g",
    "_mg": "mg",
    "_ms": "ms",
    "_us": "us",
    "_m_s": "m/s",
    "_rad_s": "rad/s",
    "_deg_s": "deg/s",
    "_s": "s",
    "_mm": "mm",
    "_m": "m",
    "_V": "V",
    "_mV": "mV",
    "_N": "N",
}


def name_and_unit(label: str) -> tuple[str, str]:
    """Split "Acc FL [g]", "Acc FL (g)", "Acc FL / g" or "acc_fl_m_s2"; the unit may be empty.

    In round brackets, and behind a slash, only a unit that is known is taken for one.
    """
    match = BEHIND.match(label)
    if match and (match["b"] is not None or is_unit(match["p"])):
        return match["name"], (match["b"] or match["p"] or "").strip()
    name, slash, unit = label.partition(" / ")
    if slash and is_unit(unit):
        return name.strip(), unit.strip()
    for tail, known in UNDERSCORED.items():
        if label.endswith(tail) and len(label) > len(tail):
            return label.removesuffix(tail), known
    return label, ""


def is_unit(text: str) -> bool:
    """Whether this is a unit that is known here."""
    return text.strip() in SPELT or text.strip() in SECONDS
