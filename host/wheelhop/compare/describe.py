"""The breakdown in an engineer's words. Only what is significant is said."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign.channel import ABOARD
from wheelhop.compare.breakdown import Breakdown, Grid, Slice
from wheelhop.compare.locking import Line
from wheelhop.compare.thirds import third_octaves
from wheelhop.files.words import percent

Array = NDArray[np.float64]

MOST = 0.7  # of the excess: what "lies in", "comes from" and "at" mean
SIGMAS = 5.0  # by which a slice must exceed its noise, beyond the floor's own tolerance

PLACES = (  # named sets of points, small ones first
    ("the front axles", {"A1", "A2"}),
    ("the rear axles", {"A3", "A4"}),
    ("the body's front end", {"B1", "B2"}),
    ("the body's rear end", {"B3", "B4"}),
    ("the axles", {"A1", "A2", "A3", "A4"}),
    ("the body", {"B1", "B2", "B3", "B4", "body", "body-xy"}),
    ("what mounts carry", set(ABOARD)),
    ("the struts", {"S1", "S2", "S3", "S4"}),
    ("the left side", {"A1", "A3", "B1", "B3", "S1", "S3"}),
    ("the right side", {"A2", "A4", "B2", "B4", "S2", "S4"}),
    ("the front", {"A1", "A2", "B1", "B2", "S1", "S2"}),
    ("the rear", {"A3", "A4", "B3", "B4", "S3", "S4"}),
)


EXPLAINS = 0.5
"""Share of the power a model must explain before its failures are placed: of what explains less,
the residual is the record itself, and lies where the vehicle moves."""


def explains_nothing(where: Breakdown) -> bool:
    """Whether more is left than explained, so that nothing can be said of where."""
    return where.total.residual > (1.0 - EXPLAINS) * where.total.measured


def describe(where: Breakdown) -> list[str]:
    """One sentence per finding, the most telling first."""
    if not where.total.noise > 0.0:
        return ["Without a noise floor it cannot be said what part of the residual is excess."]
    ratio = f"E = {where.total.ratio:.2f} times the floor"
    if where.total.folded > 0.0:
        expected = _percent((where.total.expected(0.0) / where.total.measured) ** 0.5)
        on_axles = any(point[0] == "A" for point in where.points)
        whose = "the axles’ records" if on_axles else "the records of travel"
        ratio += f"; with what is folded into {whose} {expected} is expected"
    failing = is_excess(where, where.total)
    if failing and explains_nothing(where):
        share = _percent(where.total.residual / where.total.measured)
        return [
            f"The model leaves {share} of the power ({ratio}): it does not explain these records,"
            " and nothing can be said of where it fails. See to units, speeds, tracks, channels."
        ]
    spots = [s for s in (*where.band, *where.run) if is_excess(where, s)]
    if not failing and not spots and not where.locking.lines:
        return [
            f"In every band and run the residual is no more than expected, as well as that is known"
            f" ({ratio})."
        ]
    sentences = []
    if not failing:
        sentences.append(f"As a whole the residual is no more than expected ({ratio}), but:")
    sentences.append(_main(where))
    sentences += _lines(where) + _runs(where) + _time(where)
    return [sentence for sentence in sentences if sentence]


def is_excess(where: Breakdown, part: Slice) -> bool:
    """Whether a slice's residual is certainly more than a right model leaves."""
    freedom = where.count * part.noise / where.total.noise if where.total.noise > 0.0 else 0.0
    if not freedom > 0.0:
        return False
    by_chance = 1.0 + SIGMAS * np.sqrt(2.0 / freedom)
    return bool(part.residual > by_chance * part.expected(where.tolerance))


def _main(where: Breakdown) -> str:
    excess = _excess(where, where.bands_channels)
    if not excess.sum() > 0.0:
        return ""
    rows = _shortest_range(excess.sum(axis=1))
    place, is_channel = _place(where, excess[rows].sum(axis=0))
    words = [
        f"{_percent(excess[rows].sum() / excess.sum())} of the excess residual lies"
        f" {_frequencies(where, rows)}{place}"
    ]
    words += ["" if is_channel else _motion(where, rows), _locked(where), _growing(where)]
    return ", ".join(word for word in words if word) + "."


def _excess(where: Breakdown, grid: Grid) -> Array:
    """Residual beyond what a right model leaves where the noise is at the upper end of its
    tolerance."""
    expected = (1.0 + where.tolerance) ** 2 * grid.noise + grid.folded
    return np.maximum(grid.residual - expected, 0.0)


