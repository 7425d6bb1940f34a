"""Measured motion as it was before it was averaged, and sensors that are not what they are believed
to be."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.simulate.setup import CHANNELS
from wheelhop.campaign import Averaging
from wheelhop.simulate.prescribed import unaveraged
from wheelhop.simulate.sensors import miscalibrated, recalibrated

RATE_HZ = 100.0
TIME = np.arange(400) / RATE_HZ
INSIDE = slice(40, -40)
CALIBRATED = tuple(replace(c, corner_hz=50.0, corner_uncertainty=0.1) for c in CHANNELS)


@pytest.mark.parametrize(
    "averaging",
    [Averaging(0.0), Averaging(0.005), Averaging(0.01), Averaging(0.004, 3, 0.003)],
)
@pytest.mark.parametrize("frequency_hz", [1.0, 8.0, 20.0])
def test_averaging_is_undone(averaging, frequency_hz):
    """A mean over T of a sine is sin(πfT)/πfT of it: 6 % are missing at 20 Hz and 10 ms."""
    phase = 2 * np.pi * frequency_hz * TIME
    averaged = averaging.kept(np.array([frequency_hz])) * np.sin(phase)
    found = unaveraged(TIME, averaged[:, None], averaging, 2)
    between = TIME + 0.3 / RATE_HZ
    true = np.sin(2 * np.pi * frequency_hz * between)
    # Between its knots a cubic spline misses (ωh)⁴/384 of a long wave.
    missed = (2 * np.pi * frequency_hz / RATE_HZ) ** 4 / 384
    assert np.abs(found(between)[INSIDE, 0] - true[INSIDE]).max() < 3e-4 + 1.5 * missed


@pytest.mark.parametrize("averaging", [Averaging(0.01), Averaging(0.004, 3, 0.003)])
def test_its_means_are_the_record(averaging):
    """Whatever the record holds, up to half its rate, and at its ends."""
    record = np.random.default_rng(1).standard_normal((len(TIME), 2))
    way = unaveraged(TIME, record, averaging, 3).antiderivative()
    half = averaging.window_s / 2
    centres = TIME[:, None] + averaging.centres_s
    means = (way(centres + half) - way(centres - half)).mean(axis=1) / averaging.window_s
    np.testing.assert_allclose(means, record, atol=1e-8)


def test_beyond_its_ends_the_motion_goes_on_as_it_ended():
    found = unaveraged(TIME, np.full((400, 2), 3.0), Averaging(0.01), 3)
    np.testing.assert_allclose(found([TIME[0] - 0.02, TIME[-1] + 0.02]), 3.0, rtol=1e-9)


def test_a_corner_that_was_undone_wrongly():
    """A sensor of 46 Hz, undone as one of 50 Hz: the ratio of the two responses is left."""
    frequency, true, stated = 12.0, 46.0, 50.0
    phase = 2 * np.pi * frequency * TIME
    acceleration = np.tile(np.sin(phase)[:, None], len(CHANNELS))
    left = (1 + 1j * frequency / stated) / (1 + 1j * frequency / true)
    values = {"channel.A1.gain": 0.02, "channel.A1.corner": true / stated - 1.0}
    found = miscalibrated(acceleration, RATE_HZ, CALIBRATED, values)
    column = [c.name for c in CALIBRATED].index("A1")
    expected = 1.02 * np.abs(left) * np.sin(phase + np.angle(left))
    np.testing.assert_allclose(found[INSIDE, column], expected[INSIDE], atol=2e-4)
    others = [i for i in range(len(CALIBRATED)) if i != column]
    np.testing.assert_allclose(found[:, others], acceleration[:, others], atol=1e-12)


@given(gain=st.floats(-0.2, 0.2), corner=st.floats(-0.3, 0.3), seed=st.integers(0, 99))
def test_setting_right_is_the_opposite(gain, corner, seed):
    record = np.random.default_rng(seed).normal(size=(127, len(CALIBRATED)))
    values = {"channel.B2.gain": gain, "channel.B2.corner": corner}
    there = miscalibrated(record, RATE_HZ, CALIBRATED, values)
    np.testing.assert_allclose(recalibrated(there, RATE_HZ, CALIBRATED, values), record, atol=1e-9)
