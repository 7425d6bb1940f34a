"""The steps of a fit: how many there are, how far they go and what they cost."""

import numpy as np
import pytest

from tests.fit.linear import SHARED, SIGMA, START, LinearBench, Shop, benches_of
from wheelhop.fit import Free, fit

ONE = (Free("stiffness", 100.0, np.inf, 10.0),)
"""A number of which nothing is believed beforehand."""


def single(law=None, steepness=1.0, begin=0.0, truth=1.0):
    """One run that tells one number: bent by a law, with derivatives that exaggerate."""
    (bench,) = benches_of(1, 0.0, count=1, names=("stiffness",), noise=0.0)
    bench.law, bench.steepness = law or bench.law, steepness
    bench.measured = bench.matrix @ bench.law(np.array([truth]))
    return bench, START.with_values({"stiffness": 100.0 + 10.0 * begin})


def watched(bench, model, shared=ONE, **given):
    """The fit, and what it said of itself at every step: which one, the error, and how many
    simulations the derivatives had cost by then."""
    shop, seen = Shop(), []
    shop.watch = lambda i, error: seen.append((i, error, bench.simulated))
    return fit(shop, model, shared, [bench], **given), seen


def test_a_linear_model_is_fitted_in_two_steps_with_one_set_of_derivatives():
    """The second only confirms. Who watches sees the error before each of them."""
    benches = benches_of(2)
    found, seen = watched(benches[0], START, SHARED)
    assert [i for i, _, _ in seen] == [1, 2]
    assert {simulated for _, _, simulated in seen} == {4}
    _, quiet = watched(benches[0], START, ())  # where a run stands on its track is no news
    assert quiet == []
    left = benches[0].residual(START, {})
    assert seen[0][1] == pytest.approx(np.sqrt(left @ left / benches[0].energy))
    assert seen[1][1] == pytest.approx(found.error, rel=1e-3)


@pytest.mark.parametrize(("share", "steps"), [(1.5e-4, 60), (0.8e-4, 2)])
def test_a_step_that_gains_a_ten_thousandth_is_the_last(share, steps):
    """Derivatives k times too large make steps k times too small: each takes 2/k of the cost, and
    promises all of it. One that takes too little is the last but an undamped one. After sixty steps
    there is an end."""
    found, seen = watched(*single(steepness=2.0 / share))
    assert len(seen) == steps
    error = (1.0 - share / 2.0) ** steps
    assert found.error == pytest.approx(error, rel=1e-4)


@pytest.mark.parametrize(("share", "goes_on"), [(4e-3, True), (2e-3, False)])
def test_with_borrowed_derivatives_a_third_of_a_percent_is_enough(share, goes_on):
    bench, model = single(steepness=2.0 / share)
    known, _ = watched(bench, model)
    _, seen = watched(bench, model, known=known)
    assert (len(seen) > 1) is goes_on


def test_what_is_small_beside_the_noise_is_no_gain():
    """A tenth of the noise is left to begin with: whatever a step takes of it, it is the last."""
    bench, model = single()
    left = bench.residual(model, {})
    bench.measured = bench.measured - left + 1e-3 * SIGMA * left
    _, seen = watched(bench, model)
    assert len(seen) == 1


@pytest.mark.parametrize(("share", "renewed"), [(0.35, False), (0.25, True)])
def test_derivatives_serve_as_long_as_steps_gain_three_tenths(share, renewed):
    bench, model = single(steepness=1.0 / (1.0 - np.sqrt(1.0 - share)), truth=1e3)
    _, seen = watched(bench, model)
    assert [simulated for _, _, simulated in seen[:3]] == ([1, 2, 3] if renewed else [1, 1, 1])


@pytest.mark.parametrize(("noise", "renewed"), [(SIGMA, False), (SIGMA / 1.4, True), (0.0, True)])
def test_near_the_noise_derivatives_are_renewed_where_they_misled(noise, renewed):
    """One of three runs is wavy, and a little out of place; the derivatives of the others are right
    from the first time on. Where more than the noise is left, or it is not known, all are
    renewed."""
    benches = benches_of(6)
    wavy, *straight = benches
    there = fit(Shop(), START, SHARED, benches).model
    flat, run = wavy.record(there), wavy.run.id
    wavy.law = lambda x: x + 0.02 * np.sin(40.0 * x)
    wavy.measured = wavy.measured + wavy.record(there) - flat
    for bench in benches:
        bench.asked = 0
    away = there.with_run(run, {"speed_m_s": there.runs[run]["speed_m_s"] + 2e-4})
    found = fit(Shop(noise), away, SHARED, benches)
    assert wavy.asked > 1
    assert [bench.asked for bench in straight] == [wavy.asked if renewed else 1] * 2
    assert found.rss / found.size < 1.2 * SIGMA**2


