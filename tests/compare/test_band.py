"""The in-band signal is an orthogonal projection."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from wheelhop.compare import InBand

sizes = st.integers(40, 700)
seeds = st.integers(0, 2**32 - 1)


def band_of(n: int) -> InBand:
    return InBand(n, 100.0, (3.0, 30.0))


@given(sizes, seeds)
def test_parseval_sum_of_products_is_the_same_in_time_and_frequency(n, seed):
    x, y = np.random.default_rng(seed).standard_normal((2, n, 3))
    band = band_of(n)
    in_time = np.sum(band.signal(x) * band.signal(y), axis=0)
    in_frequency = np.sum(band.coefficients(x) * band.coefficients(y), axis=0)
    np.testing.assert_allclose(in_frequency, in_time, atol=1e-10 * n)


@given(sizes, seeds)
def test_projecting_twice_is_projecting_once_and_the_rest_is_orthogonal(n, seed):
    y = np.random.default_rng(seed).standard_normal(n)
    band = band_of(n)
    once = band.signal(y)
    np.testing.assert_allclose(band.signal(once), once, atol=1e-12)
    assert abs(once @ (y - once)) < 1e-10 * n


@given(sizes, seeds)
def test_coefficients_and_signal_are_one_to_one(n, seed):
    band = band_of(n)
    c = np.random.default_rng(seed).standard_normal((band.count, 2))
    np.testing.assert_allclose(band.coefficients(band.from_coefficients(c)), c, atol=1e-12)


@pytest.mark.parametrize("n", [1000, 1001])
def test_a_sine_in_band_stays_and_one_outside_goes(n):
    time = np.arange(n) / 100.0
    band = InBand(n, 100.0, (1.0, 30.0))
    step = 100.0 / n
    inside = 2.0 * np.sin(2 * np.pi * 100 * step * time + 0.4)
    np.testing.assert_allclose(band.signal(inside + 5.0), inside, atol=1e-12)
    outside = np.sin(2 * np.pi * 400 * step * time)
    np.testing.assert_allclose(band.signal(outside), 0.0, atol=1e-12)
    # Amplitude 2: the sum of squares is n · 2² / 2, all of it at one frequency.
    power = band.coefficients(inside) ** 2
    peak = np.argmax(power[: band.count // 2] + power[band.count // 2 :])
    assert band.frequency_hz[peak] == pytest.approx(100 * step)
    assert power.sum() == pytest.approx(2.0 * n)


def test_both_edges_belong_to_the_band_and_zero_and_half_the_rate_do_not():
    band = InBand(1000, 100.0, (0.5, 30.0))
    assert band.frequency_hz[[0, -1]] == pytest.approx([0.5, 30.0])
    assert band.count == 2 * 296
    whole = InBand(1000, 100.0, (0.0, 50.0))
    assert whole.frequency_hz[[0, -1]] == pytest.approx([0.1, 49.9])


def test_white_noise_stays_white():
    band = InBand(1024, 100.0, (0.5, 30.0))
    noise = np.random.default_rng(3).standard_normal((1024, 400))
    c = band.coefficients(noise)
    assert stats.kstest(c[:, :50].ravel(), "norm").pvalue > 1e-3
    correlation = c @ c.T / 400
    off = correlation[~np.eye(band.count, dtype=bool)]
    assert np.std(off) == pytest.approx(1 / np.sqrt(400), rel=0.02)


def test_trailing_axes_are_carried_along():
    band = band_of(128)
    y = np.random.default_rng(0).standard_normal((128, 2, 3))
    c = band.coefficients(y)
    assert c.shape == (band.count, 2, 3)
    np.testing.assert_array_equal(c[:, 1, 2], band.coefficients(y[:, 1, 2]))


def test_a_record_too_short_for_the_band_and_a_wrong_length_are_refused():
    with pytest.raises(ValueError, match="resolves nothing"):
        InBand(10, 100.0, (0.5, 2.0))
    with pytest.raises(ValueError, match="128 samples"):
        band_of(128).coefficients(np.zeros((64, 3)))


def test_a_sine_integrated_twice_is_the_motion_it_accelerates():
    n, rate_hz, frequency_hz, height_m = 1000, 100.0, 4.0, 0.012
    phase = 2 * np.pi * frequency_hz * np.arange(n) / rate_hz + 0.3
    band = InBand(n, rate_hz, (0.5, 30.0))
    acceleration = -((2 * np.pi * frequency_hz) ** 2) * height_m * np.sin(phase)
    both = band.coefficients(np.stack([acceleration, 2 * acceleration], axis=1))
    found = band.from_coefficients(band.integrated_twice(both))
    np.testing.assert_allclose(found[:, 0], height_m * np.sin(phase), atol=1e-12)
    np.testing.assert_allclose(found[:, 1], 2 * found[:, 0], atol=1e-12)
