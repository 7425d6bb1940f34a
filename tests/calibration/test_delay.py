"""Moving a channel in time: sines know the answer, gaps stay, history tells."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wheelhop.calibration.error import CalibrationError
from wheelhop.calibration.sync.delay import HALF, align, delayed
from wheelhop.logger.recording import Channel, Recording

RATE = 100.0
TIME = np.arange(500) / RATE


def recording(values):
    return Recording(values, RATE, tuple(Channel(f"A{i}", "m/s²") for i in range(values.shape[1])))


@settings(max_examples=60, deadline=None)
@given(st.floats(0.0, 40.0), st.floats(-3.0, 3.0))
def test_a_sine_comes_later_by_what_was_asked(frequency_hz, samples):
    angle = 2 * np.pi * frequency_hz
    moved = delayed(np.cos(angle * TIME + 0.3), samples)
    exact = np.cos(angle * (TIME - samples / RATE) + 0.3)
    inner = slice(HALF + 4, -HALF - 4)
    assert moved[inner] == pytest.approx(exact[inner], abs=2e-3)


def test_channels_sampled_in_turn_come_into_step():
    skew = {f"A{i}": i * 156.25e-6 for i in range(8)}
    turn = np.stack([np.sin(2 * np.pi * 12 * (TIME + s)) for s in skew.values()], axis=1)
    mended = align(recording(turn), skew)
    spread = np.ptp(mended.values[HALF:-HALF], axis=1).max()
    assert spread < 1e-4 < 0.05 < np.ptp(turn, axis=1).max()
    assert "A7 by +1.0938 ms" in mended.history[-1] and "A0" not in mended.history[-1]


@given(st.lists(st.integers(0, 199), max_size=8, unique=True))
@settings(max_examples=30, deadline=None)
def test_gaps_stay_and_nothing_crosses_them(gaps):
    values = np.random.default_rng(1).normal(size=(200, 2))
    values[gaps] = np.nan
    before = recording(values)
    after = align(before, {"A1": 0.004})
    assert np.array_equal(before.missing, after.missing)
    assert np.array_equal(before.values[:, 0], after.values[:, 0], equal_nan=True)
    if gaps:  # what follows the last gap does not know what was before it
        last = max(gaps) + 1
        other = recording(np.where(np.arange(200)[:, None] < last, np.nan, values))
        assert align(other, {"A1": 0.004}).values[last:] == pytest.approx(after.values[last:])


def test_no_skew_changes_nothing():
    before = recording(np.ones((10, 1)))
    assert align(before, {"A0": 0.0}) is before


@pytest.mark.parametrize("skew", [{"B1": 1e-3}, {"A0": 1.0}, {"A0": float("nan")}])
def test_absurd_requests_are_refused_in_one_line(skew):
    with pytest.raises(CalibrationError):
        align(recording(np.ones((10, 1))), skew)
