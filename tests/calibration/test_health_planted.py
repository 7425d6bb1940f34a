"""Driving sessions: what is planted is named, and nothing is found where nothing was planted."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.calibration.test_sync_planted import random_session, recorded
from wheelhop.calibration.health.examine import examine, examine_relations
from wheelhop.calibration.health.relations import POINTS
from wheelhop.formats import read
from wheelhop.logger.recording import ACCELERATION

EXAMPLES = Path(__file__).parents[2] / "examples"
CAMPAIGNS = ("clean", "open-driver-seat", "open-dry-friction", "open-speed-fluctuation")
KINDS = ("polarity", "swapped", "dead", "stuck")
SESSIONS = 100
RUNS = {"polarity": 18, "swapped": 18, "dead": 6, "stuck": 6}


@cache
def runs(campaign):
    return tuple(read_run(file) for file in sorted((EXAMPLES / campaign / "runs").glob("*.csv")))


def read_run(file):
    recording = read(file)
    channels = tuple(replace(channel, unit=ACCELERATION) for channel in recording.channels)
    return replace(recording, channels=channels)


def spoilt(recording, kind, i, j, draw):
    values = recording.values.copy()
    if kind == "polarity":
        values[:, i] *= -1
    elif kind == "swapped":
        values[:, [i, j]] = values[:, [j, i]]
    elif kind == "dead":
        values[:, i] = 0.1 * draw.normal(size=len(values))
    else:
        values[300:, i] = values[300, i]
    return replace(recording, values=values)


@pytest.mark.parametrize("kind", KINDS)
def test_every_planted_fault_is_named(kind):
    missed = []
    for number in range(SESSIONS // len(KINDS)):
        draw = np.random.default_rng([KINDS.index(kind), number])
        campaign = str(draw.choice(CAMPAIGNS))
        chosen = draw.choice(len(runs(campaign)), RUNS[kind], replace=False)
        i, j = (int(k) for k in draw.choice(8, 2, replace=False))
        session = [spoilt(runs(campaign)[k], kind, i, j, draw) for k in chosen]
        name, other = (session[0].channels[k].name for k in (i, j))
        if kind in ("polarity", "swapped"):
            findings, _ = examine_relations(session)
            guilty = {name, other} if kind == "swapped" else {name}
        else:
            reports = [examine(recording, relations=False) for recording in session]
            findings = [f for report in reports for f in report.findings]
            guilty = {name}
        told = {f.kind for f in findings}, {c for f in findings for c in f.channels}
        if told != ({kind}, guilty):
            missed.append((number, campaign, guilty, told))
    assert missed == []


@pytest.mark.parametrize("campaign", CAMPAIGNS)
def test_nothing_is_found_where_nothing_was_planted(campaign):
    found = [f for r in runs(campaign) for f in examine(r).findings]
    assert found == []
    assert examine_relations(runs(campaign)) == ((), ())


def test_one_run_on_an_even_track_says_what_it_cannot_tell():
    recording = read_run(EXAMPLES / "clean" / "runs" / "washboard-low-slow.csv")
    health = examine(recording)
    assert health.healthy and any("A1 with A2" in line for line in health.untold)
    together = examine(recording, runs("clean"))
    assert together.healthy and together.untold == ()


def test_a_session_on_a_beam_is_not_taken_for_a_vehicle():
    found = []
    for number in range(30):
        draw = np.random.default_rng([6, number])
        _, true = random_session(draw)
        beam = recorded(draw, true)
        channels = tuple(
            replace(channel, name=point)
            for channel, point in zip(beam.channels, POINTS, strict=False)
        )
        health = examine(replace(beam, channels=channels))
        found += health.findings
        assert "as on a beam" in health.untold[0]
    assert found == []
