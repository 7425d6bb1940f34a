"""ISO/TS 18571 against closed forms and against an independent implementation."""

import numpy as np
import pytest
from scipy import ndimage

from wheelhop.compare import iso18571

N = 1000
TIME = np.arange(N) / 100.0
HALF_SINE = np.sin(np.pi * TIME / 10.0) ** 2 * np.sin(2 * np.pi * 0.35 * TIME)


def one(measured, model):
    return iso18571(measured[:, None], model[:, None])[0]


def test_a_perfect_model_scores_one_in_everything():
    rating = one(HALF_SINE, HALF_SINE)
    scores = (rating.corridor, rating.phase, rating.magnitude, rating.slope, rating.overall)
    assert scores == pytest.approx((1.0,) * 5, abs=1e-12)


def test_a_constant_distance_between_the_corridors():
    # Distance d of the largest value: ((0.5 - d) / 0.45)² inside, 1 below 0.05, 0 above 0.5.
    for d, score in ((0.04, 1.0), (0.2, (0.3 / 0.45) ** 2), (0.6, 0.0)):
        assert one(HALF_SINE, HALF_SINE + d * np.abs(HALF_SINE).max()).corridor == pytest.approx(
            score
        )


@pytest.mark.parametrize("shift", [-150, -40, 40, 150])
def test_a_delayed_model_loses_phase_only_in_proportion_to_the_delay(shift):
    rating = one(HALF_SINE, np.roll(HALF_SINE, shift))
    assert rating.phase == pytest.approx(1.0 - abs(shift) / 200.0)
    assert rating.magnitude == pytest.approx(1.0, abs=1e-6)


def test_a_periodic_signal_takes_the_smallest_of_its_equally_good_shifts():
    wave = np.sin(2 * np.pi * TIME)
    assert one(wave, wave).phase == 1.0
    assert one(wave, np.roll(wave, 10)).phase == pytest.approx(1.0 - 10 / 200.0)


@pytest.mark.parametrize("gain", [0.8, 1.2])
def test_a_gain_error_of_a_slow_curve_costs_slope_in_proportion(gain):
    rating = one(HALF_SINE, gain * HALF_SINE)
    assert rating.phase == 1.0
    assert rating.slope == pytest.approx(1.0 - 0.2 / 2.0)
    # Warping can only bring the curves closer than the gain's 20 %.
    assert 1.0 - 0.2 / 0.5 <= rating.magnitude <= 1.0


def test_an_offset_of_a_constant_cannot_be_warped_away():
    flat = np.ones(N)
    flat[0] = 1.0 + 1e-9  # a correlation needs some variance
    assert one(flat, 1.1 * flat).magnitude == pytest.approx(1.0 - 0.1 / 0.5, abs=1e-6)


def test_a_measurement_that_is_zero_has_no_rating():
    zero = np.zeros(N)
    assert np.isnan(one(zero, HALF_SINE).overall)


def random_pair(seed):
    rng = np.random.default_rng(seed)
    t = ndimage.gaussian_filter1d(rng.standard_normal(N), rng.uniform(1, 10))
    t /= t.std()
    other = ndimage.gaussian_filter1d(rng.standard_normal(N), 3.0)
    if seed > 3:  # stretched so far that the warping meets its window
        stretched = TIME + 2.6 * np.sin(np.pi * TIME / 10.0)
        return t, np.interp(stretched, TIME, t)
    return t, np.roll(t, rng.integers(-30, 30)) * rng.uniform(0.6, 1.4) + 0.4 * other


def test_columns_are_rated_independently_of_each_other():
    pairs = [random_pair(seed) for seed in range(5)]
    measured, model = (np.stack(side, axis=1) for side in zip(*pairs, strict=True))
    together = iso18571(measured, model)
    for pair, rating in zip(pairs, together, strict=True):
        assert rating.overall == pytest.approx(one(*pair).overall, abs=1e-12)


# corridor, phase, magnitude, slope of random_pair(seed) by objective_rating_metrics 1.3
# (VSI, TU Graz, https://openvt.eu/validation-metrics/ISO18571).
PUBLISHED = {
    0: (0.297814, 0.87, 0.87223, 0.860113),
    1: (0.424411, 0.905, 0.738833, 0.926716),
    2: (0.28208, 0.895, 0.827615, 0.857917),
    3: (0.399216, 0.94, 0.679669, 0.79798),
    4: (0.42761, 0.25, 0.514756, 0.284084),
    5: (0.246463, 0.655, 0.351619, 0.394869),
}


@pytest.mark.parametrize("seed", PUBLISHED)
def test_the_reference_implementation_agrees(seed):
    rating = one(*random_pair(seed))
    scores = (rating.corridor, rating.phase, rating.magnitude, rating.slope)
    assert scores == pytest.approx(PUBLISHED[seed], abs=1e-6)
