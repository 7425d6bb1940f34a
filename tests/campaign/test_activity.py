"""Drives are found between rests, and never across a gap."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.campaign.activity import stretches
from wheelhop.logger.recording import Channel, Recording

RATE_HZ = 100.0


def recording_of(*pieces: tuple[float, float], seed: int = 0) -> Recording:
    """Noise of (seconds, rms) after one another; two channels with different offsets."""
    rng = np.random.default_rng(seed)
    rows = [rng.normal(0, rms, (round(seconds * RATE_HZ), 2)) for seconds, rms in pieces]
    channels = (Channel("A1", "m/s²"), Channel("B1", "m/s²"))
    offsets = np.array([9.8, -0.3])
    return Recording(np.concatenate(rows) + offsets, RATE_HZ, channels)


def spans(recording: Recording) -> list[tuple[float, float]]:
    return [(p.first / RATE_HZ, p.last / RATE_HZ) for p in stretches(recording)]


def test_each_drive_between_two_rests_is_found_with_its_level():
    recording = recording_of((10, 0.05), (30, 4.0), (8, 0.05), (12, 2.0), (10, 0.05))
    first, second = stretches(recording)
    assert (first.first, first.last) == pytest.approx((1000, 4000), abs=100)
    assert (second.first, second.last) == pytest.approx((4800, 6000), abs=100)
    assert (first.rms, second.rms) == pytest.approx((4.0, 2.0), rel=0.05)


def test_a_moment_of_calm_does_not_end_a_drive_but_a_missing_sample_does():
    calm = recording_of((10, 0.05), (20, 3.0), (1, 0.05), (20, 3.0), (10, 0.05))
    assert len(stretches(calm)) == 1
    calm.values[3000] = np.nan
    before, after = spans(calm)
    assert before[1] <= 30.0 <= after[0]


def test_getting_in_is_not_a_drive():
    assert len(stretches(recording_of((20, 0.05), (2, 3.0), (20, 0.05), (30, 3.0), (9, 0.05)))) == 1


def test_a_recording_without_rest_is_one_drive():
    assert spans(recording_of((60, 2.0))) == [(0.5, 59.5)]


@given(
    st.lists(st.tuples(st.integers(1, 30), st.sampled_from([0.0, 0.03, 1.0, 8.0])), max_size=6),
    st.lists(st.integers(0, 3000), max_size=4),
)
def test_stretches_are_ordered_apart_and_whole(pieces, gaps):
    recording = recording_of((1, 1.0), *pieces)
    for gap in gaps:
        recording.values[gap % len(recording.values)] = np.nan
    found = stretches(recording)
    for piece in found:
        assert 0 <= piece.first < piece.last <= len(recording.values)
        assert np.isfinite(recording.values[piece.first : piece.last]).all()
    assert all(a.last <= b.first for a, b in itertools.pairwise(found))
