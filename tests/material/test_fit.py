"""Fits recover what made the data, find the best there is, and say how sure they are."""

from functools import partial
from itertools import product

import numpy as np
import pytest

from tests.material.table import FREQUENCY, POWER, ROWS, data_of, polynomial, power_law
from tests.material.test_models import EXAMPLES, OMEGA, examples
from wheelhop.material import (
    MODELS,
    CausalPowerLaw,
    FractionalKelvinVoigt,
    FractionalZener,
    LogarithmicPolynomial,
    MaterialError,
    ModifiedPowerLaw,
    PowerLogarithm,
    candidates,
    fit_modulus,
    log_error,
)
from wheelhop.material.select import aicc

WIDE = np.geomspace(0.1, 100.0, 40)


@examples
def test_a_fit_recovers_the_parameters_that_made_the_data(model, values):
    fit = fit_modulus(model, data_of(lambda omega: model.modulus(omega, np.array(values)), WIDE))
    assert fit.error < 1e-9
    assert fit.parameters == pytest.approx(values, rel=0.03)


@pytest.mark.parametrize("name", MODELS)
def test_no_other_start_leads_to_a_smaller_error(name):
    """Whatever shape a search begins with; with data none of the models has made."""
    data = data_of(lambda omega: power_law(2, omega) + 800j * omega, noise=0.01, seed=4)
    model = MODELS[name](data.omega)
    best = fit_modulus(model, data).error
    own = len(next(iter(model.shapes(data.omega))))
    rng = np.random.default_rng(1)
    for _ in range(12 if own else 0):
        start = np.exp(rng.uniform(np.log(0.02), np.log(0.5), own))
        if own == 2:
            start[0] = np.exp(rng.uniform(np.log(1e-9), np.log(10.0)))
        try:
            other = fit_modulus(model, data, [start])
        except MaterialError:
            continue
        assert best <= other.error * (1 + 1e-6)


def test_intervals_hold_the_truth_as_often_as_they_say():
    """95 % intervals of independent noise on three parameters; 200 draws give 95 ± 3 %."""
    truth = np.array([1.0e6, 3.0e4, 2.0e3])
    held = np.zeros(3)
    for seed in range(200):
        data = data_of(lambda w: LogarithmicPolynomial().modulus(w, truth), noise=0.01, seed=seed)
        fit = fit_modulus(LogarithmicPolynomial(), data)
        held += np.abs(fit.parameters - truth) <= fit.half_widths()
    assert ((held / 200 > 0.90) & (held / 200 < 0.99)).all()


def test_the_band_holds_the_curve():
    fit = fit_modulus(ModifiedPowerLaw(), data_of(lambda w: power_law(0, w), noise=0.01, seed=1))
    dynamic, loss = fit.band(OMEGA)
    off = fit.modulus(OMEGA) - power_law(0, OMEGA)
    assert (np.abs(off.real) < 2 * dynamic).all() and (np.abs(off.imag) < 2 * loss).all()
    assert (dynamic < 0.01 * fit.modulus(OMEGA).real).all()


PRINTED = {  # Table 3.3
    "modified-power-law": POWER[0],
    "fractional-zener": np.array([899.72e3, 1.82, 8.2e-6, 0.19]),
    "fractional-kelvin-voigt": np.array([615.72e3, 392.49e3, 0.09]),
}


def test_the_ranking_of_table_3_3_is_that_of_its_parameters():
    """As printed the three rank as published in each of 50 draws of 1 % noise, on the curve of
    either column of Table 3.2."""
    for curve, seed in product((power_law, polynomial), range(50)):
        data = data_of(partial(curve, 0), noise=0.01, seed=seed)
        errors = [
            log_error(EXAMPLES[name][0].modulus(data.omega, p), data.modulus)
            for name, p in PRINTED.items()
        ]
        assert errors[1] > 2 * errors[0] and errors[2] > 1.3 * errors[1]


