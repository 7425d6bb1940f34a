"""Mistakes that all runs share: speeds in another unit, channels exchanged, the sample rate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import log

from wheelhop.campaign import Campaign
from wheelhop.gate.by_travel import ByTravel
from wheelhop.gate.descriptions import (
    REVERSED,
    Description,
    all_matches,
    log_likelihood,
    other_descriptions,
    stated,
)
from wheelhop.gate.drive import REACH, Drive
from wheelhop.gate.finding import Finding, needed
from wheelhop.gate.fixes import of_description
from wheelhop.gate.runs import Runs

SPEEDS = {"metres per second": 3.6, "miles per hour": 1.609344, "knots": 1.852}
"""What a number under speed_kmph may have been in, and its km/h."""


def likeliest(campaign: Campaign, drives: Sequence[Drive]) -> tuple[Runs, Finding | None]:
    """The description that explains the runs best: the campaign's own, unless a mistake that all
    runs share would explain them better by far."""
    descriptions = [stated(campaign.channels), *other_descriptions(campaign.channels)]
    found = all_matches(drives, descriptions)
    likely = [log_likelihood(each) for each in found]
    best = max(range(len(likely)), key=lambda i: likely[i])
    tried = len(descriptions)
    if descriptions[best].kind == "ratio" and all(isinstance(d, ByTravel) for d in drives):
        # It is held against all that is believed of springs and dampers, and against its like.
        tried = sum(d.kind == "ratio" for d in descriptions)
    if likely[best] - likely[0] <= needed(tried):
        return Runs(drives, descriptions[0], found[0]), None
    near = [
        i for i, d in enumerate(descriptions) if d.kind and likely[i] > likely[best] - needed(1)
    ]
    rivals = [descriptions[i] for i in near]
    # Of kinds that explain the runs alike, the commoner comes first.
    best = max((i for i in near if descriptions[i].kind == rivals[0].kind), key=likely.__getitem__)
    finding = _finding(descriptions[best], rivals, likely[best] - likely[0], len(drives))
    times = SPEEDS.get(_unit_of(descriptions[best].speed), descriptions[best].speed)
    fixes = of_description(descriptions[best], times, campaign)
    finding = replace(finding, fixes=fixes)
    return Runs(drives, descriptions[best], found[best]), finding


def _finding(best: Description, rivals: Sequence[Description], rise: float, runs: int) -> Finding:
    evidence = f"{runs} runs together are explained 10^{rise / log(10):.0f} times better that way"
    about, text, remedy = _said(best)
    unlike = [d for d in rivals if (d.kind, d.channels) != (best.kind, best.channels)]
    also = f" (or {' or '.join(_said(d)[1] for d in unlike[:2])})" if unlike else ""
    return Finding(
        "before",
        best.kind,
        about,
        f"{text[0].upper()}{text[1:]}{also}: {evidence}.",
        remedy,
        "likely" if unlike else "certain",
    )


def _said(description: Description) -> tuple[str, str, str]:
    """What it is about, in words, and what to do."""
    names = " and ".join(description.channels) or "the channels"
    seem = "alone seems" if len(description.channels) == 1 else "seem"
    if description.kind == "speed":
        unit = _unit_of(description.speed)
        what = (
            f"the speeds seem to be in {unit}"
            if unit
            else f"the vehicle went about {description.speed:.2g} times as fast as stated"
        )
        return (
            "speed_kmph of all runs",
            what,
            "Give speeds in km/h; look at track.pitch_mm and sample_rate_hz, too.",
        )
    if description.kind == "sample-rate":
        return (
            "sample_rate_hz",
            f"the true sample rate seems to be {description.rate:g} times the stated one",
            "Look at sample_rate_hz and the recordings' time_s.",
        )
    if description.kind == "out-of-step":
        return (
            f"channels {names}",
            f"{description.words} for the others",
            "Bring the loggers into step (wheelhop sync-check), or cut the recordings anew.",
        )
    if description.kind == "units":
        return (
            f"units of {names}",
            f"{names} {seem} to be in {description.words}",
            f"Look at the unit and the gain of {names}.",
        )
    if description.kind == "ratio":
        return (
            f"per_wheel of {names}",
            f"{names} {seem} to show about {description.words} times what per_wheel says",
            "Look at per_wheel: what the sensor shows per what happens at the wheel.",
        )
    if description.kind == "misplaced":
        return (
            f"channels {names}",
            f"{names} seems to sit {description.words}",
            f"Look where the sensor of {names} is screwed to, and which wire is whose.",
        )
    if description.kind == "exchanged":
        return ("channels", f"{description.words} exchanged", "Exchange the columns' names.")
    if description.kind == "swapped":
        return (
            f"channels {names}",
            f"{names} seem to be exchanged",
            f"Exchange the names of {names}; push one of the sensors and watch which moves.",
        )
    remedy = "Turn the sensor over, or change the sign of its gain."
    if description.words.endswith(REVERSED):
        remedy = "Turn the sensor round, or change the sign of its column, or of per_wheel."
    return f"channels {names}", f"{names} {description.words}", remedy


def _unit_of(factor: float) -> str:
    """The unit whose km/h the factor is, as near as speeds are known."""
    near = {name: abs(log(factor / value)) for name, value in SPEEDS.items()}
    name = min(near, key=lambda unit: near[unit])
    return name if near[name] < log(1 + REACH) else ""
