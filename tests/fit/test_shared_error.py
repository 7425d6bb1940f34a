"""What channels err together is taken apart: their data are white again."""

import numpy as np
import pytest

from wheelhop.fit.shared_error import SharedError

LINES, CHANNELS, DRIVERS, TRIES = 3, 4, 2, 40_000


@pytest.fixture(scope="module")
def erring():
    """The factor, and many data (2 f, p, tries) of noise 1 with the errors of two drivers."""
    rng = np.random.default_rng(5)
    response = rng.normal(size=(2, LINES, CHANNELS, DRIVERS)).T @ [1.0, 1.0j]
    response = 3.0 * response.transpose(2, 1, 0)
    variance = rng.uniform(0.5, 2.0, (LINES, DRIVERS))
    own = rng.normal(size=(2, LINES, CHANNELS, TRIES))
    driven = rng.normal(size=(2, LINES, DRIVERS, TRIES)) * np.sqrt(variance)[None, :, :, None]
    seen = own[0] + 1j * own[1] + response @ (driven[0] + 1j * driven[1])
    return SharedError.of(response, variance), np.concatenate([seen.real, seen.imag])


def test_errors_are_white(erring):
    shared, seen = erring
    data = np.stack([shared.white(seen[:, :, k]) for k in range(2000)])
    flat = data.reshape(len(data), -1)
    covariance = flat.T @ flat / len(flat)
    np.testing.assert_allclose(covariance, np.eye(2 * LINES * CHANNELS), atol=0.12)
    as_seen = seen[:, :, :2000].reshape(2 * LINES * CHANNELS, -1)
    assert np.abs(np.corrcoef(as_seen) - np.eye(len(as_seen))).max() > 0.5


def test_white_data_are_recorded_ones_and_back(erring):
    shared, seen = erring
    one = seen[:, :, 0]
    np.testing.assert_allclose(shared.recorded(shared.white(one)), one, rtol=1e-9)


def test_what_is_foreseen_of_the_drivers_errors(erring):
    """The power of the drivers' errors in white data, by drawing them."""
    shared, _ = erring
    rng = np.random.default_rng(6)
    own = rng.normal(size=(2 * LINES, CHANNELS, 2000))
    without = np.mean([np.sum(shared.white(own[:, :, k]) ** 2) for k in range(2000)])
    assert 2 * LINES * CHANNELS - without == pytest.approx(shared.foreseen, rel=0.05)


def test_without_errors_of_the_driver_data_stay():
    response = np.ones((LINES, CHANNELS, DRIVERS)) + 0j
    shared = SharedError.of(response, np.zeros((LINES, DRIVERS)))
    data = np.arange(2.0 * LINES * CHANNELS).reshape(2 * LINES, CHANNELS)
    np.testing.assert_array_equal(shared.white(data), data)
    assert shared.foreseen == 0.0