@pytest.mark.parametrize(("bar", "steps"), [(0.7, 2), (0.81, 60), (-np.inf, 60)])
def test_a_fit_ends_when_ten_steps_as_good_as_the_last_would_not_do(bar, steps):
    """Each of sixty takes 2 % of the cost. The second gains no
    more than the first, and ten more like it would lead to 78 %."""
    bench, model = single(steepness=100.0, truth=1e3)
    start = float(bench.residual(model, {}) @ bench.residual(model, {})) / SIGMA**2
    found, seen = watched(bench, model, bar=bar * start + 2.0 * bench.size * np.log(SIGMA))
    assert len(seen) == steps
    assert found.cost == pytest.approx(start * 0.99 ** (2 * steps), rel=1e-3)


def test_a_step_too_far_is_made_shorter_until_it_helps():
    """Newton's iteration for arctan x = 0.1 runs away from where |x| > 1.39."""
    bench, model = single(np.arctan, begin=3.0, truth=0.1)
    found, seen = watched(bench, model)
    assert found.model.values["stiffness"] == pytest.approx(101.0, abs=0.1)
    errors = [error for _, error, _ in seen]
    assert errors == sorted(errors, reverse=True) and len(seen) < 15


def test_a_model_that_runs_away_is_a_step_too_far():
    """Beyond 1.5 it leaves infinitely much."""
    bench, model = single(lambda x: np.where(x < 1.5, x, np.inf), steepness=0.6)
    found, _ = watched(bench, model)
    assert found.model.values["stiffness"] == pytest.approx(110.0, abs=0.1)


def test_a_fit_that_no_step_helps_gives_up():
    """Derivatives of the wrong sign: eight times as careful each time, from a thousandth of the
    model's own resistance to more than all of it."""
    bench, model = single(steepness=-1.0)
    found, seen = watched(bench, model)
    assert len(seen) == 5
    assert bench.simulated == 1
    assert found.model.values == model.values


class Turning(LinearBench):
    """A run whose derivatives have the wrong sign from the fourth time on."""

    @property
    def steepness(self):
        return 10.0 if self.asked < 4 else -1.0

    @steepness.setter
    def steepness(self, value):
        pass


def test_a_fit_that_no_further_step_helps_gives_up():
    """After each good one it is ten times less careful; then eight times as careful each time."""
    bench, model = single(truth=1e3)
    _, seen = watched(Turning(bench.run, bench.matrix, bench.measured, bench.names), model)
    assert [simulated for _, _, simulated in seen] == [1, 2, 3] + 8 * [4]


def test_what_promises_nothing_is_tried_once():
    """Where the fit has ended its derivatives promise no more, though they exaggerate and a step
    along them does harm: none is made shorter."""
    bench, model = single(steepness=0.4, begin=0.999)
    _, seen = watched(bench, model)
    assert len(seen) == 1


def test_a_fit_that_begins_at_its_end_ends_at_once():
    _, seen = watched(*single(begin=1.0))
    assert len(seen) == 1


def test_a_number_along_which_no_stable_model_lies_stays():
    (bench,) = benches_of(3, 0.0, count=1)
    bench.law = lambda x: np.where(np.abs(x[1]) > 0.0, np.inf, x)
    found, _ = watched(bench, START, SHARED)
    assert found.model.values["mass"] == START.values["mass"]
    alone, _ = watched(bench, START, SHARED[:1])
    assert found.model.values["stiffness"] == pytest.approx(alone.model.values["stiffness"])


def test_a_number_that_shows_nothing_yet_stays_where_it_began():
    """Such as the shape of an effect that is absent; what is believed of it does not move it."""
    (bench,) = benches_of(4, count=1)
    bench.matrix[:, 2] = 0.0
    run = bench.run.id
    found, _ = watched(bench, START.with_run(run, {"speed_m_s": 4.1}), SHARED)
    assert found.model.runs[run]["speed_m_s"] == 4.1
    other, _ = watched(bench, START, SHARED)
    assert found.cost - other.cost == pytest.approx((0.1 / 0.24) ** 2, abs=1e-3)


def test_where_a_fit_begins_does_not_matter_to_where_it_ends():
    """Shared numbers and a run's own, told by data and belief about alike."""
    benches = benches_of(5, faint=1e-3)
    away = START.with_values({"stiffness": 140.0, "mass": 4.0})
    for bench in benches:
        away = away.with_run(bench.run.id, {"speed_m_s": 4.9, "start_m": 0.2})
    one, other = (fit(Shop(), model, SHARED, benches) for model in (START, away))
    for free in SHARED:
        apart = one.model.values[free.name] - other.model.values[free.name]
        assert abs(apart) < 1e-2 * free.scale
    for bench in benches:
        assert one.model.runs[bench.run.id] == pytest.approx(
            other.model.runs[bench.run.id], abs=1e-2
        )
    assert one.cost == pytest.approx(other.cost, abs=0.02)
