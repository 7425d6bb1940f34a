"""The fit of a linear model: Bayes' rule in closed form, with everything in one matrix."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from tests.fit.linear import (
    OWN,
    OWN_SCALES,
    SCALES,
    SHARED,
    SIGMA,
    SIZE,
    SPEED,
    START,
    Shop,
    benches_of,
    in_full,
)
from wheelhop.fit import Free, fit, update
from wheelhop.fit.fit import follow, foreseen


@pytest.mark.parametrize("speed", [SPEED, 0.0])
def test_numbers_precision_and_evidence_are_those_of_bayes_rule(speed):
    """What is free in a run is integrated out; of a start nobody believes anything, and no prior
    counts for more than two scales."""
    benches = benches_of(1, speed, faint=1e-3)
    design, data, prior = in_full(benches)
    precision = design.T @ design / SIGMA**2 + np.diag(prior)
    best = np.linalg.solve(precision, design.T @ data) / SIGMA**2
    found = fit(Shop(), START, SHARED, benches)
    values = [(found.model.values[f.name] - f.mean) / f.scale for f in SHARED]
    np.testing.assert_allclose(values, best[:2], atol=1e-3)
    for k, bench in enumerate(benches if speed > 0.0 else ()):
        own = found.model.runs[bench.run.id]
        mine = (np.array([own[n] for n in OWN]) - [speed, 0.0]) / OWN_SCALES
        np.testing.assert_allclose(mine, best[2 + 2 * k : 4 + 2 * k], atol=0.1)
    covariance = np.linalg.inv(precision)[:2, :2]
    np.testing.assert_allclose(np.linalg.inv(found.precision), covariance, rtol=1e-3)
    np.testing.assert_allclose(found.covariance, covariance * np.outer(SCALES, SCALES), rtol=1e-3)
    left = data - design @ best
    cost = left @ left / SIGMA**2 + best @ (prior * best)
    assert found.cost == pytest.approx(cost, rel=1e-5)
    assert found.rss == pytest.approx(left @ left, rel=1e-4)
    assert found.error == pytest.approx(np.sqrt(left @ left / (data @ data)), rel=1e-4)
    volume = np.log(np.maximum(prior, 0.25)).sum() - np.linalg.slogdet(precision)[1]
    expected = -0.5 * cost - len(data) * np.log(SIGMA) + 0.5 * volume
    assert found.evidence == pytest.approx(expected, abs=0.01)
    if speed == 0.0:
        spread = design @ np.diag(1.0 / prior) @ design.T + SIGMA**2 * np.eye(len(data))
        density = stats.multivariate_normal(cov=spread).logpdf(data)
        constant = 0.5 * len(data) * np.log(2.0 * np.pi)
        assert found.evidence == pytest.approx(density + constant, abs=1e-3)


def test_the_noise_nobody_states_is_the_mean_square_per_degree_of_freedom():
    benches = benches_of(2, count=8)
    found = fit(Shop(noise=0.0), START, SHARED, benches)
    free = len(SHARED) + 2 * len(benches)
    assert found.sigma**2 == pytest.approx(found.rss / (found.size - free))
    assert found.sigma == pytest.approx(SIGMA, rel=0.1)
    stated = fit(Shop(), START, SHARED, benches)
    assert stated.sigma == SIGMA


@pytest.mark.parametrize("count", [2, 3])
def test_runs_that_share_nothing_are_fitted_each_by_itself(count):
    """One fit of three is three fits of one: costs and volumes add up, and the noise is that of all
    of them."""
    benches = benches_of(3, count=count)
    benches[1].measured = 3.0 * benches[1].measured
    for noise in (SIGMA, 0.0):
        together = fit(Shop(noise), START, (), benches)
        alone = [fit(Shop(noise), START, (), [bench]) for bench in benches]
        assert together.cost == pytest.approx(sum(one.cost for one in alone))
        assert together.log_volume == pytest.approx(sum(one.log_volume for one in alone))
        assert together.sigma == pytest.approx(np.sqrt(np.mean([one.sigma**2 for one in alone])))
        assert [run.bench for run in together.runs] == benches
        for bench, one in zip(benches, alone, strict=True):
            assert together.model.runs[bench.run.id] == one.model.runs[bench.run.id]
        assert together.model.values == START.values


def test_what_a_fit_left_uncertain_is_believed_of_other_runs():
    """Two runs after three are five at once: numbers, precision, evidence."""
    benches = benches_of(4, count=5)
    everything = fit(Shop(), START, SHARED, benches)
    first = fit(Shop(), START, SHARED, benches[:3])
    then = update(Shop(), first, first.model, benches[3:])
    for free in SHARED:
        assert then.model.values[free.name] == pytest.approx(everything.model.values[free.name])
    np.testing.assert_allclose(then.precision, everything.precision, rtol=1e-4)
    assert first.evidence + then.evidence == pytest.approx(everything.evidence, abs=1e-2)


def test_derivatives_of_a_similar_model_are_not_taken_again():
    """Whatever the order of the numbers; only of what the other model lacked are they new, and
    there is one copy of them in memory, however many models borrow them."""
    names = ("stiffness", "mass", "extra")
    more = (Free("extra", 0.0, np.inf, 2.0), *reversed(SHARED))
    benches = benches_of(5, names=names)
    known = fit(Shop(), START, SHARED, benches)
    plain = fit(Shop(), START, more, benches)
    for bench in benches:
        bench.simulated = bench.asked = 0
    borrowed = fit(Shop(), START, more, benches, known)
    assert all(bench.simulated == bench.asked > 0 for bench in benches)  # one number each time
    for free in more:
        assert borrowed.model.values[free.name] == pytest.approx(plain.model.values[free.name])
    np.testing.assert_allclose(borrowed.precision, plain.precision, rtol=1e-4)
    for bench in benches:
        assert borrowed.model.runs[bench.run.id] == pytest.approx(plain.model.runs[bench.run.id])
    for run, owner in zip(borrowed.runs, known.runs, strict=True):
        _, *shared = run.derivatives.columns
        assert {id(column) for column in shared} == {id(c) for c in owner.derivatives.columns}


def test_runs_nobody_has_driven_tell_as_much_as_those_that_leave_the_noise():
    """Whatever stands in their records: the precision is that of their derivatives."""
    benches = benches_of(6)
    driven = fit(Shop(), START, SHARED, benches)
    for bench in benches:
        bench.measured = np.zeros(SIZE)
    planned = foreseen(Shop(), driven.model, SHARED, benches)
    np.testing.assert_allclose(planned.precision, driven.precision, rtol=1e-5)
    assert planned.rss == 0.0
    assert planned.model.values == driven.model.values


def test_what_a_run_leaves_free_follows_the_shared_numbers():
    """To where it is best for what they are now, its own priors counted."""
    benches = benches_of(7)
    found = fit(Shop(), START, SHARED, benches)
    moved = {f.name: found.model.values[f.name] + 7.0 * f.scale for f in SHARED}
    shifted = replace(found, model=found.model.with_values(moved))
    followed = follow(Shop(), found.model, shifted, benches)
    assert followed.values == shifted.model.values
    best = fit(Shop(), shifted.model, (), benches).model
    for bench in benches:
        run = bench.run.id
        assert followed.runs[run] == pytest.approx(best.runs[run], abs=1e-5)
        assert followed.runs[run] != pytest.approx(found.model.runs[run], abs=1e-3)


def test_numbers_end_at_their_bounds():
    """What the data would have beyond stays at the bound, exactly."""
    benches = benches_of(8)
    free = fit(Shop(), START, SHARED, benches).model.values
    for sign, side in ((1.0, "upper"), (-1.0, "lower")):
        bound = free["mass"] - sign * 0.1
        held = replace(SHARED[1], **{side: bound})
        found = fit(Shop(), START, (SHARED[0], held), benches)
        assert found.model.values["mass"] == bound


def test_what_lies_beyond_a_bound_is_how_much_further_a_fit_would_go():
    """One undamped step leads there, whatever the bounds have cut off; without bounds, nowhere."""
    benches = benches_of(8, 0.0)
    free = fit(Shop(), START, SHARED, benches)
    held = replace(SHARED[1], upper=free.model.values["mass"] - 0.3)
    found = fit(Shop(), START, (SHARED[0], held), benches)
    for name, value in free.model.values.items():
        if name in found.ahead:
            assert found.model.values[name] + found.ahead[name] == pytest.approx(value, rel=1e-4)
            assert free.ahead[name] == pytest.approx(0.0, abs=1e-3 * abs(value))
    assert found.ahead["mass"] == pytest.approx(0.3, rel=1e-2)


def test_a_number_that_nothing_depends_on_stays_as_believed():
    """It is known to a thousand of its scales, which is next to nothing."""
    for bench in (benches := benches_of(9, names=("stiffness", "mass", "extra"))):
        bench.matrix[:, 2] = 0.0
    useless = Free("extra", 1.5, np.inf, 2.0)
    start = START.with_values({"extra": 1.5})
    found = fit(Shop(), start, (*SHARED, useless), benches)
    assert found.model.values["extra"] == 1.5
    assert np.sqrt(found.covariance[2, 2]) == pytest.approx(1000.0 * useless.scale)
    plain = fit(Shop(), start, SHARED, benches)
    for free in SHARED:
        assert found.model.values[free.name] == pytest.approx(plain.model.values[free.name])


def test_what_only_the_priors_hold_ends_where_they_say():
    """Loud runs that show nothing but a ratio, as accelerations do of masses and forces, and a
    start from which both numbers have to fall: a damped step goes a hundred-thousandth of the way
    (blind seed 13407: all masses stayed 11 % heavy, a cost of 11 above the least)."""
    benches = benches_of(4, count=3)
    for bench in benches:
        bench.matrix[:, 1] = -bench.matrix[:, 0]
        bench.matrix *= 100.0
        bench.measured = bench.matrix @ np.array([0.5, -0.5, 0.1, 0.1])
    begun = START.with_values({f.name: f.mean + 3.0 * f.scale for f in SHARED})
    found = fit(Shop(), begun, SHARED, benches)
    design, data, prior = in_full(benches)
    best = (
        np.linalg.solve(design.T @ design / SIGMA**2 + np.diag(prior), design.T @ data) / SIGMA**2
    )
    values = [(found.model.values[f.name] - f.mean) / f.scale for f in SHARED]
    np.testing.assert_allclose(values, best[:2], atol=0.1)
