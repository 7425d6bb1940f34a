"""The models against the published table, against each other, and against computer algebra."""

from itertools import product

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from tests.material.table import FREQUENCY, POLYNOMIAL, POWER, ROWS, data_of, polynomial, power_law
from wheelhop.material import (
    MODELS,
    CausalPowerLaw,
    FractionalKelvinVoigt,
    FractionalZener,
    GeneralizedMaxwell,
    LogarithmicPolynomial,
    ModifiedPowerLaw,
    PowerLogarithm,
    fit_modulus,
    log_error,
)
from wheelhop.material.models import loss_coefficients

OMEGA = 2 * np.pi * FREQUENCY
EXAMPLES = {
    "modified-power-law": (ModifiedPowerLaw(), [5.3e5, 0.056, 4.9e5]),
    "causal-power-law": (CausalPowerLaw(), [5.3e5, 0.056, 4.9e5]),
    "logarithmic-polynomial": (LogarithmicPolynomial(), [1.02e6, 2.7e4, 2.6e3]),
    "fractional-kelvin-voigt": (FractionalKelvinVoigt(), [6.2e5, 3.9e5, 0.09]),
    "fractional-zener": (FractionalZener(), [9e5, 1.8, 8e-6, 0.19]),
    "power-logarithm": (PowerLogarithm(), [4e5, 5e5, 1e4, 2e3, 0.1]),
    "generalized-maxwell": (GeneralizedMaxwell([0.1, 0.02, 0.003]), [5e5, 1e5, 2e5, 1e5]),
}
examples = pytest.mark.parametrize("model, values", EXAMPLES.values(), ids=EXAMPLES)


def test_every_model_has_its_example():
    assert set(EXAMPLES) == set(MODELS)


@pytest.mark.parametrize("i", range(len(ROWS)))
def test_both_columns_of_table_3_2_are_the_same_curve(i):
    """Within 1.5 % in M_d and 6 % in M_l; for specimen 2 of bushing 2 from 1.2 Hz on only."""
    ratio = power_law(i, OMEGA).real / polynomial(i, OMEGA).real
    first = 1 if ROWS[i][:2] == (2, 2) else 0
    assert np.abs(ratio[first:] - 1).max() < 0.015
    assert np.abs(power_law(i, OMEGA).imag / polynomial(i, OMEGA).imag - 1).max() < 0.06
    # In hertz instead of rad/s nothing agrees.
    assert np.abs(power_law(i, FREQUENCY).imag / polynomial(i, OMEGA).imag - 1).max() > 0.06


def test_no_digits_left_out_of_the_table_bring_its_poorest_row_within_1_5_per_cent():
    """Specimen 2 of bushing 2 at 1 Hz: 1.73 % as printed, 1.6 % at best if every number may be
    anything that rounds to what is printed. The source's two fits differ, not our formulas: with
    three free numbers the power law comes within 0.8 % of the polynomial."""
    i, half = 3, np.array([0.5, 0.5e-3, 0.5])  # half of the last digit: N/m, 1, N/m
    omega = OMEGA[:1]
    gaps = [
        ModifiedPowerLaw().modulus(omega, POWER[i] + half * p).real[0]
        / LogarithmicPolynomial().modulus(omega, POLYNOMIAL[i] + 0.5 * np.array(q)).real[0]
        - 1
        for p in product((-1, 0, 1), repeat=3)
        for q in product((-1, 0, 1), repeat=3)
    ]
    assert 0.015 < min(gaps) < 0.0173 < max(gaps)
    fit = fit_modulus(ModifiedPowerLaw(), data_of(lambda w: polynomial(i, w)))
    assert np.abs(fit.modulus(OMEGA).real / polynomial(i, OMEGA).real - 1).max() < 0.008


@pytest.mark.parametrize("beta", [0.05, 0.3, 0.5])
def test_the_exact_form_has_the_published_dynamic_modulus(beta):
    """And the loss modulus of the published form but for terms of order β⁴."""
    p = np.array([5e5, beta, 3e5])
    exact, published = CausalPowerLaw().modulus(OMEGA, p), ModifiedPowerLaw().modulus(OMEGA, p)
    assert np.allclose(exact.real, published.real, rtol=1e-12)
    assert np.abs(exact.imag / published.imag - 1).max() < 10 * beta**4


