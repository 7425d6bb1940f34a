"""A specimen at several temperatures: the shift that made the data is found."""

import numpy as np
import pytest

from wheelhop.material import FractionalZener, MaterialError, ModulusData
from wheelhop.material.shift import shift_temperatures

FREQUENCY = np.geomspace(1.0, 50.0, 15)
WARMTH = (-20.0, 0.0, 23.0, 60.0)
C1, C2 = 8.86, 101.6


def modulus(omega):
    """E₀ (1 + k z/(1 + z)), z = (sτ)^α: in none of wheelhop's code."""
    z = (1j * omega * 2e-3) ** 0.35
    return 8e5 * (1 + 4.0 * z / (1 + z))


def measured(temperature, noise, seed=0):
    rng = np.random.default_rng(seed + int(temperature) + 100)
    shift = 10 ** (-C1 * (temperature - 23.0) / (C2 + temperature - 23.0))
    values = modulus(2 * np.pi * FREQUENCY * shift)
    values = values.real * np.exp(noise * rng.normal(size=15)) + 1j * values.imag * np.exp(
        noise * rng.normal(size=15)
    )
    return ModulusData("rubber", FREQUENCY, values, np.full(15, np.nan))


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_the_shift_that_made_the_data(noise):
    data = [measured(t, noise) for t in WARMTH]
    found = shift_temperatures(data, WARMTH, FractionalZener(), 23.0)
    true = -C1 * (np.array(WARMTH) - 23.0) / (C2 + np.array(WARMTH) - 23.0)
    assert found.log10_shift(np.array(WARMTH)) == pytest.approx(true, abs=0.01 + 8 * noise)
    assert found.master.rms <= 1.2 * noise + 1e-4
    assert found.log10_shift(23.0) == 0.0
    # A temperature nobody measured: between those measured the model knows it.
    between = found.at(40.0, data[0]).modulus
    exact = measured(40.0, 0.0).modulus
    assert np.abs(between / exact - 1).max() < 1e-3 + 3 * noise


def test_what_no_shift_explains_is_seen():
    """A specimen that another spring is put beside at one temperature: each alone is followed, the
    master curve is not."""
    data = [measured(t, 0.005) for t in WARMTH]
    other = ModulusData("rubber", FREQUENCY, data[1].modulus + 8e5, data[1].uncertainty)
    found = shift_temperatures([data[0], other, *data[2:]], WARMTH, FractionalZener(), 23.0)
    assert found.apart.max() < 0.01
    assert found.master.rms > 5 * found.apart.max()


def test_two_temperatures_are_too_few():
    with pytest.raises(MaterialError, match="at least 3 temperatures"):
        shift_temperatures(
            [measured(0.0, 0), measured(23.0, 0)], (0.0, 23.0), FractionalZener(), 23.0
        )
