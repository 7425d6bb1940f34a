"""Fits recover what made the data, find the best there is, and say how sure they are."""

import numpy as np
import pytest

from tests.material.table import FREQUENCY, POWER, ROWS, data_of, power_law
from tests.material.test_models import EXAMPLES, OMEGA, examples
from wheelhop.material import (
    MODELS,
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


def test_the_ranking_of_table_3_3_is_that_of_its_parameters_not_of_its_models():
    """As printed the three rank as published. Fitted again, the two others describe the modified
    power law's own curve within the noise, so that the ranking is the optimiser's."""
    data = data_of(lambda omega: power_law(0, omega), noise=0.01, seed=2)
    printed = {
        "modified-power-law": POWER[0],
        "fractional-zener": np.array([899.72e3, 1.82, 8.2e-6, 0.19]),
        "fractional-kelvin-voigt": np.array([615.72e3, 392.49e3, 0.09]),
    }
    errors = [
        log_error(EXAMPLES[name][0].modulus(data.omega, p), data.modulus)
        for name, p in printed.items()
    ]
    assert errors == sorted(errors)
    assert errors[1] > 3 * errors[0] and errors[2] > 1.5 * errors[1]
    fitted = [fit_modulus(EXAMPLES[name][0], data).error for name in printed]
    assert max(fitted) < 1.1 * min(fitted)


@pytest.mark.parametrize("i", range(len(ROWS)))
def test_the_exact_family_of_three_parameters_is_as_good_as_the_published_form(i):
    """On the published form's own curves, where it has the advantage, within 2 % of J."""
    data = data_of(lambda omega: power_law(i, omega), noise=0.01, seed=10 + i)
    exact = min(
        fit_modulus(m, data).error for m in (FractionalKelvinVoigt(), LogarithmicPolynomial())
    )
    assert exact <= 1.02 * fit_modulus(ModifiedPowerLaw(), data).error
    assert fit_modulus(PowerLogarithm(), data).error <= exact * (1 + 1e-6)


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