def test_the_corrected_loss_coefficients_follow_from_the_operator():
    """(3.22) from (3.16) by computer algebra; the printed B1 does not."""
    w, beta = sp.symbols("omega beta", positive=True)
    a = sp.symbols("A0:3")
    log = sp.log(w)
    dynamic = (a[0] + a[1] * log + a[2] * log**2) * w**beta

    def theta(f):
        return w * sp.diff(f, w)

    loss = sp.pi / 2 * theta(dynamic) + sp.pi**3 / 24 * theta(theta(theta(dynamic)))
    # θ³ is the bracket of (3.16).
    bracket = sum(c * w**k * sp.diff(dynamic, w, k) for c, k in ((1, 1), (3, 2), (1, 3)))
    assert sp.simplify(theta(theta(theta(dynamic))) - bracket) == 0
    polynomial_in_log = sp.Poly(sp.expand(sp.simplify(loss / w**beta)), log)
    b = [polynomial_in_log.coeff_monomial(log**k) for k in range(3)]
    pi = sp.pi
    kappa = pi * beta / 2 + pi**3 * beta**3 / 24
    assert sp.simplify(b[1] - kappa * a[1] - (pi + pi**3 * beta**2 / 4) * a[2]) == 0
    printed = pi * beta / 2 * a[1] + (pi**3 * beta**3 + pi**3 * beta**2 / 4 + pi) * a[2] / 24
    assert sp.simplify(b[1] - printed) != 0
    values = {beta: 0.3, a[0]: 2.0, a[1]: -0.7, a[2]: 0.4}
    numbers = [float(c.subs(values)) for c in b]
    assert loss_coefficients(np.array([2.0, -0.7, 0.4]), 0.3) == pytest.approx(numbers, rel=1e-12)


@examples
def test_derivatives_are_those_of_the_modulus(model, values):
    p = np.array(values)
    for k in range(len(p)):
        step = 1e-6 * abs(p[k]) * np.eye(len(p))[k]
        slope = (model.modulus(OMEGA, p + step) - model.modulus(OMEGA, p - step)) / (2 * step[k])
        assert np.allclose(model.derivatives(OMEGA, p)[:, k], slope, rtol=1e-5, atol=1e-7)


@examples
def test_weights_and_shape_make_the_modulus(model, values):
    """What the fit solves for is what the model is."""
    weights = np.arange(1.0, 1 + model.basis(OMEGA, next(iter(model.shapes(OMEGA)))).shape[1])
    for shape in model.shapes(OMEGA):
        whole = model.basis(OMEGA, shape) @ weights
        assert np.allclose(model.modulus(OMEGA, model.assembled(weights, shape)), whole)


def test_kinship_of_the_models():
    """The exact family holds (3.42), and next to β = 0 the logarithmic polynomial; a relaxation
    of exponent 1 is a Maxwell element."""
    family = PowerLogarithm().modulus(OMEGA, np.array([6e5, 4e5, 0.0, 0.0, 0.09]))
    assert np.allclose(family, FractionalKelvinVoigt().modulus(OMEGA, np.array([6e5, 4e5, 0.09])))
    a0, a1, a2 = 1e6, 3e4, 2e3  # (3.38): the constant holds A2 π²/4
    near = PowerLogarithm().modulus(OMEGA, np.array([0.0, a0 + a2 * np.pi**2 / 4, a1, a2, 1e-9]))
    assert np.allclose(near, LogarithmicPolynomial().modulus(OMEGA, np.array([a0, a1, a2])))
    zener = FractionalZener().modulus(OMEGA, np.array([5e5, 0.4, 0.02, 1.0]))
    assert np.allclose(zener, GeneralizedMaxwell([0.02]).modulus(OMEGA, np.array([5e5, 2e5])))


@given(st.floats(0.2, 5.0), st.floats(0.05, 0.5))
def test_the_error_is_that_of_3_41(stiffer, lossier):
    data = data_of(lambda omega: power_law(0, omega)).modulus
    model = stiffer * data.real + 1j * lossier * data.imag
    expected = len(data) * (np.log(stiffer) ** 2 + np.log(lossier) ** 2)
    assert log_error(model, data) == pytest.approx(expected, rel=1e-9)
    assert log_error(model.conj(), data) == np.inf
