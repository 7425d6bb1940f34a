"""The density of unknown heights: Gaussian records, everything written in full."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from tests.simulate.setup import ATV, EFFECTS
from wheelhop.compare.band import InBand
from wheelhop.fit.density import Noise, Spectrum, explained, find_density
from wheelhop.fit.height_response import Ground

ROUGHNESS = EFFECTS["small-scale-roughness"]
PARAMETERS = ROUGHNESS.parameters_for(ATV, ())
THETA = {"unevenness_m3": 1e-6, "waviness": 2.0}
WAVE = np.linspace(1.0, 12.0, 150)
CHANNELS, PER_DENSITY, SIGMA = 5, 30.0, 0.4
SIZE = 2 * len(WAVE) * CHANNELS


def variance(theta, wave=WAVE):
    """Of the real part, and of the imaginary one, of a line of the heights."""
    return PER_DENSITY * theta["unevenness_m3"] * wave ** -theta["waviness"]


def gaussian(rng, *shape):
    return rng.normal(size=(*shape, 2)) @ [1.0, 1.0j]


def record(seed, theta=THETA, sigma=SIGMA):
    """A run's channels at every frequency: what two paths make of them, and noise."""
    rng = np.random.default_rng(seed)
    response = 300.0 * gaussian(rng, len(WAVE), CHANNELS, 2)
    heights = gaussian(rng, len(WAVE), 2) * np.sqrt(variance(theta))[:, None]
    noise = sigma * gaussian(rng, len(WAVE), CHANNELS)
    return response, (response @ heights[:, :, None])[:, :, 0] + noise


def spectrum(response, data, residual=0.0):
    adjoint = response.conj().transpose(0, 2, 1)
    energy = (np.abs(data) ** 2).sum(axis=1)
    cross = (adjoint @ data[:, :, None])[:, :, 0]
    return Spectrum(WAVE, PER_DENSITY, adjoint @ response, cross, energy, residual)


def spectra(theta=THETA, sigma=SIGMA):
    return [spectrum(*record(seed, theta, sigma)) for seed in (1, 2)]


def test_the_evidence_is_that_of_gaussian_records():
    """Real and imaginary part of every datum as the real normal density has them. What is left and
    what is spent are those of the ridge estimate; the surprise is Mahalanobis' distance."""
    expected, left, penalty, freedom, surprise = 0.0, 0.0, 0.0, 0.0, []
    runs = [record(seed) for seed in (1, 2)]
    for response, data in runs:
        for h, d, v in zip(response, data, variance(THETA), strict=True):
            both = np.block([[h.real, -h.imag], [h.imag, h.real]])
            seen = np.concatenate([d.real, d.imag])
            spread = v * both @ both.T + SIGMA**2 * np.eye(len(seen))
            expected += stats.multivariate_normal(cov=spread).logpdf(seen)
            ridge = np.linalg.solve(both.T @ both + SIGMA**2 / v * np.eye(4), both.T)
            heights = ridge @ seen
            left += float(np.sum((seen - both @ heights) ** 2))
            penalty += heights @ heights / v
            freedom += np.trace(both @ ridge)
            surprise.append(seen @ np.linalg.solve(spread, seen))
    found = explained(ROUGHNESS, THETA, [spectrum(*run) for run in runs], SIGMA)
    constant = 0.5 * 2 * SIZE * np.log(2.0 * np.pi)
    assert found.evidence(2 * SIZE, SIGMA) == pytest.approx(expected + constant, rel=1e-9)
    assert found.rss == pytest.approx(left, rel=1e-9)
    assert found.penalty == pytest.approx(penalty, rel=1e-9)
    assert found.freedom == pytest.approx(freedom, rel=1e-9)
    assert found.surprise / SIGMA**2 == pytest.approx(surprise, rel=1e-9)
    assert np.mean(surprise) == pytest.approx(2.0 * CHANNELS, rel=0.05)


SURE = Noise(0.0, 2 * SIZE, SIGMA)
"""What the sensors are stated to have."""


def likely(theta, seen, sigma=SIGMA):
    """Logarithm of the posterior density of the density's parameters."""
    away = [(theta[p.name] - p.start) / p.scale for p in PARAMETERS]
    return explained(ROUGHNESS, theta, seen, sigma).evidence(2 * SIZE, sigma) - 0.5 * np.dot(
        away, away
    )


@pytest.mark.parametrize("begin", [1e-10, 1e-6, 1e-3])
def test_the_density_found_is_the_likeliest(begin):
    """Wherever the search begins; and the true one is not far."""
    seen = spectra()
    begun = {"unevenness_m3": begin, "waviness": 3.0}
    found, noise = find_density(ROUGHNESS, PARAMETERS, begun, seen, SURE)
    assert begun == {"unevenness_m3": begin, "waviness": 3.0}
    assert noise.sigma == SIGMA
    best = likely(found, seen)
    for name in found:
        for factor in (0.99, 1.01):
            assert likely({**found, name: factor * found[name]}, seen) < best
    assert found["waviness"] == pytest.approx(THETA["waviness"], abs=0.2)
    assert found["unevenness_m3"] == pytest.approx(THETA["unevenness_m3"], rel=0.4)


