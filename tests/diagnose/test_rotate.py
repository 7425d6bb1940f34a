"""A run that a fit leaves out: to first order, against the fit that is made without it."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.diagnose.test_score import fit_of, rung
from wheelhop.compare.band import InBand
from wheelhop.diagnose.left_out import PARTS, left_out
from wheelhop.diagnose.score import Rung, log_odds, p_value
from wheelhop.fit import Fit, Free, RunFit
from wheelhop.fit.result import Derivatives

SHARED = 3
SIZE, RUNS, NOISE = 40, 5, 0.7


def free(name, sigma):
    return Free(name, 0.0, sigma, 1.0)


def solved(designs, data, own_sigmas):
    """Shared numbers (3,), all own ones, and the shared ones' precision: of a linear problem in one
    least-squares system, beliefs as further rows."""
    own = len(own_sigmas)
    width = SHARED + own * len(designs)
    rows, right = [np.eye(width)[:SHARED] / 2.0], [np.zeros(SHARED)]
    for k, (design, datum) in enumerate(zip(designs, data, strict=True)):
        part = np.zeros((SIZE, width))
        part[:, :SHARED] = design[:, :SHARED]
        here = slice(SHARED + k * own, SHARED + (k + 1) * own)
        part[:, here] = design[:, SHARED:]
        rows += [part / NOISE, np.eye(width)[here] / np.array(own_sigmas)[:, None]]
        right += [datum / NOISE, np.zeros(own)]
    matrix = np.vstack(rows)
    x = np.linalg.lstsq(matrix, np.concatenate(right), rcond=None)[0]
    covariance = np.linalg.inv(matrix.T @ matrix)[:SHARED, :SHARED]
    return x, np.linalg.inv(covariance)


@given(st.integers(0, 10_000), st.lists(st.floats(0.1, 10.0), max_size=2))
def test_left_out_as_a_fit_without_the_run(seed, own_sigmas):
    """A linear model: exact. What is free in the run follows what the others say of the rest."""
    rng, own = np.random.default_rng(seed), len(own_sigmas)
    designs = [rng.normal(size=(SIZE, SHARED + own)) for _ in range(RUNS)]
    data = [rng.normal(size=SIZE) + design @ np.ones(SHARED + own) for design in designs]
    x, precision = solved(designs, data, own_sigmas)
    names = tuple(free(f"own{i}", s) for i, s in enumerate(own_sigmas))
    runs = []
    for k, (design, datum) in enumerate(zip(designs, data, strict=True)):
        mine = x[SHARED + k * own : SHARED + (k + 1) * own]
        residual = datum - design @ np.concatenate([x[:SHARED], mine])
        runs.append(RunFit(None, names, residual, Derivatives(design.T, SHARED), np.ones(SIZE)))
    shared = tuple(free(f"shared{i}", 2.0) for i in range(SHARED))
    fit = Fit(None, shared, tuple(runs), precision, NOISE, 0.0, 0.0)
    for k, run in enumerate(left_out(fit)):
        others = [i for i in range(RUNS) if i != k]
        without, _ = solved([designs[i] for i in others], [data[i] for i in others], own_sigmas)
        foreseen = data[k] - designs[k][:, :SHARED] @ without[:SHARED]
        weights = np.diag(NOISE**2 / np.array(own_sigmas) ** 2) if own else np.zeros((0, 0))
        mine = designs[k][:, SHARED:]
        best = np.linalg.solve(mine.T @ mine + weights, mine.T @ foreseen)
        assert run.residual == pytest.approx(foreseen - mine @ best, rel=1e-3, abs=1e-4)


@given(st.integers(0, 10_000), st.lists(st.floats(0.1, 10.0), max_size=2))
def test_a_single_run_is_foreseen_part_by_part(seed, own_sigmas):
    """A linear model: exact. Every part as a fit to the others, own numbers included, has it."""
    rng, own = np.random.default_rng(seed), len(own_sigmas)
    band = InBand(200, 100.0, (1.0, 40.0))
    width = SHARED + own
    design = rng.normal(size=(2 * band.count, width))
    datum = rng.normal(size=2 * band.count) + design @ np.ones(width)
    sigmas = np.array([2.0] * SHARED + own_sigmas)

    def in_time(columns):
        return band.from_coefficients(columns.reshape(band.count, -1)).reshape(band.n * 2, -1)

    def solved_by(rows):
        matrix = np.vstack([in_time(design)[rows] / NOISE, np.diag(1.0 / sigmas)])
        right = np.concatenate([in_time(datum[:, None])[rows, 0] / NOISE, np.zeros(width)])
        return np.linalg.lstsq(matrix, right, rcond=None)[0], matrix.T @ matrix

    every = np.arange(2 * band.n)
    x, precision = solved_by(every)
    residual = datum - design @ x
    names = tuple(free(f"own{i}", s) for i, s in enumerate(own_sigmas))
    bench = SimpleNamespace(band=band, size=2 * band.count)
    run = RunFit(bench, names, residual, Derivatives(design.T, SHARED), np.ones(len(datum)))
    shared = tuple(free(f"shared{i}", 2.0) for i in range(SHARED))
    eliminated = np.linalg.inv(np.linalg.inv(precision)[:SHARED, :SHARED])
    fit = Fit(None, shared, (run,), eliminated, NOISE, 0.0, 0.0)
    expected = np.empty(2 * band.n)
    for part in np.array_split(every.reshape(band.n, 2), PARTS):
        without, _ = solved_by(np.setdiff1d(every, part.ravel()))
        rows = part.ravel()
        expected[rows] = in_time(datum[:, None])[rows, 0] - in_time(design)[rows] @ without
    expected = band.coefficients(expected.reshape(band.n, 2)).ravel()
    (found,) = left_out(fit)
    assert found.residual == pytest.approx(expected, rel=1e-3, abs=1e-3)


def test_a_number_that_one_run_alone_tells_is_not_foreseen():
    """Without that run nothing but the belief says what it is: the run is left as unexplained."""
    datum = np.full(SIZE, 1.0)
    design = np.zeros((SIZE, 1))
    others = RunFit(None, (), np.zeros(SIZE), Derivatives(design.T, 1), np.ones(SIZE))
    # Of the number nothing is believed: the run has explained itself to the last.
    alone = RunFit(None, (), datum * 1e-6, Derivatives(design.T + 1.0, 1), np.ones(SIZE))
    told = np.array([[SIZE * (1.0 + 1e-6)]])
    fit = Fit(None, (free("x", 1e3),), (alone, others), told, 1.0, 0.0, 0.0)
    assert left_out(fit)[0].residual == pytest.approx(datum, rel=0.05)
    assert np.all(left_out(fit)[1].residual == 0.0)


def test_fitted_runs_judge_where_few_are_held_out():
    """Two models, one of them better everywhere: one run held out can't say so with any certainty;
    the fitted ones can."""
    rng = np.random.default_rng(4)
    fitted, held_out = ([rng.normal(size=(1024, 2)) for _ in range(number)] for number in (4, 1))

    def of(size, signals):
        return rung([size * signal for signal in signals]).validation

    base, rival = (Rung(of(size, fitted), of(size, held_out)) for size in (1.0, 0.8))
    alone = [Rung(fit_of(()), r.validation) for r in (base, rival)]
    assert p_value(log_odds(*alone), 27) > 0.05
    assert p_value(log_odds(base, rival), 27) < 1e-4


@pytest.mark.parametrize(("blocks", "expected"), [(25, 0.0), (24, 40.0)])
def test_half_a_second_less_and_the_fitted_runs_judge_too(blocks, expected):
    """Nothing is gained on the run held out; in all of 80 half-seconds of the others the same is,
    half of which counts."""
    rng = np.random.default_rng(5)
    signals = [rng.normal(size=(1024, 2)) for _ in range(4)]
    (one,) = rung(signals[:1]).validation.runs
    one.bench.run.time_s = np.array([0.0, 0.5 * blocks])
    held_out = fit_of([one])
    base, rival = (
        Rung(rung([size * signal for signal in signals]).validation, held_out)
        for size in (1.0, 0.5)
    )
    assert log_odds(base, rival) == pytest.approx(expected, rel=1e-9)
