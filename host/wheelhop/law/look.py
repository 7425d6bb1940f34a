"""How a law that was found looks, in words; the name that comes nearest; what to record next."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.words import percent
from wheelhop.law.along import along
from wheelhop.law.moved import Moved
from wheelhop.law.search import Found
from wheelhop.law.shape import forces
from wheelhop.law.terms import candidates
from wheelhop.vehicle import is_component

Array = NDArray[np.float64]

FOLLOWS = 0.75
"""A law of which extension or rate alone tells this share is one of a spring, or of a damper."""

UNEVEN = 0.3
"""A share of the power from which on a law is said not to be alike both ways."""

BINS = 24

NEXT = {
    ("spring", True): "slow strokes to both ends of the travel",
    ("damper", True): "sines of one amplitude at rising frequency, up to the largest speed",
    ("both", True): "sines of two amplitudes at two frequencies: the same speed at other places",
    ("memory", True): "slow sines of two amplitudes: friction and play show where damping does not",
    ("spring", False): "single bumps, slowly, high enough to use up the travel",
    ("damper", False): "the same track faster",
    ("both", False): "the same track at two speeds, with another load",
    ("memory", False): "long waves, slowly: friction shows where damping does not",
}
"""What tells most of a law, by what it follows, on a rig and on a vehicle."""


def look(found: Found) -> list[str]:
    """Sentences for a person; none where nothing was found, or nothing tells how it moved."""
    free, moved = found.free, found.moved
    if free is None or moved is None:
        return []
    x, v = moved.extension, moved.rate
    beyond = _without_line(forces(found, free), x, v)
    follows, told = kind_of(beyond, x, v)
    on_rig = is_component(found.base.model.values)
    words = {
        "spring": f"It follows the extension, as a spring does: {percent(told, 2)} of it.",
        "damper": f"It follows the rate, as a damper does: {percent(told, 2)} of it.",
        "both": f"It follows extension and rate together: {percent(told, 2)} of it.",
        "memory": f"Extension and rate of a moment tell no more than {percent(told, 2)} of it: the"
        " rest is history.",
    }
    lines = [words[follows], _nearest_term(beyond, found, moved)]
    if follows in ("spring", "damper"):
        lines.append(shape_of(beyond, x if follows == "spring" else v, follows))
    if found.named:
        name, base = found.named[0], found.base.error_judging
        laws = [free] if found.formula is None else [free, found.formula]
        least = min(law.rung.error_judging for law in laws)  # what a spline foresees may run away
        share = (base**2 - name.rung.error_judging**2) / max(base**2 - least**2, 1e-12)
        lines.append(
            f"The nearest name is {name.name}: it explains"
            f" {percent(min(max(share, 0.0), 1.0), 2)} of what the best of these laws does."
        )
    lines.append(f"To know it better record {NEXT[follows, on_rig]}.")
    return lines


def _nearest_term(beyond: Array, found: Found, moved: Moved) -> str:
    """The one term that comes nearest to the force, beside spring and damper."""
    x, v, dt = moved.extension, moved.rate, 1.0 / found.workshop.campaign.sample_rate_hz
    least, words = float(beyond @ beyond), "none"
    for term in candidates(x, v, moved.inputs):
        own = along(term.kernel, (1.0, *term.shape), moved, dt, term.by)
        own = _without_line(own, x, v)
        power = float(own @ own) or 1.0
        left = float(beyond @ beyond) - float(own @ beyond) ** 2 / power
        if left < least:
            least, words = left, term.words
    told = percent(1.0 - least / float(beyond @ beyond), 2)
    return f"Of single terms one comes nearest, {words}: {told} of it."


def kind_of(force: Array, x: Array, v: Array) -> tuple[str, float]:
    """What a force (T,) follows, "spring", "damper", "both" or "memory", and the share of its
    power that extension, rate, or both of a moment tell."""
    by_x, by_v = _bins(x), _bins(v)
    alone = {"spring": _told(force, by_x), "damper": _told(force, by_v)}
    best = max(alone, key=lambda name: alone[name])
    if alone[best] >= FOLLOWS:
        return best, alone[best]
    both = _told(force, by_x * BINS + by_v)
    return ("both" if both >= FOLLOWS else "memory"), both


def shape_of(force: Array, along: Array, follows: str) -> str:
    """Whether it grows or falls towards the ends of the motion, and whether it does so evenly."""
    reach = min(np.quantile(along, 0.995), -np.quantile(along, 0.005))
    at = np.linspace(-reach, reach, 2 * BINS + 1)
    which = np.digitize(along, 0.5 * (at[1:] + at[:-1]))
    known = np.unique(which)
    mean = np.array([force[which == i].mean() for i in known])
    curve = np.interp(np.arange(len(at)), known, mean)
    even, odd = 0.5 * (curve + curve[::-1]), 0.5 * (curve - curve[::-1])
    even -= even.mean()
    uneven = float(even @ even / (even @ even + odd @ odd))
    grows = odd[-1] > 0.0
    ways = {
        "spring": ("It stiffens towards the ends of the travel", "It softens with the travel"),
        "damper": ("It grows faster than the speed", "It grows slower than the speed"),
    }[follows]
    text = ways[0] if grows else ways[1]
    if uneven < UNEVEN:
        return f"{text}, alike in rebound and compression."
    more = "rebound" if abs(curve[-1]) > abs(curve[0]) else "compression"
    return f"{text}, most of it in {more}." if uneven < 1.0 - UNEVEN else f"It is one of {more}."


def _without_line(force: Array, x: Array, v: Array) -> Array:
    """What of a force no spring and no damper is."""
    basis = np.stack([np.ones_like(x), x, v], axis=1)
    return np.asarray(force - basis @ np.linalg.lstsq(basis, force, rcond=None)[0])


def _bins(values: Array) -> NDArray[np.int64]:
    """Bins between even spacing and quantiles: the ends of a motion are rare, and hold most."""
    share = np.linspace(0.0, 1.0, BINS + 1)[1:-1]
    even = values.min() + share * np.ptp(values)
    return np.digitize(values, 0.5 * (np.quantile(values, share) + even))


def _told(force: Array, which: NDArray[np.int64]) -> float:
    """Share of a force's power that its mean in every bin holds, more than chance gives it."""
    count = np.bincount(which)
    mean = np.bincount(which, force) / np.maximum(count, 1)
    left = float(np.sum((force - mean[which]) ** 2)) / max(len(force) - int(np.sum(count > 0)), 1)
    return max(1.0 - left / float(np.var(force)), 0.0)
