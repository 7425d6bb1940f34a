"""Where a channel sits, guessed from what people call it; the user confirms it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

CORNERS = (
    ("fl", "lf", "vl", "frontleft", "leftfront", "vornelinks", "avg"),
    ("fr", "rf", "vr", "frontright", "rightfront", "vornerechts", "avd"),
    ("rl", "lr", "hl", "rearleft", "leftrear", "hintenlinks", "arg"),
    ("rr", "hr", "rearright", "rightrear", "hintenrechts", "ard"),
)
"""Front left, front right, rear left, rear right, as they are called."""
AXLE = ("axle", "wheel", "hub", "upright", "unsprung", "knuckle", "rad", "achse", "us", "whl")
BODY = ("body", "chassis", "frame", "sprung", "strut", "tower", "aufbau", "rahmen", "top", "bdy")


ALONG = {"x": {"x", "ax", "long", "longitudinal"}, "y": {"y", "ay", "lat", "lateral"}}
OTHER_WAYS = frozenset().union(*ALONG.values())
ABOARD = {"driver", "engine", "motor", "battery", "payload"}
DOWN = re.compile(r"-\s*[zZ]\b|(?i:\bdown)")
"""What sits at a place is measured upwards: along x and y, or downwards, it is something else."""


def likely_points(names: Sequence[str]) -> list[str]:
    """The points that the names of a recording's accelerometers seem to mean, each "" if unknown.

    Corners alone (FL, FR, RL, RR) are the axles where the others are on the body, else the body:
    most people begin there. A point that two names seem to mean is given to neither.
    """
    found = [likely_point(name) for name in names]
    bare = "A" if {point[:1] for point in found} - {""} == {"B"} else "B"
    for i, name in enumerate(names):
        words = _words(name)
        corner = _corner(words)
        elsewhere = OTHER_WAYS.intersection(words) or DOWN.search(name)
        if not (found[i] or elsewhere or corner is None or {*words} & {*AXLE, *BODY}):
            found[i] = f"{bare}{corner + 1}"
    count = Counter(found)
    return [point if count[point] == 1 else "" for point in found]


def likely_point(name: str) -> str:
    """The point, A1 … A4 or B1 … B4, that a name seems to mean; "" if it does not say, or says
    another direction than up."""
    words = _words(name)
    if OTHER_WAYS.intersection(words) or DOWN.search(name):
        return ""
    for word, digit in pairwise(words):
        if word in ("a", "b") and digit in ("1", "2", "3", "4"):
            return f"{word.upper()}{digit}"
    corner = _corner(words)
    axle, body = (any(word in known for word in words) for known in (AXLE, BODY))
    if corner is None or axle == body:
        return ""
    return f"{'A' if axle else 'B'}{corner + 1}"


def likely_on_body(names: Sequence[str]) -> list[str]:
    """Where on the body the accelerometers sit whose names tell no point, each "" if unknown: along
    x and y one each, "along:x", and upwards "body", the place unknown, if there is but one."""
    found = []
    for name in names:
        words = {*_words(name)}
        ways = [way for way, known in ALONG.items() if words & known]
        elsewhere = _corner(_words(name)) is not None or words & {*AXLE, *ABOARD}
        if elsewhere or len(ways) > 1 or DOWN.search(name):
            found.append("")
        else:
            found.append(f"along:{ways[0]}" if ways else "body")
    count = Counter(found)
    return [place if count[place] == 1 else "" for place in found]


def likely_quantity(name: str, si_unit: str) -> str:
    """The word for a channel of another quantity, as `wheelhop.campaign.channels.place_of` takes
    it, that its unit and its name seem to mean: "travel:1", "rate:pitch"; "" if they do not say."""
    words = _words(name)
    corner = _corner(words)
    if si_unit in ("m", "N") and corner is not None:
        return f"{'travel' if si_unit == 'm' else 'force'}:{corner + 1}"
    if si_unit == "rad/s":
        axes = [axis for axis in ("pitch", "roll") if axis in words]
        if len(axes) == 1:
            return f"rate:{axes[0]}"
        if corner is not None and {"wheel", "whl"} & {*words}:
            return f"speed:wheel:{corner + 1}"
        return "speed:engine" if {"rpm", "engine", "motor"} & {*words} else ""
    return "speed" if si_unit == "m/s" else ""


GOOD_FOR = {
    "m": "travel:CORNER",
    "N": "force:CORNER",
    "rad/s": "rate:pitch or rate:roll",
    "m/s": "speed",
}


def good_for(name: str, si_unit: str) -> str:
    """What a channel that is no acceleration may be in a campaign, as `likely_quantity` says it, or
    as its unit alone allows; "" for nothing."""
    return likely_quantity(name, si_unit) or GOOD_FOR.get(si_unit, "")


def _words(name: str) -> list[str]:
    return re.findall(r"[a-z]+|\d+", re.sub(r"([a-z])([A-Z])", r"\1 \2", name).lower())


def _corner(words: list[str]) -> int | None:
    joined = {*words, *(a + b for a, b in pairwise(words))}
    found = [i for i, names in enumerate(CORNERS) if joined.intersection(names)]
    return found[0] if len(found) == 1 else None