def test_what_is_believed_of_the_density_counts_as_data_do():
    """A slope that the records tell to 0.1 and that is believed to 0.003 stays as believed."""
    size, slope = PARAMETERS
    believed = [size, replace(slope, scale=0.003, starts=(2.5,))]
    found, _ = find_density(ROUGHNESS, believed, THETA, spectra(), SURE)
    assert found["waviness"] == pytest.approx(2.5, abs=0.02)
    free, _ = find_density(ROUGHNESS, PARAMETERS, THETA, spectra(), SURE)
    assert free["waviness"] == pytest.approx(2.0, abs=0.2)


def test_a_density_stays_within_its_bounds():
    """Even ground has the least there is; what falls faster than may be falls as fast as may be."""
    even, _ = find_density(
        ROUGHNESS, PARAMETERS, THETA, spectra({**THETA, "unevenness_m3": 0.0}), SURE
    )
    assert even["unevenness_m3"] == PARAMETERS[0].lower
    steep = {"unevenness_m3": 1e-3, "waviness": 5.6}
    found, _ = find_density(ROUGHNESS, PARAMETERS, THETA, spectra(steep), SURE)
    assert found["waviness"] == PARAMETERS[1].upper


@pytest.mark.parametrize("parameters", [(), PARAMETERS], ids=["given", "free"])
def test_the_noise_is_what_heights_leave_of_the_records(parameters):
    """Nobody states it. A run without heights tells it, too: what that leaves is counted beside."""
    sigma, beside = 0.1, 5000
    seen = [replace(s, residual=float(s.energy.sum())) for s in spectra(sigma=sigma)]
    rss = sum(s.residual for s in seen) + beside * sigma**2
    given = Noise(rss, 2 * SIZE + beside, 0.0)
    theta, noise = find_density(ROUGHNESS, parameters, THETA, seen, given)
    assert parameters or theta == THETA
    assert noise.sigma == pytest.approx(sigma, rel=0.02)
    left = explained(ROUGHNESS, theta, seen, noise.sigma)
    assert noise.rss == pytest.approx(beside * sigma**2 + left.rss, rel=1e-3)
    assert noise.freedom == pytest.approx(given.freedom - left.freedom, rel=1e-3)


def test_heights_of_a_density_never_leave_more_than_there_was():
    """They were there before, and left next to nothing."""
    _, noise = find_density(ROUGHNESS, (), THETA, spectra(), Noise(3.0, 4000.0, 0.0))
    assert noise.rss == 3.0


def test_noise_is_a_mean_square_and_no_less_than_the_sensors():
    assert Noise(18.0, 2.0, 0.5).sigma == 3.0
    assert Noise(18.0, 2.0, 4.0).sigma == 4.0
    assert Noise(9.0, 0.0, 0.0).sigma == 3.0  # nothing is left to tell it by


BAND = InBand(512, 100.0, (0.5, 30.0))


class Line(Ground):
    """Ground whose channels meet its heights a little later each."""

    def __init__(self):
        self.bench, self.speed_m_s = SimpleNamespace(band=BAND), 2.5

    def response(self, wave_number_rad_m):
        later = np.array([[0.0, 0.1], [0.3, -0.2], [0.5, 0.4]])
        return np.exp(-1j * wave_number_rad_m[:, None, None] * later)


def test_a_record_is_tapered_by_a_half_sine_that_leaves_noise_its_power():
    """√2 sin π t/T, of which the mean square is one; what happens at the ends is not heard."""
    rng = np.random.default_rng(3)
    signal, ground = BAND.signal(rng.normal(size=(BAND.n, 3))), Line()
    share = (np.arange(BAND.n) + 0.5) / BAND.n
    heard = BAND.coefficients(np.sqrt(2.0) * np.sin(np.pi * share)[:, None] * signal)
    real, imaginary = np.split(heard, 2)
    data, left = BAND.coefficients(signal).ravel(), np.array([3.0, 4.0])
    found = Spectrum.of(ground, data, left)
    np.testing.assert_allclose(found.energy, (real**2 + imaginary**2).sum(axis=1), rtol=1e-9)
    assert found.energy.sum() == pytest.approx(data @ data, rel=0.1)
    wave = 2.0 * np.pi * BAND.frequency_hz / ground.speed_m_s
    np.testing.assert_allclose(found.wave_number_rad_m, wave)
    response = ground.response(wave)
    for k in (0, 7, len(wave) - 1):
        adjoint = response[k].conj().T
        np.testing.assert_allclose(found.square[k], adjoint @ response[k])
        np.testing.assert_allclose(found.cross[k], adjoint @ (real + 1j * imaginary)[k])
    assert found.residual == 25.0


def test_a_line_of_heights_has_the_variance_of_its_density():
    """White heights of density S per rad/m, sampled at `rate`: the record's unit is one sample, of
    which the way is v/rate; ∫ S dκ up to the highest wave number π rate/v is their variance."""
    ground = Line()
    highest = np.pi * BAND.rate_hz / ground.speed_m_s
    assert ground.coefficient_variance == pytest.approx(highest)
