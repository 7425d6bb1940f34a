"""The fit of a linear model over ground of unknown heights: Bayes' rule in one matrix."""

from dataclasses import dataclass
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest

from tests.fit.linear import (
    OWN,
    OWN_SCALES,
    SHARED,
    SIGMA,
    SIZE,
    SPEED,
    START,
    LinearBench,
    Shop,
    benches_of,
    in_full,
)
from tests.simulate.setup import ATV, EFFECTS
from wheelhop.compare.band import InBand
from wheelhop.fit import fit, update
from wheelhop.fit.fit import foreseen
from wheelhop.fit.height_response import Ground
from wheelhop.simulate import HeightSeries

BAND = InBand(128, 100.0, (5.0, 16.5))
SERIES = HeightSeries(1.6, 6)
ROUGHNESS = EFFECTS["small-scale-roughness"]
PARAMETERS = ROUGHNESS.parameters_for(ATV, ())
THETA = {"unevenness_m3": 1e-6, "waviness": 2.0}
VARIANCE = np.tile(ROUGHNESS.height_density(THETA, SERIES.wave_number_rad_m) * SERIES.step_rad_m, 2)
ROUGH = START.with_effect(ROUGHNESS, PARAMETERS).with_values(
    {f"{ROUGHNESS.id}.{name}": value for name, value in THETA.items()}
)
RUNS = 3


class Even(Ground):
    """Under two channels, each of which hears both paths, a little later each."""

    def __init__(self, bench, model=None, system=None, coherent=True):
        self.bench, self.series, self.speed_m_s = bench, SERIES, SPEED
        self._slowness = 1.0
        way = SPEED * np.arange(BAND.n) / BAND.rate_hz
        self._front = np.stack([way, way + 0.3], axis=1)

    def anew(self):
        return Even(self.bench)

    def response(self, wave_number_rad_m):
        later = np.array([[0.0, 0.1], [0.3, -0.2]])
        return 300.0 * np.exp(-1j * wave_number_rad_m[:, None, None] * later)


@dataclass
class RoughBench(LinearBench):
    """A run over heights that nobody knows."""

    band = BAND

    @property
    def simulator(self):
        return SimpleNamespace(setting=super().simulator.setting, series=SERIES)

    def record(self, model):
        heights = model.heights.get(self.run.id, np.zeros((2, SERIES.count)))
        return super().record(model) + Even(self).apply(heights.reshape(-1, 1))[:, 0]


@pytest.fixture
def benches(monkeypatch):
    """Three runs on rough ground, and one that stands still; noise is half of what is stated."""
    monkeypatch.setattr(import_module("wheelhop.fit.fit"), "Ground", Even)
    rng = np.random.default_rng(1)
    plain = benches_of(2, count=RUNS + 1, noise=0.5 * SIGMA, faint=1e-3)
    rough = [RoughBench(b.run, b.matrix, b.measured, b.names) for b in plain[:RUNS]]
    for bench in rough:
        heights = (rng.normal(size=(2, 2 * SERIES.count)).T @ [1.0, 1.0j]) * np.sqrt(VARIANCE)
        bench.measured = bench.measured + Even(bench).apply(heights[:, None])[:, 0]
    return [*rough, plain[-1]]


def shop(parameters=()):
    made = Shop()
    made.parameters_of = lambda effect: parameters
    return made


