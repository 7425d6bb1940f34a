"""What a fit says of its own uncertainty is how its numbers scatter, whatever the model leaves."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

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


HEAVY = Free("body.mass_kg", mean=100.0, sigma=10.0, scale=10.0)
STIFF = Free("suspension.front.stiffness_N_m", mean=4e4, sigma=4e3, scale=4e3)
LONG = Free("geometry.wheelbase_m", mean=1.4, sigma=0.1, scale=0.1)


def told(free, drive, given=None):
    """Relative standard deviations where derivatives with an error make all numbers known to one
    part in a million."""
    values = {f.name: f.mean for f in free}
    shared, bench = tuple(free), SimpleNamespace(measures_force=drive == "rig")
    run = SimpleNamespace(
        bench=bench,
        followed=lambda: np.zeros((1, len(free))),
        by_block=lambda columns: np.zeros((1, len(free))),
    )
    model = Model({**values, **(given or {})}, ())
    fit = Fit(model, shared, (run,), 1e12 * np.eye(len(free)), SIGMA, 0.0, 0.0)
    return [fit.uncertainty(f.name) / f.mean for f in free]


def test_masses_and_forces_are_known_as_well_as_their_common_scale():
    """Two numbers believed to a tenth tell it to a tenth over √2; a length is no force, and what
    stands in vehicle.toml for a driver who moves with the body moves nothing."""
    mass, stiffness, length = told([HEAVY, STIFF, LONG], "road", {"driver.mass_kg": 75.0})
    assert [mass, stiffness] == pytest.approx([0.1 / np.sqrt(2)] * 2)
    assert length < 1e-5


@pytest.mark.parametrize(
    ("drive", "given"), [("rig", {}), ("road", {"wheel.front.unsprung_mass_kg": 15.0})]
)
def test_the_common_scale_is_known_where_a_force_or_a_mass_is(drive, given):
    """On a rig that measures the force, and on a vehicle of which a part was weighed."""
    assert max(told([HEAVY, STIFF], drive, given)) < 1e-5


@given(st.floats(-6.0, 6.0), st.floats(-3.0, 3.0), st.floats(60.0, 200.0))
def test_no_number_is_known_worse_than_it_was_believed(told, pulled, at):
    """However much what is left pulls at it half-second by half-second, and wherever it lies."""
    free = (replace(HEAVY, in_proportion=True), LONG)
    column = 10.0**told * np.array([[1.0, 0.5]])
    run = SimpleNamespace(
        bench=SimpleNamespace(measures_force=False),
        followed=lambda: column,
        by_block=lambda columns: 10.0**pulled * columns,
    )
    model = Model({HEAVY.name: at, LONG.name: 1.3}, ())
    fit = Fit(model, free, (run,), np.eye(2), SIGMA, 0.0, 0.0)
    fit = replace(fit, precision=fit.believed + column.T @ column / SIGMA**2)
    for number in free:
        believed = number.sigma_at(model.values[number.name])
        assert fit.uncertainty(number.name) <= believed * (1.0 + 1e-9)
