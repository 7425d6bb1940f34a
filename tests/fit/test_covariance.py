"""The covariance of what a fit says: as wide as its uncertainties, and nowhere less than noise."""

import numpy as np
import pytest

import wheelhop as wh
from tests.report.small import write_small_campaign
from wheelhop.fit.covariance import covariance_of
from wheelhop.fit.parameters import of_forces


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    campaign = wh.read(write_small_campaign(tmp_path_factory.mktemp("cov") / "c"))
    part = campaign.select("washboard-low-slow", "washboard-high-fast")
    return wh.compare(part, "dry-friction", jobs=1)


@pytest.fixture(scope="module")
def lacking(result):
    """A fit that leaves much, and scatters more than noise."""
    return result.steps[0].rung.fit


def test_its_diagonal_is_what_the_table_of_parameters_says(result):
    covariance = result.covariance()
    stated = result.parameters().loc[covariance.index, "uncertainty"]
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), stated, rtol=1e-9)


def test_it_is_a_covariance_about_as_wide_as_noise_or_wider_in_every_direction(lacking):
    unit = np.array([lacking.deviations[free.name] for free in lacking.shared])
    matrix = covariance_of(lacking) / np.outer(unit, unit)
    np.testing.assert_allclose(matrix, matrix.T, rtol=1e-9)
    size, direction = np.linalg.eigh(lacking.covariance / np.outer(unit, unit))
    along = np.einsum("ik,ij,jk->k", direction, matrix, direction)
    assert (along > 0.7 * size).all()  # to fit the table's uncertainties rows were scaled
    assert (along > 2.0 * size).any()


def test_masses_and_forces_are_known_only_together(result):
    """Records of accelerations leave their common scale open: it is as wide as it is believed."""
    fit, covariance = result.last.rung.fit, result.covariance()
    correlation = result.correlation()
    assert correlation.loc["body.mass_kg", "suspension.front.stiffness_N_m"] > 0.98
    scale = fit.of_scale * np.array([free.scale for free in fit.shared])
    named = [of_forces(free.name) != 0 for free in fit.shared]
    assert (scale != 0).tolist() == named and sum(named) > 8
    told = scale @ np.linalg.solve(covariance.to_numpy(), scale)
    assert told == pytest.approx(1.0, abs=0.1)


def test_draws_have_the_mean_and_the_covariance(result):
    draws, covariance = result.draws(4000, seed=3), result.covariance()
    deviation = np.sqrt(np.diag(covariance))
    value = result.parameters().loc[draws.columns, "value"]
    np.testing.assert_allclose((draws.mean() - value) / deviation, 0.0, atol=0.08)
    np.testing.assert_allclose(np.corrcoef(draws.T), result.correlation(), atol=0.08)
    assert result.draws(2, seed=3).equals(result.draws(2, seed=3))
    with pytest.raises(ValueError, match="one set"):
        result.draws(0)


def test_draws_stay_within_the_bounds_of_the_fit(result):
    shared, draws = result.last.rung.fit.shared, result.draws(500)
    for free in shared:
        assert draws[free.name].between(free.lower, free.upper).all()
