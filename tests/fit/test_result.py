"""What a fitted run says of itself: weights, charges, and how well its own numbers are known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.fit.linear import OWN, OWN_SCALES, OWN_SIGMAS, SHARED, SIGMA, SIZE, START, Shop
from tests.fit.linear import benches_of as made
from wheelhop.compare.band import InBand
from wheelhop.fit import RunFit, fit
from wheelhop.fit.result import Derivatives, kept


@pytest.fixture(scope="module")
def fitted():
    return fit(Shop(), START, SHARED, made(1, faint=1e-3))


def test_a_runs_own_numbers_are_as_uncertain_as_data_and_belief_leave_them(fitted):
    """What runs share held fixed; of the start nothing is believed."""
    for run in fitted.runs:
        columns = run.bench.matrix[:, 2:]
        precision = columns.T @ columns / SIGMA**2 + np.diag((OWN_SCALES / OWN_SIGMAS) ** 2)
        expected = OWN_SCALES * np.sqrt(np.diag(np.linalg.inv(precision)))
        found = run.uncertainties(SIGMA)
        assert found == pytest.approx(dict(zip(OWN, expected, strict=True)), rel=1e-4)


def test_heights_that_take_up_a_number_leave_it_less_certain(fitted):
    """They leave a quarter of what it does: its deviation doubles."""
    (run, *_) = fitted.runs
    half = SimpleNamespace(freed=lambda columns: 0.25 * columns, freedom=0.0)
    plain, rough = (r.uncertainties(SIGMA)["start_m"] for r in (run, replace(run, heights=half)))
    assert rough == pytest.approx(2.0 * plain, rel=1e-3)


def test_of_a_number_that_no_datum_tells_the_belief_is_left(fitted):
    (run, *_) = fitted.runs
    blind = replace(run, derivatives=Derivatives(np.zeros((4, SIZE)), 2))
    assert blind.uncertainties(SIGMA)["speed_m_s"] == pytest.approx(OWN_SIGMAS[0])


@pytest.mark.parametrize("absurd", [np.inf, np.nan, 1e300])
def test_no_way_leads_to_a_model_that_runs_away(absurd):
    """Nor to one whose derivatives are larger than the numbers that keep them."""
    columns = np.array([[1.0, absurd, -2.0], [1.0, 3.0, -2.0]])
    np.testing.assert_array_equal(kept(columns), [np.zeros(3), columns[1]])


def test_an_uncertain_datum_weighs_less(fitted):
    (run, *_) = fitted.runs
    spread = np.linspace(1.0, 4.0, SIZE)
    doubted = replace(run, spread=spread)
    np.testing.assert_allclose(doubted.surprise * spread, run.residual)
    np.testing.assert_allclose(doubted.weighed * spread[:, None], run.jacobian)
    np.testing.assert_array_equal(doubted.residual, run.residual)


def test_heights_are_put_back_into_the_data(fitted):
    (run, *_) = fitted.runs
    share = np.linspace(0.0, 1.0, SIZE)
    rough = replace(run, heights=SimpleNamespace(contribution=lambda: share, freedom=12.0))
    np.testing.assert_allclose(rough.data - share, run.residual)
    np.testing.assert_array_equal(run.data, run.residual)
    assert rough.freedom == run.freedom + 12.0 == 14.0
    assert rough.spare == pytest.approx((SIZE - 14.0) / SIZE)
    assert rough.charged == pytest.approx(run.rss * SIZE / (SIZE - 14.0))


def test_one_datum_is_left_at_least(fitted):
    """Where a run has more numbers than data."""
    (run, *_) = fitted.runs
    assert replace(run, own=run.own * SIZE).spare == pytest.approx(1.0 / SIZE)


def test_a_residual_in_time_has_its_channels_side_by_side():
    """Each with the power it has in band."""
    band = InBand(256, 100.0, (1.0, 30.0))
    signals = band.signal(np.random.default_rng(1).normal(size=(256, 3)) * [1.0, 10.0, 100.0])
    bench = SimpleNamespace(band=band)
    run = RunFit(bench, (), band.coefficients(signals).ravel(), None, np.ones(3 * band.count))
    np.testing.assert_allclose(run.in_time(run.residual), signals, atol=1e-9)


@pytest.mark.parametrize(("seconds", "blocks"), [(0.1, 1), (0.7, 1), (0.8, 2), (10.0, 20)])
def test_half_a_second_is_a_block_whenever_the_record_began(seconds, blocks):
    for begin in (0.0, 7.3):
        bench = SimpleNamespace(run=SimpleNamespace(time_s=begin + np.linspace(0.0, seconds, 5)))
        assert RunFit(bench, (), np.zeros(1), None, np.ones(1)).blocks == blocks
