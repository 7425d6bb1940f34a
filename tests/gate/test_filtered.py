"""A recorder's filter that nobody stated, told from the noise of the sensors."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from tests.simulate.setup import campaign_of
from tests.simulate.test_recorder import RUN
from wheelhop.campaign.low_pass import LowPass
from wheelhop.gate.filtered import filter_findings, seen_filter

RATE_HZ, SECONDS, FINER = 200.0, 10.0, 10


def campaign(seed, order=0, corner_hz=60.0, added=0.0, motion=20.0, white=0.1, runs=4):
    """Runs whose channels hold motion that dies above 12 Hz and white noise, through a filter of an
    order, if any, sampled, and with noise added behind it."""
    rng, n = np.random.default_rng(seed), round(RATE_HZ * SECONDS)
    like = campaign_of(RUN)
    (one,) = like.runs
    shaken = signal.butter(2, 12.0, fs=RATE_HZ * FINER, output="sos")
    made = []
    for i in range(runs):
        fine = rng.normal(size=(n * FINER, len(like.channels))) * np.sqrt(FINER)
        moved = signal.sosfilt(shaken, rng.normal(size=fine.shape), axis=0) * motion
        record = moved * np.linspace(0.0, 1.0, len(moved))[:, None] + white * fine
        if order:
            sections = signal.butter(order, corner_hz, fs=RATE_HZ * FINER, output="sos")
            record = signal.sosfilt(sections, record, axis=0)
        record = record[::FINER] + rng.normal(0.0, added, (n, fine.shape[1])) * white
        time = np.arange(n) / RATE_HZ
        made.append(replace(one, id=f"run {i}", time_s=time, record=record))
    return replace(like, sample_rate_hz=RATE_HZ, runs=tuple(made), averaging_s=0.0)


@pytest.mark.parametrize(("order", "corner_hz"), [(2, 55.0), (4, 60.0), (8, 70.0)])
def test_order_and_corner_are_told(order, corner_hz):
    found = seen_filter(campaign(order, order, corner_hz, motion=0.5))
    assert abs(found.order - order) <= 1
    assert found.corner_hz == pytest.approx(corner_hz, rel=0.05)
    (said,) = filter_findings(campaign(order, order, corner_hz, motion=0.5))
    assert (said.kind, said.severity) == ("filter", "likely")
    assert f"order = {found.order}, corner_hz = {found.corner_hz:.3g} }}" in said.remedy


@pytest.mark.parametrize(
    "recorded",
    [
        {"motion": 0.5},  # white noise to the end
        {"white": 1e-4},  # motion that dies, and nothing else
        {"order": 4, "added": 1.0, "motion": 0.5},  # the recorder's own noise covers the fall
        {"order": 4, "corner_hz": 50.0, "motion": 0.5},  # hardly a flat part above the band
        {"order": 1, "corner_hz": 60.0, "motion": 0.5},  # hardly a fall: what is beyond folds back
    ],
)
def test_nothing_is_said_of_what_does_not_show(recorded):
    assert not list(filter_findings(campaign(1, **recorded)))


def test_nothing_is_said_where_a_filter_is_stated():
    filtered = campaign(4, 4, motion=0.5)
    assert not list(filter_findings(replace(filtered, low_pass=LowPass("butterworth", 4, 60.0))))
    assert not list(filter_findings(replace(filtered, averaging_s=0.005)))
