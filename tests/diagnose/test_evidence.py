"""What runs held out say of a model in which something may still move."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from tests.diagnose.test_score import RUNS, fit_of, leaving, noise, rung
from wheelhop.diagnose.score import Rung, log_odds
from wheelhop.fit import Fit, Free, RunFit
from wheelhop.simulate import Model


def test_evidence_of_runs_held_out_is_added_to_that_of_the_runs_fitted():
    """The chain rule; where numbers that runs share moved on, that is the evidence that counts."""
    fitted, held_out, moved = (replace(leaving(p).judging, log_volume=p) for p in (1.0, 2.0, 3.0))
    assert Rung(fitted, None).evidence == fitted.evidence
    assert Rung(fitted, held_out).evidence == fitted.evidence + held_out.evidence
    assert Rung(fitted, held_out, moved).evidence == fitted.evidence + moved.evidence


def test_a_model_knows_what_every_run_left_free():
    fitted, held_out = (
        replace(leaving(1.0).fit, model=Model({"x": x}, (), {name: {"start_m": x}}, {name: x}))
        for name, x in (("fitted", 1.0), ("held out", 2.0))
    )
    assert Rung(fitted, None).model == fitted.model
    both = Rung(fitted, held_out).model
    assert both.values == {"x": 1.0}  # what runs share is as the fitted ones have it
    assert both.runs == {"fitted": {"start_m": 1.0}, "held out": {"start_m": 2.0}}
    assert both.heights == {"fitted": 1.0, "held out": 2.0}


@pytest.mark.parametrize("known", [0.3, 3.0])
def test_numbers_that_may_still_move_are_integrated_out(known):
    """A shared number that the fitted runs tell to `known` of its scale: the odds are those of the
    densities that the two models foresee for the data, the number's own spread in one of them."""
    rng, size, sigma, scale, mean = np.random.default_rng(19), 200, 0.5, 4.0, 7.0
    column = rng.normal(size=size)  # of the data per scale of the number
    data = column * known * rng.normal() + sigma * rng.normal(size=size)
    free, prior = Free("x", 0.0, np.inf, scale), 1.0 / known**2
    precision = column @ column / sigma**2 + prior
    best = column @ data / sigma**2 / precision

    def of(value, residual, told):
        run = RunFit(SimpleNamespace(size=size), (), residual, None, np.ones(size))
        model = Model({"x": value}, ())
        return Fit(model, (free,), (run,), np.array([[told]]), sigma, 0.0, 0.0)

    before = of(mean, np.zeros(size), prior)
    after = of(mean + scale * best, data - column * best, precision)
    base, rival = Rung(before, of(mean, data, prior)), Rung(before, before, after)
    spread = [sigma**2 * np.eye(size) + s * np.outer(column, column) for s in (0.0, known**2)]
    plain, moving = (stats.multivariate_normal(cov=cov).logpdf(data) for cov in spread)
    assert log_odds(base, rival, sigma) == pytest.approx(moving - plain, rel=1e-6)


def test_numbers_that_follow_the_noise_of_a_run_are_no_odds():
    """Sixty of each run's directions are taken out of noise by as many numbers of its own: what is
    left, charged, is what it was, to two standard deviations of chance."""
    base = rung(noise(np.random.default_rng(20)), own=0)
    taken = 60
    spared = [
        replace(
            run, own=(None,) * taken, residual=np.where(np.arange(size) < taken, 0.0, run.residual)
        )
        for run in base.judging.runs
        for size in [run.bench.size]
    ]
    rival = Rung(base.fit, fit_of(spared))
    assert abs(log_odds(base, rival, 1.0)) < 2.0 * np.sqrt(2.0 * taken * RUNS) / 2.0
