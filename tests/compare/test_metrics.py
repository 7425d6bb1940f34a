"""The field's figures on signals whose figures are known."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.compare import compare, in_band
from wheelhop.compare.metrics import spectral_peak
from wheelhop.compare.thirds import third_octave_of, third_octaves

RATE, N = 100.0, 1024
TIME = np.arange(N) / RATE


@given(st.floats(1.0, 29.0), st.floats(0.1, 50.0), st.floats(0.0, 6.28))
def test_the_peak_of_a_sine_is_its_frequency_and_amplitude_also_between_bins(f, a, phase):
    peak = spectral_peak(a * np.sin(2 * np.pi * f * TIME + phase), RATE)
    assert peak.frequency_hz == pytest.approx(f, abs=0.02 * RATE / N)
    assert peak.height == pytest.approx(a, rel=0.01)
    # The Hann window's own half-power width (Harris 1978, table 1: 1.44 bins).
    assert peak.width_hz == pytest.approx(1.44 * RATE / N, rel=0.03)


def test_the_width_of_a_damped_burst_is_that_of_its_lorentzian():
    f, zeta = 5.0, 0.08
    decay = np.exp(-2 * np.pi * zeta * f * np.abs(TIME - 5.12)) * np.cos(
        2 * np.pi * f * (TIME - 5.12)
    )
    # exp(-a|t|): the amplitude spectrum is a Lorentzian of half-width a, which falls to 1/√2
    # of its height at a (√2 - 1)^½.
    expected = 2 * zeta * f * np.sqrt(np.sqrt(2.0) - 1.0)
    assert spectral_peak(decay, RATE).width_hz == pytest.approx(expected, rel=0.1)


def test_third_octaves_are_those_of_iec_61260():
    bands = third_octaves((0.5, 30.0))
    names = [band.name for band in bands]
    assert names[:4] == ["0.5", "0.63", "0.8", "1"]
    assert names[-5:] == ["12.5", "16", "20", "25", "31.5"]
    eight = bands[names.index("8")]
    # IEC 61260-1:2014, table E.1: exact centre 7.9433 Hz; edges a tenth of a decade apart.
    assert np.sqrt(np.prod(eight.edges_hz)) == pytest.approx(7.9433, abs=1e-4)
    assert eight.edges_hz == pytest.approx((7.0795, 8.9125), abs=1e-4)
    for below, above in pairwise(bands):
        assert below.edges_hz[1] == above.edges_hz[0]


@given(st.floats(0.01, 1000.0))
def test_every_frequency_lies_inside_its_band(f):
    x = int(third_octave_of(np.array([f]))[0])
    low, high = next(b for b in third_octaves((f, f)) if b.x == x).edges_hz
    assert low * (1 - 1e-12) <= f <= high * (1 + 1e-12)


def test_a_gain_error_shows_as_its_square_in_the_psd_ratio_and_not_in_coherence(bench):
    campaign, responses = bench.campaign([2.0], lambda t, v: 0.25 * bench.motion(t, v))
    for figures in compare(campaign, responses).figures:
        assert figures.error == pytest.approx(0.25 / 1.25)
        assert figures.coherence == pytest.approx(1.0, abs=1e-6)
        assert figures.psd_ratio["4"] == pytest.approx(0.64)
        assert figures.model_peak.height / figures.measured_peak.height == pytest.approx(0.8)
        assert figures.model_peak.frequency_hz == pytest.approx(4.0, abs=1e-3)


def test_nrmse_is_over_the_range_and_a_sine_is_two_amplitudes_wide(bench):
    def sine(time, speed):
        return np.outer(np.sin(2 * np.pi * 100 * RATE / N * time), np.ones(8))

    campaign, responses = bench.campaign([2.0], lambda t, v: 0.1 * sine(t, v), motion=sine)
    figures = compare(campaign, responses).figures[0]
    assert figures.nrmse == pytest.approx(0.1 / np.sqrt(2.0) / 2.2, rel=1e-3)


def test_coherence_is_the_share_of_power_that_is_linear_in_the_model(bench):
    # White noise added to a white model of equal power: γ² = 1/2, up to Welch's bias of
    # (1 - γ²)² over some five independent segments.
    white = bench.noise(1.0)
    campaign, responses = bench.campaign(
        [2.0], lambda t, v: bench.noise(1.0), motion=lambda t, v: white
    )
    coherence = np.mean([f.coherence for f in compare(campaign, responses).figures])
    assert coherence == pytest.approx(0.55, abs=0.05)


def test_records_hold_measured_minus_model(bench):
    campaign, responses = bench.campaign([2.0], lambda t, v: 0.25 * bench.motion(t, v))
    (record,) = in_band(campaign, responses)
    np.testing.assert_allclose(record.model, 4 * record.residual, atol=1e-9)
