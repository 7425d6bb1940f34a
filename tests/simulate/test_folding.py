"""What sampling folds into a record, told from the record."""

import numpy as np
import pytest

from wheelhop.campaign import Averaging
from wheelhop.simulate import folded_power, sample_of

RATE_HZ, N, FINER, WINDOW_S = 100.0, 4096, 16, 0.0066


def recorded(slope, rng, lines_hz=None):
    """A motion whose power goes with this power of the frequency, as a logger's means record it,
    and the folded part of that record."""
    n = N * FINER
    frequency = np.fft.rfftfreq(n, 1.0 / (RATE_HZ * FINER))
    power = np.zeros_like(frequency)
    power[1:] = (frequency[1:] / 25.0) ** slope
    power[frequency > 4 * RATE_HZ] = 0.0
    if lines_hz is not None:
        power *= np.abs((frequency + lines_hz / 2) % lines_hz - lines_hz / 2) < 0.02
        power *= n / np.count_nonzero(power)
    spectrum = np.sqrt(power * n) * np.exp(2j * np.pi * rng.random(len(power)))
    spectrum *= np.sinc(frequency * WINDOW_S)
    above = np.where(frequency > RATE_HZ / 2, spectrum, 0.0)
    return [np.fft.irfft(s, n)[::FINER] for s in (spectrum, above)]


@pytest.mark.parametrize(
    ("lines_hz", "factor"), [(None, 2.0), (2.3, 4.0)], ids=["any road", "periodic road"]
)
@pytest.mark.parametrize("slope", [0.0, -1.0, -2.0, -3.0])
def test_the_size_of_what_is_folded_is_told(slope, lines_hz, factor):
    """Of a periodic road a few lines stand in each part of the octave."""
    record, folded = recorded(slope, np.random.default_rng(7), lines_hz)
    band = np.linspace(0.5, 30.0, 200)
    spectrum = np.abs(np.fft.rfft(folded)) ** 2 / N
    inside = (np.fft.rfftfreq(N, 0.01) > 0.5) & (np.fft.rfftfreq(N, 0.01) < 30.0)
    found = folded_power(record[:, None], RATE_HZ, Averaging(WINDOW_S).kept, 0.0, band).mean()
    assert 1 / factor < found / spectrum[inside].mean() < factor


def test_sensor_noise_is_not_taken_for_motion():
    noise = np.random.default_rng(3).normal(scale=0.1, size=(N, 2))
    found = folded_power(noise, RATE_HZ, Averaging(WINDOW_S).kept, 0.1, np.array([1.0, 10.0, 30.0]))
    assert (found < 0.2 * 0.1**2).all()


def test_a_sample_has_the_power_it_is_of():
    power = np.where(np.fft.rfftfreq(N, 0.01)[:, None] < 20.0, 4.0, 0.25)
    sample = sample_of(power, N, 1)
    np.testing.assert_array_equal(sample, sample_of(power, N, 1))
    spectrum = np.abs(np.fft.rfft(sample, axis=0)) ** 2 / N
    below = slice(1, int(20.0 / RATE_HZ * N))
    assert spectrum[below].mean() == pytest.approx(4.0, rel=0.1)
    assert spectrum[below.stop + 1 : -1].mean() == pytest.approx(0.25, rel=0.1)
