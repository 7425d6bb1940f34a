"""What to change in campaign.toml so that it says what the records say: of a finding whose remedy
is a change of that file, the change itself."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from wheelhop.campaign import Campaign, Channel
from wheelhop.campaign.change import (
    CAMPAIGN,
    SESSION,
    VEHICLE,
    Change,
    Proposal,
    of_campaign,
    written,
)
from wheelhop.campaign.types import Run
from wheelhop.files.words import listed
from wheelhop.gate.descriptions import Description

Pair = tuple[tuple[str, ...], object]
HEIGHTS = {"amplitude_m": "amplitude_mm", "height_m": "height_mm"}
"""Of a track, by their keys in campaign.toml."""


def scaled(campaign: Campaign, factors: Mapping[str, float], title: str) -> Proposal:
    """Columns times these factors, on top of those they have."""
    pairs = [
        (("factors", name), campaign.factors.get(name, 1.0) * float(factor))
        for name, factor in factors.items()
    ]
    return of_campaign(title, *pairs)


def turned(campaign: Campaign, names: Sequence[str]) -> Proposal:
    """The other sign for columns."""
    return scaled(campaign, dict.fromkeys(names, -1.0), f"Change the sign of {listed(names)}")


def moved(campaign: Campaign, to: Mapping[str, Channel]) -> Proposal:
    """Channels at the places of others."""
    pairs: list[Pair] = []
    for name, other in to.items():
        own = next(c for c in campaign.channels if c.name == name)
        if own.is_acceleration:
            pairs.append((("channels", name, "position"), other.point))
        elif other.corner is not None:
            pairs.append((("channels", name, "corner"), other.corner + 1))
    return of_campaign(f"Write {listed([f'{n} at {c.point}' for n, c in to.items()])}", *pairs)


def ratio(channel: Channel, times: float) -> Proposal:
    """Another ratio of a sensor to its wheel."""
    return of_campaign(
        f"Set per_wheel of {channel.name} to {channel.per_wheel * times:.3g}",
        (("channels", channel.name, "per_wheel"), float(f"{channel.per_wheel * times:.3g}")),
    )


def heights(runs: Iterable[Run], times: float, which: str) -> Proposal:
    """Tracks so many times as high."""
    return tracks(runs, HEIGHTS, times, f"Write the heights of {which} × {times:.4g}")


def tracks(runs: Iterable[Run], keys: Mapping[str, str], times: float, title: str) -> Proposal:
    """Lengths of tracks, by their keys here and in campaign.toml, so many times as long."""
    pairs = [
        (("run", run.id, "track", key), 1e3 * float(run.track.values[si]) * times)
        for run in runs
        for si, key in keys.items()
        if si in run.track.values
    ]
    return of_campaign(title, *pairs)


def of_speed(runs: Iterable[Run], times: float, title: str) -> Proposal:
    """Speeds times a factor, but for those that a channel recorded."""
    pairs = [
        (("run", run.id, "speed_kmph"), float(f"{3.6 * run.speed_m_s * times:.4g}"))
        for run in runs
        if run.driven is None and run.course is None and run.speed_m_s > 0.0
    ]
    return of_campaign(title, *pairs)


def exchanged(a: Run, b: Run, folder: Path) -> Proposal:
    """The recordings of two runs of the campaign in `folder`, exchanged."""
    files = [os.path.relpath(run.file, folder).replace(os.sep, "/") for run in (b, a)]
    pairs = [(("run", run.id, "file"), file) for run, file in zip((a, b), files, strict=True)]
    return of_campaign(f"Exchange the files of {a.id} and {b.id}", *pairs)


def same_track(run: Run, other: Run) -> Proposal:
    """The track of another run, where both are of one kind; else nothing."""
    keys = [key for key in other.track.values if key.endswith("_m")]
    if run.track.kind != other.track.kind:
        return Proposal("", ())
    pairs = [
        (("run", run.id, "track", f"{key}m"), 1e3 * float(other.track.values[key])) for key in keys
    ]
    return of_campaign(f"Give {run.id} the track of {other.id}", *pairs)


def in_vehicle(title: str, numbers: Mapping[str, float]) -> Proposal:
    """Numbers of the vehicle by their dotted keys; of a component they stand in campaign.toml."""
    changes = tuple(
        Change(
            CAMPAIGN if name.startswith("component.") else VEHICLE,
            tuple(name.split(".")),
            written(float(f"{value:.4g}")),
        )
        for name, value in numbers.items()
    )
    return Proposal(title, changes)


def without(key: str) -> Proposal:
    """A key of campaign.toml away."""
    return Proposal(f"Take {key} out, to have it estimated", (Change(CAMPAIGN, (key,), ""),))


def leave_out(run: str) -> Proposal:
    """A run left out of what is fitted and judged; its recording and its [[run]] stay."""
    return Proposal(f"Leave {run} out", (Change(SESSION, ("without_runs",), run),))


def of_description(found: Description, times: float, campaign: Campaign) -> tuple[Proposal, ...]:
    """What makes of campaign.toml another description of all its runs; `times` is the factor of
    speeds."""
    named = [c for c in campaign.channels if c.name in found.channels]
    held = {
        campaign.channels[i].name: gain
        for i, gain in zip(found.places.columns, found.places.gain, strict=True)
    }
    match found.kind:
        case "speed":
            made = [of_speed(campaign.runs, times, f"Write all speeds × {times:.4g}")]
        case "units":
            factors = {name: 1.0 / gain for name, gain in held.items()}
            made = [scaled(campaign, factors, f"Convert {listed(list(held))} from {found.words}")]
        case "polarity":
            made = [turned(campaign, list(held))]
        case "ratio":
            made = _together(ratio(c, held[c.name]) for c in named)
        case "misplaced" | "exchanged" | "swapped":
            pairs = zip(found.places.columns, found.places.order, strict=True)
            to = {campaign.channels[i].name: campaign.channels[j] for i, j in pairs}
            made = [moved(campaign, to)]
        case _:
            made = []
    return real(made)


def _together(proposals: Iterator[Proposal]) -> list[Proposal]:
    """Several as one."""
    every = list(proposals)
    changes = tuple(change for each in every for change in each.changes)
    return [Proposal("; ".join(each.title for each in every), changes)]


def real(proposals: Iterable[Proposal]) -> tuple[Proposal, ...]:
    """Those that change something."""
    return tuple(each for each in proposals if each.changes)
