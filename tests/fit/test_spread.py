"""A noise for every channel of a run: least squares at the noise, logarithms far above it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.fit.spread import BELIEVED, cost, spread

SHAPE = (600, 3)
SIGMA = 0.2


def noise(seed, size=SIGMA):
    return size * np.random.default_rng(seed).normal(size=SHAPE)


def test_at_the_noise_it_is_least_squares():
    """Differences of the cost of two residuals near the noise are those of χ²."""
    one, small = noise(1), 1.0 + 0.003 * np.arange(3)
    other = one * small
    change = cost(other, SIGMA) - cost(one, SIGMA)
    chi2 = float(((other**2).sum() - (one**2).sum()) / SIGMA**2)
    assert change == pytest.approx(chi2, rel=0.1)
    assert cost(one, SIGMA) == pytest.approx(one.size, rel=0.1)
    assert spread(one, SIGMA) == pytest.approx(np.ones(3), abs=0.1)


@given(st.floats(10.0, 1e6), st.floats(2.0, 100.0))
def test_far_above_it_only_the_factor_counts(size, factor):
    """A channel that becomes k times smaller gains (ν + n) 2 ln k, however large it was."""
    residual = size * noise(2)
    gain = cost(factor * residual, SIGMA) - cost(residual, SIGMA)
    expected = (BELIEVED + SHAPE[0]) * 2.0 * np.log(factor) * SHAPE[1]
    assert gain == pytest.approx(expected, rel=1e-3)


def test_a_channel_does_not_weigh_on_another():
    residual = noise(3)
    loud = residual * [1.0, 1e4, 1.0]
    assert spread(loud, SIGMA)[[0, 2]] == pytest.approx(spread(residual, SIGMA)[[0, 2]])


@given(st.floats(0.3, 300.0), st.integers(0, SHAPE[0] - 1), st.integers(0, SHAPE[1] - 1))
def test_the_weights_are_those_of_the_costs_slope(size, row, column):
    """∂(−2 ln p)/∂r = 2 r / ρ²σ²: a step of weighted least squares goes downhill."""
    residual = size * noise(4)
    step = np.zeros(SHAPE)
    step[row, column] = 1e-4 * size
    slope = cost(residual + step, SIGMA) - cost(residual - step, SIGMA)
    slope /= 2e-4 * size
    weight = 1.0 / (spread(residual, SIGMA)[column] * SIGMA) ** 2
    assert slope == pytest.approx(2.0 * residual[row, column] * weight, rel=1e-3, abs=1e-5 / size)
