"""Sine fits: exact on sines, as good as the bound on noise, blind to gaps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wheelhop.calibration.shaker.quantisation import rounding_errors
from wheelhop.calibration.shaker.response import averaging, conversion_instants_s
from wheelhop.calibration.shaker.sine import Sine, fit_known, fit_unknown, strongest_frequency_hz
from wheelhop.logger.recording import Channel, Recording

RATE = 100.0
TIME = 3.0 + np.arange(600) / RATE


def wave(frequency, amplitude=2.0, phase=0.4, offset=1.0):
    angle = 2 * np.pi * frequency * TIME + phase
    return offset + amplitude * np.cos(angle) + 0.1 * np.cos(2 * angle + 1)


@given(st.floats(0.7, 20), st.floats(0.01, 1e3), st.floats(-3, 3), st.floats(-1e3, 1e3))
@settings(max_examples=50)
def test_a_sine_with_a_harmonic_is_found_exactly(frequency, amplitude, phase, offset):
    angle = 2 * np.pi * frequency * TIME + phase
    values = offset + amplitude * (np.cos(angle) + 0.2 * np.cos(2 * angle + 1))
    start = strongest_frequency_hz(values, RATE)
    found = fit_unknown(TIME, values, start, harmonics=2)
    assert found.frequency_hz == pytest.approx(frequency, rel=1e-6)
    exact = amplitude * np.exp(1j * (2 * np.pi * frequency * found.middle_s + phase))
    assert abs(found.phasors[0] - exact) < 1e-5 * amplitude
    assert found.offset == pytest.approx(offset, abs=1e-5 * (amplitude + abs(offset)))
    assert found.phasor_at(0.0) == pytest.approx(amplitude * np.exp(1j * phase), rel=1e-3)


def test_missing_samples_change_nothing():
    values = wave(3.3)
    values[[5, 100, 101, 599]] = np.nan
    found = fit_known(TIME, values, 3.3, harmonics=2)
    assert found.amplitude == pytest.approx(2.0)
    assert found.count == 596


def test_noise_spreads_the_fit_as_the_bound_says():
    """Cramér-Rao: amplitude σ √(2/N), frequency √6 σ / (π A T √N)."""
    rng = np.random.default_rng(0)
    sigma, fits = 0.3, []
    for _ in range(300):
        values = wave(3.3) + sigma * rng.standard_normal(len(TIME))
        fits.append(fit_unknown(TIME, values, 3.3, harmonics=2))
    amplitude = sigma * np.sqrt(2 / len(TIME))
    frequency = np.sqrt(6 / len(TIME)) * sigma / (np.pi * 2.0 * len(TIME) / RATE)
    assert np.std([f.amplitude for f in fits]) == pytest.approx(amplitude, rel=0.15)
    assert np.std([f.frequency_hz for f in fits]) == pytest.approx(frequency, rel=0.15)
    assert np.mean([f.residual_rms for f in fits]) == pytest.approx(sigma, rel=0.02)


def log_of(number):
    words = ["-"] * 8
    words[number] = "X"
    notes = {"channels": " ".join(words), "conversions": "8", "rate_hz": "100"}
    values = np.zeros((1, 1))
    return Recording(values, RATE, (Channel("X", "code"),), averaging_s=0.01, notes=notes)


@pytest.mark.parametrize("number", [0, 3, 7])
def test_the_scan_averages_a_sine_as_its_conversions_do(number):
    frequency = np.array([1.0, 10.0, 37.0])
    instants = conversion_instants_s(number, 8)
    seen = [np.exp(2j * np.pi * f * instants).mean() for f in frequency]
    gain = averaging(log_of(number), 0, frequency)
    np.testing.assert_allclose(seen, gain, atol=1e-12)
    assert np.abs(instants).max() < 0.005 and len(instants) == 8


@pytest.mark.parametrize("amplitude", [3.0, 24.0])
def test_what_rounding_does_is_what_the_budget_says(amplitude):
    """True errors of fits to rounded sines, against the figure for the budget."""
    rng = np.random.default_rng(2)
    scans = np.arange(600) / RATE
    instants = scans[:, None] + conversion_instants_s(0, 8)
    frequency, errors = 9.7, []
    window = averaging(log_of(0), 0, np.array([frequency]))[0]
    for _ in range(150):
        angle = 2 * np.pi * frequency * instants + rng.uniform(0, 7)
        codes = np.floor(amplitude * np.cos(angle) + 500 + rng.uniform()).mean(axis=1)
        errors.append(fit_known(scans, codes, frequency).amplitude / window / amplitude - 1)
    sine = Sine(frequency, 3.0, 500.0, np.array([amplitude + 0j]), 0.1, 600)
    said = rounding_errors(log_of(0), 0, sine, step=0).real
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(np.std(said), rel=0.5)