def test_the_ranking_of_table_3_3_is_not_that_of_its_models():
    """Fitted again, the two others come within 0.03 % rms of the modified power law's own curve, a
    thirtieth of the noise, so that it beats Kelvin and Voigt's in about half of 50 draws."""
    exact = data_of(lambda omega: power_law(0, omega))
    for name in PRINTED:
        assert fit_modulus(EXAMPLES[name][0], exact).rms < 3e-4
    first = 0
    for seed in range(50):
        data = data_of(lambda omega: power_law(0, omega), noise=0.01, seed=seed)
        published, _, kelvin_voigt = (fit_modulus(EXAMPLES[n][0], data).error for n in PRINTED)
        first += published < kelvin_voigt
    assert 12 <= first <= 38


def test_the_digits_of_table_3_3_decide_its_ranking():
    """α = 0.09 may be 0.0875, and then Kelvin and Voigt's model comes before the four-parameter
    one of any numbers that round to the printed ones."""
    data = data_of(lambda omega: power_law(0, omega))
    e0, e1, _ = PRINTED["fractional-kelvin-voigt"]
    rounded = FractionalKelvinVoigt().modulus(OMEGA, np.array([e0, e1, 0.0875]))
    half = np.array([5.0, 0.005, 0.05e-6, 0.005])
    zener = [
        FractionalZener().modulus(OMEGA, PRINTED["fractional-zener"] + half * np.array(signs))
        for signs in product((-1, -0.5, 0, 0.5, 1), repeat=4)
    ]
    assert log_error(rounded, data.modulus) < min(log_error(m, data.modulus) for m in zener)


@pytest.mark.parametrize("name", MODELS)
def test_the_exact_family_of_three_parameters_is_as_good_as_the_published_form(name):
    """Whatever made the data: by the triangle inequality √J of the exact form exceeds that of the
    published one by no more than their distance, below 0.06 % rms; its fit knows that. On curves
    of its own the published form cannot be beaten: there J = 0."""
    values = EXAMPLES[name][1]
    for seed in range(5):
        curve = partial(EXAMPLES[name][0].modulus, parameters=np.array(values))
        data = data_of(curve, noise=0.01 * (seed > 0), seed=seed)
        published = fit_modulus(ModifiedPowerLaw(), data)
        twin = CausalPowerLaw().modulus(OMEGA, published.parameters)
        away = np.sqrt(log_error(twin, published.modulus(OMEGA)))
        exact = fit_modulus(CausalPowerLaw(), data)
        assert np.sqrt(exact.error) <= np.sqrt(published.error) + away + 1e-6
        if seed:
            assert exact.error <= 1.005 * published.error


@pytest.mark.parametrize("i", range(len(ROWS)))
def test_neither_form_of_the_power_law_is_better_on_the_table(i):
    """On the published form's own curves with 1 % noise J of the exact one is the same within
    0.3 %; two more parameters are never worse than Kelvin and Voigt's or the polynomial."""
    data = data_of(lambda omega: power_law(i, omega), noise=0.01, seed=10 + i)
    published = fit_modulus(ModifiedPowerLaw(), data).error
    assert fit_modulus(CausalPowerLaw(), data).error == pytest.approx(published, rel=3e-3)
    others = (FractionalKelvinVoigt(), LogarithmicPolynomial())
    best = min(fit_modulus(model, data).error for model in others)
    assert fit_modulus(PowerLogarithm(), data).error <= best * (1 + 1e-6)


def test_the_criterion_finds_the_model_that_made_the_data():
    zener = np.array([5e5, 3.0, 0.02, 0.8])
    data = data_of(lambda w: FractionalZener().modulus(w, zener), WIDE, noise=0.005, seed=3)
    ranked = candidates(data)
    assert ranked[0].fit.model.id == "fractional-zener"
    assert ranked[0].held_out == min(c.held_out for c in ranked)
    assert [c.aicc for c in ranked] == sorted(c.aicc for c in ranked)
    assert ranked[0].aicc == aicc(ranked[0].fit)


def test_six_models_of_few_frequencies():
    """What the fewest frequencies allow is fitted, without a word of warning."""
    data = data_of(lambda omega: power_law(0, omega), FREQUENCY[:4], noise=0.01)
    assert {c.fit.model.id for c in candidates(data)} <= set(MODELS)
