"""What a fit says of its own uncertainty is how its numbers scatter, whatever the model leaves."""

from types import SimpleNamespace

import numpy as np
import pytest

from wheelhop.compare.band import InBand
from wheelhop.fit import Fit, RunFit
from wheelhop.fit.parameters import Free
from wheelhop.fit.result import Derivatives
from wheelhop.simulate import Model

SAMPLES, RUNS, RATE_HZ, SIGMA = 1024, 12, 100.0, 0.1
BAND = InBand(SAMPLES, RATE_HZ, (0.5, 30.0))
BLOCK = 50  # samples: half a second
FREE = Free("body.mass_kg", mean=100.0, sigma=np.inf, scale=10.0)


def fitted(rng, astray):
    """A straight line through runs of one number, fitted; what is measured departs from it by noise
    and, half-second by half-second, by a share `astray` of what the number does."""
    columns = [BAND.coefficients(rng.normal(size=SAMPLES)) for _ in range(RUNS)]
    measured = []
    for column in columns:
        share = np.repeat(astray * rng.normal(size=SAMPLES // BLOCK + 1), BLOCK)[:SAMPLES]
        wrong = BAND.coefficients(share * BAND.from_coefficients(column))
        measured.append(wrong + SIGMA * rng.normal(size=len(column)))
    square = sum(c @ c for c in columns)
    best = sum(c @ y for c, y in zip(columns, measured, strict=True)) / square
    runs = []
    for i, (column, y) in enumerate(zip(columns, measured, strict=True)):
        run = SimpleNamespace(id=str(i), time_s=np.arange(SAMPLES) / RATE_HZ)
        bench = SimpleNamespace(run=run, band=BAND, size=len(y))
        kept = Derivatives([column], 1)
        runs.append(RunFit(bench, (), y - best * column, kept, np.ones(len(y))))
    precision = np.array([[square / SIGMA**2]])
    model = Model({FREE.name: FREE.scale * best}, ())
    return Fit(model, (FREE,), tuple(runs), precision, SIGMA, 0.0, 0.0)


@pytest.mark.parametrize("astray", [0.0, 0.05, 0.3])
def test_numbers_scatter_as_they_are_said_to(astray):
    rng = np.random.default_rng(3)
    fits = [fitted(rng, astray) for _ in range(60)]
    scatter = np.std([f.model.values[FREE.name] for f in fits])
    said = np.sqrt(np.mean([f.uncertainty(FREE.name) ** 2 for f in fits]))
    assert said == pytest.approx(scatter, rel=0.25)
    white = np.sqrt(np.mean([f.covariance[0, 0] for f in fits]))
    assert said >= white
    assert astray < 0.3 or said > 3.0 * white


def test_what_runs_share_with_their_own_numbers_is_not_known_twice():
    """A number of the run that does the same leaves nothing to tell the shared one by."""
    fit = fitted(np.random.default_rng(4), 0.3)
    twice = [
        RunFit(r.bench, (FREE,), r.residual, Derivatives([*r.derivatives.columns] * 2, 1), r.spread)
        for r in fit.runs
    ]
    assert max(abs(run.followed()).max() for run in twice) < 1e-12