def _shortest_range(excess: Array) -> slice:
    """The fewest neighbouring bands that hold most of the excess."""
    total = np.concatenate([[0.0], np.cumsum(excess)])
    for length in range(1, len(excess) + 1):
        held = total[length:] - total[:-length]
        best = int(np.argmax(held))
        if held[best] >= MOST * total[-1]:
            return slice(best, best + length)
    return slice(0, len(excess))


def _frequencies(where: Breakdown, rows: slice) -> str:
    names = where.bands_channels.rows
    if rows.stop - rows.start > 0.7 * len(names):
        return "all over the band"
    lowest, highest = (float(names[k]) for k in (rows.start, rows.stop - 1))
    bands = third_octaves((lowest, highest))
    low, high = bands[0].edges_hz[0], bands[-1].edges_hz[1]
    return f"between {low:.2g} and {high:.2g} Hz"


def _place(where: Breakdown, by_channel: Array) -> tuple[str, bool]:
    """Where most of it sits, and whether that is a single channel."""
    names, total = where.bands_channels.columns, by_channel.sum()
    loudest = int(np.argmax(by_channel))
    present = set(where.points)
    if len(names) > 1 and by_channel[loudest] >= MOST * total:
        return f" in channel {names[loudest]}", True
    for name, points in PLACES:
        inside = np.array([point in points for point in where.points])
        if (
            not inside.all()
            and len(points & present) > 1
            and by_channel[inside].sum() >= MOST * total
        ):
            return f" at {name}", False
    return "", False


def _motion(where: Breakdown, rows: slice) -> str:
    grid = where.bands_motions
    by_motion = _excess(where, grid)[rows].sum(axis=0)
    # Motions are told only where they share out what the channels measured.
    if len(grid.columns) < 2 or not by_motion.sum() > 0.0:
        return ""
    order = np.argsort(by_motion)[::-1]
    for count in (1, 2):
        chosen = order[:count]
        if by_motion[chosen].sum() >= MOST * by_motion.sum():
            return "mostly " + _and(grid.columns[i] for i in chosen)
    return ""


def _locked(where: Breakdown) -> str:
    excess = where.total.excess / where.total.residual
    road = "what the rig imposes" if where.on_rig else "the road"
    for share, name in ((where.locking.road, road), (where.locking.time, "time")):
        if share >= MOST * excess:
            return f"locked to {name}"
        if share >= 0.5 * MOST * excess:
            return f"partly locked to {name}"
    # The road is where the model drives: on a wrong way it is missed. A faint line may be left.
    passed = "" if where.on_rig else ", as the model drives over it,"
    return f"mainly locked neither to {road}{passed} nor to time"


def _growing(where: Breakdown) -> str:
    if not np.isfinite(where.growth):
        return ""
    if where.growth > 1.3:
        return "growing faster than the motion itself"
    if where.growth > 0.7:
        return "growing in proportion to the motion"
    if where.growth > 0.3:
        return "growing more slowly than the motion"
    return "hardly depending on how large the motion is"


def _lines(where: Breakdown) -> list[str]:
    return [
        f"A line {_at(line)} not move with speed holds"
        f" {percent(line.share, 2)} of the residual and stands out in {len(line.runs)} of"
        f" {len(where.run)} runs."
        for line in where.locking.lines
    ]


def _at(line: Line) -> str:
    if line.wanders:
        return f"that wanders from {line.lowest_hz:.2f} to {line.highest_hz:.2f} Hz but does"
    return f"at {line.frequency_hz:.2f} Hz that does"


def _runs(where: Breakdown) -> list[str]:
    """The few runs most of the excess comes from, where it is few."""
    excess = _excess(where, where.runs_channels).sum(axis=1)
    order = np.argsort(excess)[::-1]
    needed = int(np.searchsorted(np.cumsum(excess[order]), MOST * excess.sum())) + 1
    if not excess.sum() > 0.0 or needed > max(1, len(excess) // 3) or len(excess) < 3:
        return []
    chosen = order[:needed]
    return [
        f"{_percent(excess[chosen].sum() / excess.sum())} of it comes from {needed} of"
        f" {len(excess)} runs: {_and(where.runs_channels.rows[i] for i in chosen)}."
    ]


def _time(where: Breakdown) -> list[str]:
    """Whether the excess gathers in a part of the runs."""
    excess = np.array([part.excess for part in where.time])
    if not is_excess(where, where.total) or not excess.sum() > 0.0:
        return []
    rows = _shortest_range(excess)
    if rows.stop - rows.start > 4:
        return []
    begin, end = 10 * rows.start, 10 * rows.stop
    share = _percent(excess[rows].sum() / excess.sum())
    return [f"{share} of it falls between {begin} % and {end} % of the runs' time."]


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _and(names: Iterable[str]) -> str:
    *most, last = names
    return f"{', '.join(most)} and {last}" if most else last
