"""The campaign as its files describe it, and as a mistake would have made it: likelihoods of both.

A mistake that concerns all runs alike (speeds in m/s, left and right exchanged, the sample rate) is
another `Description`; each is matched to every run, and runs add up.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import BODY_POINTS, Campaign, Channel
from wheelhop.campaign.channel import ACCELERATION
from wheelhop.files.units import SPELT
from wheelhop.gate.drive import Drive, speeds_about
from wheelhop.gate.match import Match, Places

Array = NDArray[np.float64]

FACTORS = np.geomspace(0.2, 5.0, 33)
"""By which a stated speed may be wrong: neighbours are a tenth apart, less than their reach."""
RATES = (0.25, 0.5, 2.0, 4.0)
DELAYS_S = tuple(sign * 0.02 * k for k in range(2, 11) for sign in (1, -1))
"""Two loggers out of step; what lies between neighbours still shows. Less than a quarter of a
wheel's period is a phase that laws the nominal vehicle lacks can make."""
OTHER_UNITS = {
    quantity: {name: 1 / SPELT[name][1] for name in names}
    for quantity, names in {
        ACCELERATION: ("g", "mg", "cm/s²", "mm/s²", "ft/s²"),
        "travel": ("mm", "cm", "inch"),
        "rate": ("deg/s",),
        "force": ("kN", "lbf"),
    }.items()
}
OTHER_UNITS["rate"]["rad/s converted as if they were deg/s"] = SPELT["deg/s"][1]
"""What a quantity's records may be in, and their number over the same in SI."""
ALONE = {
    ACCELERATION: ("g", "mm/s²"),
    "travel": ("mm", "inch"),
    "rate": ("deg/s",),
    "force": ("kN",),
}
"""What a single channel may be in."""
LOGGERS_S = tuple(sign * 0.02 * k for k in range(2, 26) for sign in (1, -1))
"""Delays of sensors that have a logger of their own: two clocks, set by hand, are half a second
apart."""
RATIOS = tuple(factor**sign for factor in np.geomspace(1.5, 4.0, 5).tolist() for sign in (1, -1))
"""By which a ratio of sensor to wheel may be wrong: forgotten, upside down, squared; neighbours are
a quarter apart. What is less may be springs that are believed to 10 %, or a law they lack."""
RECORDED_APART = ("channels of travel", "channels of rates", "channels of force")
"""Quantities that a logger of its own may have recorded."""
REVERSED = "the wrong way round"
UNLIKE = 0.3
"""Standard deviation of a run's gain about the campaign's, of its logarithm: what effects that the
nominal vehicle lacks do to one run more than to another."""


@dataclass(frozen=True)
class Description:
    """`kind` "" is the campaign as its files say; `channels` are those concerned; the true speed is
    the stated one times `speed`, the true sample rate the stated one times `rate`."""

    kind: str
    words: str
    places: Places
    channels: tuple[str, ...] = ()
    speed: float = 1.0
    rate: float = 1.0


def stated(channels: Sequence[Channel]) -> Description:
    """The campaign as its files describe it."""
    return Description("", "as described", Places())


def other_descriptions(channels: Sequence[Channel]) -> Iterator[Description]:
    """Mistakes that all runs share."""
    n, same, quantities = len(channels), Places(), [c.quantity for c in channels]
    for factor in FACTORS:
        if abs(np.log(factor)) > np.log(1.2):  # within a hand-held speed there is no mistake
            yield Description("speed", "", same, speed=float(factor))
    for rate in RATES:
        yield Description("sample-rate", "", same, rate=rate)
    # The sign of a gyro is another one in every book: commoner than sides that are exchanged, which
    # turn what potentiometers say of roll as well.
    gyros = [i for i in range(n) if n > 2 and quantities[i] == "rate"]
    yield from (_reversed(channels, i) for i in gyros)
    points = [c.point for c in channels]
    kinds = {q: [i for i, c in enumerate(channels) if c.quantity == q] for q in ALONE}
    for words, renamed in (
        ("body and axle channels are", {"A": "B", "B": "A"}),
        ("left and right are", {"1": "2", "2": "1", "3": "4", "4": "3"}),
        ("front and rear are", {"1": "3", "3": "1", "2": "4", "4": "2"}),
        ("front and rear, left and right are", {"1": "4", "4": "1", "2": "3", "3": "2"}),
    ):
        places = _renamed(channels, renamed)
        if places is not None:
            yield Description("exchanged", words, places, tuple(c.name for c in channels))
    axles = [i for i, c in enumerate(channels) if c.is_axle]
    body = [i for i in kinds[ACCELERATION] if points[i] in BODY_POINTS]
    others = [kinds[quantity] for quantity in ("travel", "rate", "force")]
    for of_kind in (axles, body, *others):
        if 1 < len(of_kind) < n:
            names = tuple(channels[i].name for i in of_kind)
            how = "are upside down" if channels[of_kind[0]].is_acceleration else f"count {REVERSED}"
            yield Description("polarity", how, _inverted(of_kind), names)
    # A left side that is late is no sign of a clock: sides may meet a track at other times.
    for what, late in (("the axles", axles), *zip(RECORDED_APART, others, strict=True)):
        if not 0 < len(late) < n:
            continue
        names = tuple(channels[i].name for i in late)
        for delay in DELAYS_S if late is axles else LOGGERS_S:
            places = _moved(late, late, delay)
            words = f"{what} are {abs(delay) * 1e3:.0f} ms {'late' if delay > 0 else 'early'}"
            yield Description("out-of-step", words, places, names)
    for quantity, of_kind in kinds.items():
        if 1 < len(of_kind) < n:
            names = tuple(channels[i].name for i in of_kind)
            for unit, factor in OTHER_UNITS[quantity].items():
                yield Description("units", unit, _scaled(of_kind, factor), names)
    yield from _ratios(channels)
    for k, channel in enumerate(channels if n > 2 else ()):
        for unit in ALONE[channel.quantity]:
            factor = OTHER_UNITS[channel.quantity][unit]
            yield Description("units", unit, _scaled([k], factor), (channel.name,))
    if n > 2:  # of two it cannot be told which one is inverted
        yield from (_reversed(channels, i) for i in range(n) if i not in gyros)
    for i, point in enumerate(points):
        other = point.translate(str.maketrans("AB", "BA"))
        if len(point) == 2 and other in points:
            where = "on the axle" if point[0] == "B" else "on the body"
            places = _moved((i,), (points.index(other),))
            yield Description("misplaced", where, places, (channels[i].name,))
    for i, j in combinations(range(n), 2):
        if "body" not in (points[i], points[j]) and quantities[i] == quantities[j]:
            names = (channels[i].name, channels[j].name)
            yield Description("swapped", "", _moved((i, j), (j, i)), names)


