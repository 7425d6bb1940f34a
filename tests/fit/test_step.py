"""One step of a fit: the least cost of a linearised model, however its channels are weighed."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy import optimize

from tests.fit.linear import SHARED, SIGMA, SIZE, START, LinearBench, Shop, benches_of
from wheelhop.fit import fit
from wheelhop.fit.spread import cost, cost_of, spread, weights_of
from wheelhop.fit.step import Linear, Prior, least

COUNT, SHARED_NUMBERS, OWN_NUMBERS = 200, 3, 2


def counted(powers, count=COUNT):
    return cost_of(powers, count), weights_of(powers, count)


def runs_of(seed, loud):
    """Two runs with three channels: columns (c, n, m) and residuals (c, n). Every other channel
    is so many times as loud as the noise, whatever the step."""
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(2, 3, COUNT, SHARED_NUMBERS + OWN_NUMBERS))
    residuals = (
        rng.normal(size=(2, 3, COUNT))
        * np.where(np.arange(6).reshape(2, 3) % 2, loud, 1.0)[:, :, None]
    )
    return columns, residuals + columns.sum(axis=3) * 0.5


ANYWHERE = (-np.inf, np.inf)


def linear(columns, residual, room):
    powers = (residual**2).sum(axis=1)
    return Linear(
        columns.transpose(0, 2, 1) @ columns,
        np.einsum("cnm,cn->cm", columns, residual),
        powers,
        Prior(np.eye(OWN_NUMBERS), np.full(OWN_NUMBERS, 0.3), room),
        counted(powers)[1],
        counted,
    )


def step_of(columns, residuals, room):
    """The best step within this room (2, p) of the shared and of both runs' own numbers, by the
    program and by a general minimiser of −2 ln p, which knows no weights; and what each leaves."""
    rooms = np.split(room, [SHARED_NUMBERS, SHARED_NUMBERS + OWN_NUMBERS], axis=1)
    prior = Prior(0.5 * np.eye(SHARED_NUMBERS), np.array([0.2, 0.0, -0.1]), rooms[0])

    def whole(numbers):
        shared, own = numbers[:SHARED_NUMBERS], numbers[SHARED_NUMBERS:].reshape(2, -1)
        total = prior.cost(shared)
        for j, r, o in zip(columns, residuals, own, strict=True):
            left = r - j @ np.concatenate([shared, o])
            total += cost(left.T, 1.0) + o @ o - 0.6 * o.sum()
        return total

    start = np.zeros(room.shape[1])
    best = optimize.minimize(
        whole,
        start,
        method="L-BFGS-B",
        bounds=room.T,
        options={"ftol": 1e-15, "gtol": 1e-4, "maxfun": 100_000},
    )
    runs = [linear(*run) for run in zip(columns, residuals, rooms[1:], strict=True)]
    step, own, promised = least(prior, runs, 0.0, 1e-9)
    found = np.concatenate([step, *own])
    assert promised == pytest.approx(whole(start) - whole(found), rel=1e-6)
    return found, best.x, whole(found) - whole(best.x)


@pytest.mark.parametrize("loud", [1.0, 30.0, 1000.0])
def test_no_other_step_costs_less(loud):
    room = np.tile(np.transpose([ANYWHERE]), SHARED_NUMBERS + 2 * OWN_NUMBERS)
    found, best, more = step_of(*runs_of(5, loud), room)
    assert found == pytest.approx(best, abs=2e-4)
    assert more <= 1e-6


@pytest.mark.parametrize("seed", range(8))
def test_no_other_step_within_the_bounds_costs_less(seed):
    """Numbers are told from each other badly, so what one may not do the others do in part; some
    stand at a bound already."""
    columns, residuals = runs_of(seed, 30.0)
    rng = np.random.default_rng([seed, 1])
    columns = columns + 2.0 * columns[..., [0]]
    everywhere = np.tile(np.transpose([ANYWHERE]), columns.shape[-1] + OWN_NUMBERS)
    free, _, _ = step_of(columns, residuals, everywhere)
    room = np.sort([free * rng.uniform(0.0, 2.0, free.size), -0.5 * free], axis=0)
    room[:, rng.integers(free.size)] *= 0.0
    found, best, more = step_of(columns, residuals, room)
    assert (room[0] <= found).all()
    assert (found <= room[1]).all()
    assert more <= 1e-6
    assert found == pytest.approx(best, abs=2e-3)


class TwoChannels(LinearBench):
    """A run with a noise for each of two channels."""

    band = type(LinearBench.band)(count=SIZE // 2)

    def cost(self, residual, sigma):
        return cost(residual.reshape(SIZE // 2, 2), sigma)

    def spread(self, residual, sigma):
        return np.tile(spread(residual.reshape(SIZE // 2, 2), sigma), SIZE // 2)

    counted = staticmethod(partial(counted, count=SIZE // 2))


def loud_benches():
    """Two-channel runs that the model leaves much of, in the first channel."""
    for bench in benches_of(7):
        loud = 1000.0 * SIGMA * np.random.default_rng(8).normal(size=SIZE // 2)
        measured = 30.0 * bench.measured + np.column_stack([loud, np.zeros(SIZE // 2)]).ravel()
        yield TwoChannels(bench.run, bench.matrix, measured, bench.names)


def test_a_run_costs_and_weighs_before_a_step_as_its_residual_says():
    state = fit(Shop(), START, SHARED, list(loud_benches()))
    for run in state.runs:
        found = Linear.of(run, state.model.runs[run.bench.run.id], state.sigma, even=False)
        step_cost, weights = found.after(np.zeros(found.slopes.shape[1]))
        assert step_cost == pytest.approx(run.bench.cost(run.residual, state.sigma), rel=1e-9)
        assert weights == pytest.approx(found.weights, rel=1e-9)


def test_a_linear_model_that_leaves_a_channel_much_is_fitted_in_three_steps():
    """The first finds the linear model right, the second comes to the minimum, the third confirms
    it: weights cost no simulation."""
    shop, seen = Shop(), []
    shop.watch = lambda i, error: seen.append(i)
    fit(shop, START, SHARED, list(loud_benches()))
    assert seen == [1, 2, 3]


def test_a_number_at_its_bound_does_not_lead_the_others_astray():
    """Two stiffnesses that records hardly tell apart, one of which may not be what it should: the
    first step comes to the minimum within the bounds, the second confirms it."""
    benches = list(benches_of(9))
    for bench in benches:
        bench.matrix[:, 1] += 5.0 * bench.matrix[:, 0]
        bench.measured = bench.measured + bench.matrix[:, 0] * 10.0
    shared = [replace(SHARED[0], upper=SHARED[0].mean + SHARED[0].scale), SHARED[1]]
    shop, seen = Shop(), []
    shop.watch = lambda i, error: seen.append(i)
    found = fit(shop, START, shared, benches)
    assert found.model.values["stiffness"] == shared[0].upper
    assert seen == [1, 2]
    held = START.with_values({"stiffness": shared[0].upper})
    assert found.cost == pytest.approx(fit(shop, held, shared[1:], benches).cost + 0.25, rel=1e-6)
