"""Kramers and Kronig, on models and on data; passivity; elements for the time domain."""

from functools import partial

import numpy as np
import pytest

from tests.material.table import FREQUENCY, POLYNOMIAL, POWER, ROWS, data_of, polynomial, power_law
from tests.material.test_models import OMEGA, examples
from wheelhop.material import (
    FractionalKelvinVoigt,
    GeneralizedMaxwell,
    LogarithmicPolynomial,
    MaterialError,
    ModifiedPowerLaw,
    ModulusData,
    approximate,
    consistency,
    passive_range_hz,
    violation,
)

WIDE = np.geomspace(0.1, 50.0, 40)


@examples
def test_the_integral_gives_the_loss_of_every_causal_model(model, values):
    """Exact ones within the quadrature, the published form within terms of order β⁴."""
    p = np.array(values)
    limit = 1e-3 if isinstance(model, ModifiedPowerLaw) else 1e-8
    assert violation(lambda omega: model.modulus(omega, p), OMEGA) < limit


@pytest.mark.parametrize("i", range(len(ROWS)))
def test_the_published_form_is_causal_for_small_exponents_only(i):
    a0, _, m0 = POWER[i]
    assert violation(lambda omega: power_law(i, omega), OMEGA) < 1e-3
    large = np.array([a0, 0.5, m0])
    assert violation(lambda w: ModifiedPowerLaw().modulus(w, large), OMEGA) > 0.05


def test_the_integral_finds_loss_that_does_not_belong():
    def advanced(omega):  # the loss of another temperature
        return polynomial(0, omega).real + 1.3j * polynomial(0, omega).imag

    assert violation(advanced, OMEGA) == pytest.approx(0.3 / 1.3, rel=1e-6)


@examples
@pytest.mark.parametrize("noise", [0.0, 0.01])
@pytest.mark.parametrize("frequency_hz", [FREQUENCY, WIDE], ids=["1-30", "0.1-50"])
def test_data_of_causal_models_are_consistent(model, values, noise, frequency_hz):
    for seed in range(3):
        data = data_of(lambda w: model.modulus(w, np.array(values)), frequency_hz, noise, seed)
        assert consistency(data).causal


def planted(name, data):
    """Data no causal specimen has."""
    m = data.modulus
    changed = {
        "softens with frequency": m.real[::-1] + 1j * m.imag,
        "loss of another order": m.real + 2j * m.imag,
        "loss falling instead of rising": m.real + 1j * m.imag[::-1],
    }[name]
    return ModulusData(name, data.frequency_hz, changed, data.uncertainty)


@pytest.mark.parametrize("i", (2, 5))
@pytest.mark.parametrize(
    "name", ["softens with frequency", "loss of another order", "loss falling instead of rising"]
)
def test_a_planted_violation_is_found(i, name):
    for seed in range(3):
        data = data_of(lambda omega: power_law(i, omega), noise=0.01, seed=seed)
        assert consistency(data).causal
        found = consistency(planted(name, data))
        assert not found.causal and found.disagreement > 0.01


def test_chance_seldom_makes_causal_data_look_otherwise():
    """At most 2 of 200 with 1 % noise."""
    false = 0
    for i in range(8):
        for seed in range(25):
            data = data_of(partial(power_law, i), noise=0.01, seed=seed)
            false += not consistency(data).causal
    assert false <= 2


def test_the_expansion_3_16_is_exact_for_a_logarithmic_polynomial():
    found = consistency(data_of(lambda omega: polynomial(0, omega)))
    assert found.expansion_residual < 1e-3
    # For β = 0.5 it leaves out what it must: tan x against x + x³/3 at x = π/4.
    power = np.array([0.0, 1e6, 0.5])
    found = consistency(data_of(lambda w: FractionalKelvinVoigt().modulus(w, power)))
    x = np.pi / 4
    assert found.expansion_residual == pytest.approx(1 - x - x**3 / 3, rel=0.1)


def test_where_a_model_would_give_energy():
    """(3.40) changes sign at ω = exp(−A₁/2A₂)."""
    a = POLYNOMIAL[2]
    edge = np.exp(-a[1] / (2 * a[2])) / (2 * np.pi)
    low, high = passive_range_hz(lambda w: LogarithmicPolynomial().modulus(w, a), (1, 30))
    assert low == pytest.approx(edge, rel=0.03) and high == pytest.approx(1e5)
    gives = np.array([1e6, -1e4, 0.0])
    assert passive_range_hz(lambda w: LogarithmicPolynomial().modulus(w, gives), (1, 30)) is None


FINE = 2 * np.pi * np.geomspace(0.1, 50.0, 997)


@pytest.mark.parametrize("i", range(len(ROWS)))
@pytest.mark.parametrize("form", [power_law, polynomial])
def test_elements_follow_every_bushing_of_the_table(form, i):
    """Within 1 % over 0.1–50 Hz, between the frequencies they were fitted at too."""
    elements = approximate(lambda omega: form(i, omega))
    assert np.abs(elements.modulus(FINE) / form(i, FINE) - 1).max() < 0.0105
    assert len(elements.times_s) <= 5
    assert elements.stiffness_N_m >= 0 and elements.damping_N_s_m >= 0
    assert (elements.strengths_N_m > 0).all() and (elements.times_s > 0).all()


@examples
def test_elements_follow_every_model(model, values):
    elements = approximate(lambda omega: model.modulus(omega, np.array(values)))
    exact = model.modulus(FINE, np.array(values))
    assert np.abs(elements.modulus(FINE) / exact - 1).max() < 0.0105


def test_more_is_asked_with_more_elements():
    def half(omega):
        return FractionalKelvinVoigt().modulus(omega, np.array([1e5, 4e5, 0.5]))

    counts = [len(approximate(half, tolerance=t).times_s) for t in (0.05, 0.01, 0.001)]
    assert counts == sorted(counts) and counts[0] < counts[2]


def test_elements_come_back_as_they_are():
    """A spring is one spring; a Maxwell element in the middle of the band is followed."""
    spring = approximate(lambda omega: 1e6 + 0j * omega)
    assert spring.stiffness_N_m == pytest.approx(1e6) and not len(spring.times_s)
    damper = approximate(lambda omega: 1e6 + 2e3j * omega)
    assert damper.damping_N_s_m == pytest.approx(2e3) and not len(damper.times_s)
    one = np.array([5e5, 5e5])
    found = approximate(lambda omega: GeneralizedMaxwell([0.02]).modulus(omega, one))
    assert found.stiffness_N_m == pytest.approx(5e5, rel=0.01)


def test_a_specimen_that_gives_energy_has_no_elements():
    with pytest.raises(MaterialError, match="passive specimen"):
        approximate(lambda omega: 1e6 - 2e3j * omega)
