"""The fit of a linear model over ground of unknown heights: Bayes' rule in one matrix."""

from dataclasses import dataclass, replace
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

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
from wheelhop.fit.heights import Heights
from wheelhop.simulate import HeightSeries

BAND = InBand(128, 100.0, (5.0, 16.5))
SERIES = HeightSeries(5.6, 24)
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
        self._slowness, self._model, self._system = 1.0, model, system
        way = SPEED * np.arange(BAND.n) / BAND.rate_hz
        self._front = np.stack([way, way + 0.3], axis=1)

    def about(self, model, system):
        return type(self)(self.bench, model)

    def response(self, wave_number_rad_m):
        later = np.array([[0.0, 0.1], [0.3, -0.2]])
        return 300.0 * np.exp(-1j * wave_number_rad_m[:, None, None] * later)


class Ringing(Even):
    """Under channels that ring at 10 Hz, the longer the less the model is damped."""

    def response(self, wave_number_rad_m):
        ratio = wave_number_rad_m * SPEED / (2 * np.pi) / 10.0
        damping = 0.05 * self._model.values["stiffness"] / 100.0
        peak = 1.0 / (1.0 - ratio**2 + 2j * damping * ratio)
        return super().response(wave_number_rad_m) * peak[:, None, None]


@dataclass
class RoughBench(LinearBench):
    """A run over heights that nobody knows."""

    band, ground = BAND, Even

    @property
    def simulator(self):
        return SimpleNamespace(setting=super().simulator.setting, series=SERIES)

    def record(self, model):
        heights = model.heights.get(self.run.id, np.zeros((2, SERIES.count)))
        return super().record(model) + self.ground(self, model).apply(heights.reshape(-1, 1))[:, 0]


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


def ringing_benches(damping, count=12):
    """Runs of channels that ring over heights nobody knows; of the damping they tell nothing
    else."""
    rng = np.random.default_rng(7)
    made = []
    for b in benches_of(2, count=count, noise=SIGMA, faint=1e-3):
        bench = RoughBench(b.run, b.matrix * [0.0, 1.0, 1.0, 1.0], b.measured, b.names)
        bench.ground = Ringing
        heights = (rng.normal(size=(2, 2 * SERIES.count)).T @ [1.0, 1.0j]) * np.sqrt(VARIANCE)
        model = ROUGH.with_values({"stiffness": damping}).with_heights({b.run.id: heights})
        bench.measured = bench.record(model) + SIGMA * rng.normal(size=SIZE)
        made.append(bench)
    return made


def heights_integrated_out(benches, damping):
    """−2 ln of likelihood and prior, what is linear at its best, heights as one more noise."""
    model = ROUGH.with_values({"stiffness": damping})
    unit = np.eye(2 * SERIES.count)
    lines = Ringing(benches[0], model).apply(np.hstack([unit, 1j * unit]))
    noise = SIGMA**2 * np.eye(SIZE) + lines * np.tile(VARIANCE, 2) @ lines.T
    design, data, prior = in_full(benches)
    white = np.linalg.inv(np.linalg.cholesky(noise))
    design = np.vstack([white @ part for part in design.reshape(len(benches), SIZE, -1)])
    data = np.concatenate([white @ part for part in data.reshape(len(benches), SIZE)])
    best = np.linalg.solve(design.T @ design + np.diag(prior), design.T @ data)
    left = data - design @ best
    volume = len(benches) * np.linalg.slogdet(noise)[1]
    return left @ left + best @ (prior * best) + volume + ((damping - 100.0) / 20.0) ** 2


def test_a_resonance_is_as_sharp_as_the_ground_it_is_heard_over_says(monkeypatch):
    """Heights are integrated out, not taken for the likeliest: a sharper resonance asks for less
    height, and so would seem likelier at any damping (J. Neyman, E. Scott, Econometrica 16 (1948)
    1, of numbers that grow with the data)."""
    monkeypatch.setattr(import_module("wheelhop.fit.fit"), "Ground", Ringing)
    benches = ringing_benches(120.0)
    best = minimize_scalar(lambda d: heights_integrated_out(benches, d), (80.0, 120.0)).x
    found = fit(shop(), ROUGH, SHARED, benches)
    away = (found.model.values["stiffness"] - best) / found.uncertainty("stiffness")
    assert away == pytest.approx(0.0, abs=0.35)  # 15 frequencies leak over the ends of their band


def test_heights_pull_at_no_number_that_they_are_not_heard_by(monkeypatch):
    """Nor where the resonance has moved a little since their response was worked out: a number that
    only its belief holds would run away, as the common scale of masses and forces did."""
    monkeypatch.setattr(import_module("wheelhop.fit.fit"), "Ground", Ringing)
    benches, of, seen = ringing_benches(120.0), shop(), []
    for bench in benches:
        bench.matrix = bench.matrix * [0.0, 0.0, 1.0, 1.0]
    best = fit(of, ROUGH, SHARED, benches).model
    of.watch = lambda iteration, error: seen.append(error)
    found = fit(of, best, SHARED, benches).model
    assert len(seen) <= 8
    assert found.values["stiffness"] == pytest.approx(best.values["stiffness"], abs=2.0)
    assert found.values["mass"] == pytest.approx(START.values["mass"], abs=1e-6)


def test_derivatives_made_without_heights_pull_at_nothing_that_heights_tell(monkeypatch):
    """They do not know what a sharper resonance would explain, and so must not know what it costs:
    a quick fit would step far away and back."""
    monkeypatch.setattr(import_module("wheelhop.fit.fit"), "Ground", Ringing)
    benches, of, seen = ringing_benches(120.0), shop(), []
    known = fit(of, START, SHARED, benches)
    of.watch = lambda iteration, error: seen.append(error)
    fit(of, ROUGH.with_values(known.model.values), SHARED, benches, known)
    assert len(seen) <= 3


def test_the_volume_of_heights_grows_as_their_response_shrinks(benches):
    """To first order, whatever the way that the response changes."""
    model = ROUGH.with_values({"stiffness": 120.0})
    heights = Heights(Ringing(benches[0], model), np.ones(2 * SERIES.count), VARIANCE, SIGMA)
    other = model.with_values({"stiffness": 120.1})
    more = replace(heights, ground=Ringing(benches[0], other)).log_volume - heights.log_volume
    assert more > 0.005
    slopes = {"stiffness": heights.ground.slope(other, None, 0.1)}
    found = replace(heights, slopes=slopes).growths(["stiffness", "mass"])
    assert found == pytest.approx([more / 0.1, 0.0], rel=0.05)


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
