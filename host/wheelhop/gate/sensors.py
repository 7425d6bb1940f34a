"""The sensors' own examination (`wheelhop health`), and a campaign without what gives no signal."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain

import numpy as np

from wheelhop.calibration.health.examine import examine, examine_relations
from wheelhop.calibration.health.finding import Finding as Symptom
from wheelhop.campaign import Campaign, Run
from wheelhop.campaign.change import Proposal
from wheelhop.gate.finding import Finding
from wheelhop.gate.fixes import moved, turned
from wheelhop.logger.recording import Channel, Recording

NO_SIGNAL = ("stuck", "dead")
OF_THE_VEHICLE = ("mount", "hum", "drift")
"""What a vehicle or a track may do as well: `wheelhop health` and `check` say it, the gate not."""


Seen = tuple[Run | None, Symptom]
"""What is wrong with sensors in a run, or in all runs together (None)."""


def examined(campaign: Campaign) -> Iterator[Seen]:
    """What the sensors' own examination finds wrong."""
    recordings = [_recording(campaign, run) for run in campaign.runs]
    found = [examine(recording, relations=False).findings for recording in recordings]
    for symptom in examine_relations(recordings, chain.from_iterable(found))[0]:
        yield None, symptom
    for run, symptoms in zip(campaign.runs, found, strict=True):
        for symptom in symptoms:
            yield run, symptom


def sensor_findings(campaign: Campaign, symptoms: Iterable[Seen]) -> tuple[list[Finding], Campaign]:
    """What is wrong with the sensors, from what their examination found, and the campaign without
    what gives no signal."""
    told: dict[tuple[str, tuple[str, ...]], list[Seen]] = defaultdict(list)
    for run, symptom in symptoms:
        if symptom.kind not in OF_THE_VEHICLE:
            told[symptom.kind, symptom.channels].append((run, symptom))
    for key in [k for k in told if k[0] == "dead"]:
        # Where the track moves one side alone, or hardly anything, noise is all there should be.
        if 2 * len(told[key]) < len(campaign.runs):
            del told[key]
    silent: dict[str, set[str]] = defaultdict(set)
    for (kind, channels), found in told.items():
        if kind in NO_SIGNAL:
            for name in channels:
                silent[name] |= {run.id for run, _ in found if run is not None}
    sound, left_out = without_silent(campaign, silent)
    findings = []
    for (kind, channels), found in told.items():
        run, symptom = max(found, key=lambda item: item[1].strength)
        names = ", ".join(channels) or "all channels"
        where = f" in {len(found)} of {len(campaign.runs)} runs" if run is not None else ""
        said = ""
        if kind in NO_SIGNAL:
            said = f"; left out: {', '.join(left_out[name] for name in channels)}"
        findings.append(
            Finding(
                "before",
                kind,
                f"channel {names}",
                f"{symptom.what if run is None else f'{names}{where}: {symptom.what}'}{said}.",
                f"{symptom.remedy[0].upper()}{symptom.remedy[1:]}.",
                symptom.sure,  # type: ignore[arg-type]
                _fixes(campaign, kind, channels),
            )
        )
    return findings, sound


def _fixes(campaign: Campaign, kind: str, names: tuple[str, ...]) -> tuple[Proposal, ...]:
    """The sign of a sensor that was upside down, the places of two that were exchanged."""
    of = {c.name: c for c in campaign.channels}
    if kind == "polarity":
        return (turned(campaign, names),)
    if kind == "swapped" and len(names) == 2 and all(name in of for name in names):
        return (moved(campaign, {names[0]: of[names[1]], names[1]: of[names[0]]}),)
    return ()


def without_silent(
    campaign: Campaign, silent: dict[str, set[str]]
) -> tuple[Campaign, dict[str, str]]:
    """The campaign without channels, or without runs, that give no signal (channel: ids of runs);
    whichever loses less. Nothing is left out where no run to fit, or no channel, would be left."""
    left_out = {}
    channels, runs = set[str](), set[str]()
    for name, ids in silent.items():
        if len(ids) * len(campaign.channels) <= len(campaign.runs):
            runs |= ids
            left_out[name] = f"the runs {', '.join(sorted(ids))}"
        else:
            channels.add(name)
            left_out[name] = f"the channel {name}"
    kept = tuple(run for run in campaign.runs if run.id not in runs)
    columns = [i for i, c in enumerate(campaign.channels) if c.name not in channels]
    if not columns or not any(run.role == "fit" for run in kept):
        return campaign, dict.fromkeys(silent, "nothing, for too little would be left")
    if len(columns) == len(campaign.channels) and len(kept) == len(campaign.runs):
        return campaign, left_out
    if len(columns) == len(campaign.channels):
        return replace(campaign, runs=kept), left_out
    cut = tuple(replace(run, record=_frozen(run.record[:, columns])) for run in kept)
    names = tuple(campaign.channels[i] for i in columns)
    return replace(campaign, channels=names, runs=cut), left_out


def _frozen(values: np.ndarray) -> np.ndarray:
    values = np.ascontiguousarray(values)
    values.flags.writeable = False
    return values


def _recording(campaign: Campaign, run: Run) -> Recording:
    channels = tuple(Channel(item.name, item.unit, item.point) for item in campaign.channels)
    return Recording(run.record, campaign.sample_rate_hz, channels, float(run.time_s[0]))
