"""Lines that do not move with speed: an engine's are found, a track's harmonics are none."""

import numpy as np
import pytest

from tests.compare.conftest import PITCH
from wheelhop.compare import compare, describe

FACTORS = np.random.default_rng(1).uniform(0.6, 6.0, 6)
CAMPAIGNS = {
    # Speeds of one ratio or another bring harmonics of several runs together.
    "in quarters": [5.0, 3.5, 2.25, 1.0, 2.75, 2.75, 0.75, 0.75],
    "few": [3.25, 3.75, 0.75],
    "alike": [2.5, 2.5, 2.5, 6.0, 4.0, 4.25],
    "any": FACTORS.round(3).tolist(),
}


def harmonics(bench, wander):
    """What a model gets wrong of every harmonic, at a speed that wanders by this share."""

    def left(time, speed):
        way = speed * (time + wander * 6.0 / (2 * np.pi) * np.sin(2 * np.pi * time / 6.0 + speed))
        order = np.arange(1, int(29.0 * PITCH / speed) + 1)
        phase = bench.rng.uniform(0.0, 2 * np.pi, (len(order), 8))
        angle = 2 * np.pi * np.multiply.outer(way, order)[:, :, None] / PITCH + phase
        return (np.sin(angle) / np.sqrt(order)[:, None]).sum(axis=1) + bench.noise(0.05)

    return left


@pytest.mark.parametrize("kind", ["unknown", "washboard"])
@pytest.mark.parametrize("wander", [0.0, 0.002, 0.01])
@pytest.mark.parametrize("speeds", CAMPAIGNS.values(), ids=CAMPAIGNS)
def test_harmonics_of_the_track_are_no_line_that_stands_still(bench, kind, wander, speeds):
    """That those of half the runs meet somewhere is a coincidence: they stand everywhere."""
    campaign, responses = bench.campaign(speeds, harmonics(bench, wander), noise=0.05, kind=kind)
    where = compare(campaign, responses).breakdown
    assert where.locking.lines == ()
    assert "does not move with speed" not in " ".join(describe(where))


def test_an_engine_shows_beside_harmonics_that_the_model_gets_wrong(bench):
    left = harmonics(bench, 0.002)
    campaign, responses = bench.campaign(
        [1.3, 2.1, 3.3, 4.7],
        lambda t, v: 0.2 * left(t, v) + np.sin(2 * np.pi * 21.3 * t + v)[:, None] * np.ones(8),
        noise=0.01,
        kind="unknown",
    )
    (line,) = compare(campaign, responses).breakdown.locking.lines
    assert line.frequency_hz == pytest.approx(21.3, abs=0.03)
    assert len(line.runs) >= 3


def test_what_the_model_itself_has_a_line_of_proves_nothing(bench):
    """The rig of all runs hums at 17 Hz, and the model makes a tenth too little of it."""

    def motion(time, speed):
        return np.sin(2 * np.pi * 17.0 * time + speed)[:, None] * np.ones(8)

    campaign, responses = bench.campaign(
        [2.0, 3.0, 4.5],
        lambda t, v: 0.1 * motion(t, v) + bench.noise(0.01),
        motion=motion,
        noise=0.01,
        kind="unknown",
    )
    assert compare(campaign, responses).breakdown.locking.lines == ()


def test_an_engine_that_wanders_is_locked_to_time_in_every_sentence(bench):
    """From run to run by some per cent and by one within a run: still its own speed."""

    def engine(time, speed):
        own = 10.3 + 0.45 * np.sin(7.0 * speed)
        phase = 2 * np.pi * (own * time + 0.1 * np.cumsum(np.sin(0.9 * time + speed)) * 0.01)
        return np.sin(phase)[:, None] * np.ones(8) + bench.noise(0.05)

    speeds = np.linspace(1.1, 5.0, 14).tolist()
    campaign, responses = bench.campaign(speeds, engine, noise=0.05)
    where = compare(campaign, responses).breakdown
    assert where.locking.time > 0.9
    (line,) = where.locking.lines
    assert line.wanders and 9.7 < line.lowest_hz < 10.1 < 10.5 < line.highest_hz < 10.9
    assert len(line.runs) >= 13
    text = " ".join(describe(where))
    assert "locked to time" in text and "neither" not in text
    assert f"wanders from {line.lowest_hz:.2f} to {line.highest_hz:.2f} Hz" in text


def test_shares_of_the_residual_add_up(bench):
    campaign, responses = bench.campaign(
        [2.0, 3.0, 4.0],
        lambda t, v: harmonics(bench, 0.0)(t, v) + np.sin(2 * np.pi * 22.5 * t)[:, None],
        noise=0.05,
    )
    locking = compare(campaign, responses).breakdown.locking
    assert locking.road + locking.time + locking.neither == pytest.approx(1.0)
    assert sum(line.share for line in locking.lines) == pytest.approx(locking.time)
    assert min(locking.road, locking.time, locking.neither) >= 0.0
