"""A sensor along x beside a speed: reversed, in g, or right."""

from dataclasses import replace

import numpy as np
import pytest

from tests.simulate.setup import campaign_of
from tests.simulate.test_recorder import RUN
from wheelhop.campaign import Channel
from wheelhop.gate.driving import driving_findings

KNOWN = (
    Channel("gps", "", quantity="speed", unit="m/s"),
    Channel("ax", "body", axis="x"),
)
TIME = np.arange(1000) / 100.0


def campaign(gain=1.0, own=0.1, seed=3, hills=0.0, gps=0.05):
    """A driver who works the pedals, a GPS of some noise, m/s, and a sensor that shakes with the
    body, and feels hills, m/s²."""
    rng, like = np.random.default_rng(seed), campaign_of(RUN)
    pedals = 2.0 * np.sin(2 * np.pi * TIME / 4.0)
    speed = 6.0 - 2.0 * 4.0 / (2 * np.pi) * np.cos(2 * np.pi * TIME / 4.0)
    known = {
        "gps": speed + rng.normal(0.0, gps, len(TIME)),
        "ax": gain * pedals
        + own * rng.normal(size=len(TIME))
        + hills * np.sin(2 * np.pi * TIME / 5.0)
        + 0.3,
    }
    runs = tuple(replace(run, time_s=TIME, known=known) for run in like.runs)
    return replace(like, runs=runs, known=KNOWN)


@pytest.mark.parametrize(
    ("gain", "kinds"),
    [
        (1.0, []),
        (0.6, []),
        (1.9, []),
        (-1.0, ["polarity"]),
        (1 / 9.81, ["units"]),
        (-1 / 9.81, ["polarity", "units"]),
    ],
)
def test_sign_and_unit_are_told_by_the_speed(gain, kinds):
    found = list(driving_findings(campaign(gain, own=0.1 * abs(gain))))
    assert [each.kind for each in found] == kinds
    assert all("ax" in each.about and "gps" in each.text for each in found)


def test_a_noisy_speed_is_enough():
    """Differentiated, its noise would cover the pedals were it not smoothed."""
    kinds = [[f.kind for f in driving_findings(campaign(-1.0, seed=i, gps=1.2))] for i in range(5)]
    assert kinds == [["polarity"]] * 5


def test_nothing_is_said_of_a_channel_that_shows_something_else():
    assert not list(driving_findings(campaign(-0.1, own=30.0)))
    assert not list(driving_findings(campaign(-1.0, hills=3.5)))
    gps = campaign(-1.0)
    assert not list(driving_findings(replace(gps, known=KNOWN[:1])))
    assert not list(driving_findings(replace(gps, known=KNOWN[1:])))
