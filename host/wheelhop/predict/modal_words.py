"""Modes in words: which parts of a vehicle move, bend and damp."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from wheelhop.predict.modal import Modes

SHOWN, WORTH = 3, 0.05
"""So many parts are named, and of those none with less of the energy than this."""
WHEELS = {"1": "front wheels", "2": "front wheels", "3": "rear wheels", "4": "rear wheels"}
PARTS = (
    (r"suspension\.(\w+)\..*", r"\1 suspension"),
    (r"wheel\.(\w+)\..*", r"\1 tyres"),
    (r"(\w+)\.(?:stiffness|damping)_N.*", r"\1 mount"),
    (r"frame\..*", "frame"),
    (r"([\w-]+)\..*", r"\1"),
)


def by_place(found: Modes, k: int) -> dict[str, float]:
    """Shares of a mode's kinetic energy, wheels of an axle together, and all modes of a frame."""
    shares: dict[str, float] = {}
    for name, share in zip(found.coordinates, found.kinetic[k].tolist(), strict=True):
        words = name.split()
        place = WHEELS[words[1]] if words[0] == "axle" else name
        place = "frame" if words[0] == "frame" else place
        shares[place] = shares.get(place, 0.0) + share
    return shares


def by_part(found: Modes, shares: Any) -> dict[str, float]:
    """Shares (p,) of the numbers' springs or dampers, by the part they belong to."""
    parts: dict[str, float] = {}
    for number, share in zip(found.numbers, shares.tolist(), strict=True):
        part = _part(number)
        parts[part] = parts.get(part, 0.0) + share
    return parts


def strongest(shares: Mapping[str, float]) -> str:
    """The parts with most of it, a line each."""
    first = sorted(shares.items(), key=lambda pair: -pair[1])[:SHOWN]
    return "\n".join(f"{name} {100 * share:.0f} %" for name, share in first if share >= WORTH)


def _part(number: str) -> str:
    for pattern, words in PARTS:
        if re.fullmatch(pattern, number):
            return re.sub(pattern, words, number)
    return number