def test_heights_are_numbers_like_any_other(benches):
    """Each line's real and imaginary part with its variance beforehand: numbers, heights, their
    precision and the evidence are those of one least-squares problem."""
    design, data, prior = in_full(benches)
    unit = np.eye(2 * SERIES.count)
    lines = Even(benches[0]).apply(np.hstack([unit, 1j * unit]))
    over_ground = np.kron(np.eye(RUNS + 1)[:, :RUNS], lines)
    design = np.hstack([design, over_ground])
    prior = np.concatenate([prior, np.tile(1.0 / VARIANCE, 2 * RUNS)])
    precision = design.T @ design / SIGMA**2 + np.diag(prior)
    best = np.linalg.solve(precision, design.T @ data) / SIGMA**2
    found = fit(shop(), ROUGH, SHARED, benches)
    assert found.sigma == SIGMA

    values = [(found.model.values[f.name] - f.mean) / f.scale for f in SHARED]
    np.testing.assert_allclose(values, best[:2], atol=1e-3)
    for k, bench in enumerate(benches):
        own = found.model.runs[bench.run.id]
        mine = (np.array([own[n] for n in OWN]) - [SPEED, 0.0]) / OWN_SCALES
        np.testing.assert_allclose(mine, best[2 + 2 * k : 4 + 2 * k], atol=0.1)
    first = len(best) - RUNS * 4 * SERIES.count
    parts = best[first:].reshape(RUNS, 2, 2, SERIES.count)
    assert set(found.model.heights) == {bench.run.id for bench in benches[:RUNS]}
    for bench, (real, imaginary) in zip(benches, parts, strict=False):
        heights = found.model.heights[bench.run.id]
        np.testing.assert_allclose(heights, real + 1j * imaginary, atol=2e-3 * abs(real).max())

    covariance = np.linalg.inv(precision)[:2, :2]
    np.testing.assert_allclose(np.linalg.inv(found.precision), covariance, rtol=2e-3)
    left = data - design @ best
    cost = left @ left / SIGMA**2 + best @ (prior * best)
    assert found.cost == pytest.approx(cost, rel=1e-3)
    few = np.concatenate([np.maximum(prior[:first], 0.25), prior[first:]])
    volume = np.log(few).sum() - np.linalg.slogdet(precision)[1]
    expected = -0.5 * cost - len(data) * np.log(SIGMA) + 0.5 * volume
    assert found.evidence == pytest.approx(expected, abs=0.05)
    for run in found.runs[:RUNS]:  # what it spent is known, the large matrices are gone
        assert 0.0 < run.heights.freedom < 4.0 * SERIES.count
        assert "_waves" not in vars(run.heights.ground)


def test_a_density_is_found_where_shared_numbers_are_and_stays_elsewhere(benches):
    """Runs held out, or not driven yet, say nothing of it."""
    begun = ROUGH.with_values({f"{ROUGHNESS.id}.unevenness_m3": 1e-7})
    of = shop(PARAMETERS)
    found = fit(of, begun, SHARED, benches[:2])
    name = f"{ROUGHNESS.id}.unevenness_m3"
    assert found.model.values[name] > 1.2 * begun.values[name]
    then = update(of, found, begun, benches[2:])
    assert then.model.values[name] == begun.values[name]
    assert foreseen(of, begun, SHARED, benches[2:]).model.values[name] == begun.values[name]
    assert fit(of, begun, (), benches[2:]).model.values[name] == begun.values[name]


def test_heights_need_no_more_steps_than_other_numbers(benches):
    """The problem is linear; the noise is told anew once or twice."""
    seen = []
    of = shop()
    of.watch = lambda iteration, error: seen.append(error)
    fit(of, ROUGH, SHARED, benches)
    assert len(seen) <= 3


@pytest.mark.parametrize("model", [START, ROUGH], ids=["no effect", "no such ground"])
def test_without_heights_each_channel_has_its_own_noise(benches, model, monkeypatch):
    """Where no effect adds any, or no run is on such ground, the bench says what a residual is
    worth and how far it is from the noise."""
    monkeypatch.setattr(LinearBench, "cost", lambda bench, residual, sigma: 7.0)
    monkeypatch.setattr(LinearBench, "spread", lambda bench, residual, sigma: np.full(SIZE, 2.0))
    runs = benches if model is START else benches[RUNS:]
    plain = fit(shop(), model, SHARED, runs)
    assert plain.model.heights == {}
    assert all(run.heights is None and run.spread[0] == 2.0 for run in plain.runs)
    assert plain.cost >= 7.0 * len(runs)
    within = plain.cost - 7.0 * len(runs)
    assert within < 0.1 * plain.rss / SIGMA**2