def _reversed(channels: Sequence[Channel], i: int) -> Description:
    how = "is upside down" if channels[i].is_acceleration else f"counts {REVERSED}"
    return Description("polarity", how, _inverted([i]), (channels[i].name,))


def _ratios(channels: Sequence[Channel]) -> Iterator[Description]:
    """Sensors on struts whose ratio to the wheel is wrong: those of an axle, or all of a kind."""
    for quantity in ("travel", "force"):
        of_kind = [i for i, c in enumerate(channels) if c.quantity == quantity]
        ends = [[i for i in of_kind if channels[i].corner in end] for end in ((0, 1), (2, 3))]
        for some in (of_kind, *(end for end in ends if 0 < len(end) < len(of_kind))):
            if 0 < len(some) < len(channels):
                names = tuple(channels[i].name for i in some)
                for factor in RATIOS:
                    yield Description("ratio", f"{factor:.2g}", _scaled(some, factor), names)


def all_matches(drives: Sequence[Drive], descriptions: Sequence[Description]) -> list[list[Match]]:
    """Every run (inner list) under every description (outer list)."""
    found: dict[int, list[Match]] = {i: [] for i in range(len(descriptions))}
    timing = [(d.speed, d.rate) for d in descriptions]
    for speed, rate in dict.fromkeys(timing):
        of_it = [i for i, each in enumerate(timing) if each == (speed, rate)]
        places = [descriptions[i].places for i in of_it]
        for drive in drives:
            matched = drive.match(speeds_about(speed * drive.run.speed_m_s), places, rate)
            for i, match in zip(of_it, matched, strict=True):
                found[i].append(match)
    return [found[i] for i in range(len(descriptions))]


def log_likelihood(found: Sequence[Match]) -> float:
    """Of all runs, their gains alike within `UNLIKE`."""
    gains = np.array([np.log(m.gain) for m in found if m.has_gain])
    spread = (
        float(np.sum(np.minimum((gains - np.median(gains)) ** 2, 25.0 * UNLIKE**2)))
        if len(gains)
        else 0.0
    )
    return sum(m.log_likelihood for m in found) - spread / (2 * UNLIKE**2)


def drivable(campaign: Campaign) -> bool:
    """Whether any run says something of speed and places."""
    return any(run.speed_m_s > 0 for run in campaign.runs)


def _moved(columns: Sequence[int], order: Sequence[int], late_s: float = 0.0) -> Places:
    m = len(columns)
    return Places(tuple(columns), tuple(order), (1.0,) * m, (late_s,) * m)


def _inverted(which: Sequence[int]) -> Places:
    return _scaled(which, -1.0)


def _scaled(which: Sequence[int], factor: float) -> Places:
    m = len(which)
    return Places(tuple(which), tuple(which), (factor,) * m, (0.0,) * m)


def _renamed(channels: Sequence[Channel], renamed: dict[str, str]) -> Places | None:
    """The places if every named point sat at the one whose name it becomes; None if one is
    missing, or none changes."""
    sources: dict[int, int] = {}
    places = [(c.quantity, c.point) for c in channels]
    for i, (quantity, point) in enumerate(places):
        if channels[i].corner is not None:
            other = quantity, "".join(renamed.get(letter, letter) for letter in point)
            if other not in places:
                return None
            if places.index(other) != i:
                sources[i] = places.index(other)
    return _moved(tuple(sources), tuple(sources.values())) if sources else None
