"""The fit: parameters within what it says of their uncertainty, from data of another simulator."""

from dataclasses import replace

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, campaign_of, model_of, simulated
from wheelhop.campaign import read_campaign
from wheelhop.fit import (
    Bench,
    RunFit,
    Workshop,
    find_start,
    fit,
    initial_model,
    update,
    vehicle_parameters,
)
from wheelhop.vehicle import Vehicle, read_vehicle

NOISE = 0.1
TRACKS = {
    "herringbone": ({"amplitude_mm": 20.0, "pitch_mm": 800.0}, 5.1, 33.7),
    "washboard": ({"amplitude_mm": 25.0, "pitch_mm": 600.0}, 3.4, 36.2),
    "chassis-twist": ({"amplitude_mm": 150.0, "pitch_mm": 2000.0}, 4.2, 40.3),
}
FIXED = ("geometry.cg_height_m", "driver.", "engine.")  # nothing in the baseline depends on them


def runs_of(names, samples=400):
    time = np.arange(samples) / 100.0
    return {
        name: truth.Run(truth.Track(name, TRACKS[name][0]), *TRACKS[name][1:], time)
        for name in names
    }


def uncertainty_of(values):
    """10 % of everything but what a tape measures: that is 1 %."""
    taped = ("geometry.", "wheel.front.radius", "wheel.rear.radius")
    return {k: (0.01 if k.startswith(taped) else 0.1) * abs(v) + 1e-3 for k, v in values.items()}


def fitted_to(campaign, vehicle, start=None):
    model = start or initial_model(campaign, vehicle)
    workshop = Workshop(campaign, model, jobs=2)
    if start is None:
        systems = workshop.systems(model)
        for run in campaign.runs:
            found = find_start(campaign, run, model, systems["road"])
            model = model.with_run(run.id, found)
    shared = vehicle_parameters(campaign, vehicle)
    return workshop, fit(workshop, model, shared, workshop.of_role("fit"))


def whitened(fitted, true):
    """Errors of the shared parameters in their joint standard deviations: χ² is their square."""
    error = np.array([fitted.model.values[f.name] - true[f.name] for f in fitted.shared])
    return np.linalg.solve(np.linalg.cholesky(fitted.covariance), error)


@pytest.fixture(scope="module")
def mujoco_campaign(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clean")
    return truth.make_campaign(folder, seed=17, effects={}, short=True, noise_rms=NOISE, draft=True)


def test_a_campaign_of_another_simulator_gives_back_its_truth(mujoco_campaign):
    """Vehicle, speeds and starts, from a nominal vehicle 10 % off."""
    campaign, true = read_campaign(mujoco_campaign), truth.read_truth(mujoco_campaign)
    workshop, fitted = fitted_to(campaign, read_vehicle(campaign.vehicle_file))
    off = {
        f.name: (fitted.model.values[f.name] - true.vehicle[f.name]) / fitted.uncertainty(f.name)
        for f in fitted.shared
    }
    assert max(abs(z) for z in off.values()) < 3.0, off
    assert fitted.error == pytest.approx(_noise_error(workshop), rel=0.02)
    # The data say more than was believed: of what carries the body and the wheels, at any rate.
    for free in fitted.shared:
        if "stiffness" in free.name or free.name == "body.mass_kg":
            assert fitted.uncertainty(free.name) < free.sigma
    for run in fitted.runs:
        driven, found = true.runs[run.bench.run.id], fitted.model.runs[run.bench.run.id]
        assert found["speed_m_s"] == pytest.approx(driven.speed_m_s, rel=1e-3)
        pitch = driven.track.metres("pitch")
        apart = (found["start_m"] - driven.start_m) / pitch
        assert abs(apart - round(apart)) < 5e-3


def test_noise_that_nobody_states_keeps_no_fit_from_its_end(tmp_path):
    """A car's axles move much more than its body: with one noise for both, found from what is
    left, −2 ln p is below zero where the fit begins."""
    car = truth.PRESETS["passenger-car"]
    truth.write_campaign(tmp_path, car, [], seed=17, short=True, noise_rms=NOISE, draft=True)
    campaign = replace(read_campaign(tmp_path), noise_rms=None)
    workshop, fitted = fitted_to(campaign, read_vehicle(campaign.vehicle_file))
    assert fitted.error == pytest.approx(_noise_error(workshop), rel=0.05)


def _noise_error(workshop):
    benches = workshop.of_role("fit")
    noise = sum(b.band.n * b.measured.shape[1] for b in benches) * NOISE**2
    return np.sqrt(noise / sum(b.energy for b in benches))


@pytest.fixture(scope="module")
def noise_free():
    runs = runs_of(TRACKS)
    campaign = campaign_of(runs)
    return runs, simulated(campaign, model_of(ATV, runs))


def recorded(noise_free, seed, names=tuple(TRACKS)):
    """White noise whose in-band rms is NOISE; the starts at which these runs were driven."""
    runs, clean = noise_free
    rng = np.random.default_rng(seed)
    share = (30.0 - 0.5) / 50.0
    noisy = {k: clean[k] + NOISE / np.sqrt(share) * rng.normal(size=clean[k].shape) for k in runs}
    chosen = {name: runs[name] for name in names}
    return campaign_of(chosen, {k: noisy[k] for k in names}, noise_rms=NOISE)


def drawn_vehicle(seed, free_keys):
    """A nominal vehicle that is off by what its owner says he doesn't know."""
    rng, sigma = np.random.default_rng(seed), uncertainty_of(ATV)
    values = {k: v + sigma[k] * rng.normal() if k in free_keys else v for k, v in ATV.items()}
    return Vehicle("nominal", values, sigma)


def test_covariance_is_that_of_repeated_campaigns(noise_free):
    """Over noise and priors drawn anew, χ² of the parameters' errors is that of their number."""
    runs, _ = noise_free
    total, count = 0.0, 0
    for seed in range(8):
        campaign = recorded(noise_free, seed)
        shared = vehicle_parameters(campaign, Vehicle("true", ATV, uncertainty_of(ATV)))
        vehicle = drawn_vehicle(100 + seed, {f.name for f in shared})
        start = model_of(vehicle.values, runs)
        _, fitted = fitted_to(campaign, vehicle, start)
        total += float(np.sum(whitened(fitted, ATV) ** 2))
        count += len(fitted.shared)
    # χ² of n numbers is n ± √(2 n): four of these either way.
    assert abs(total - count) < 4 * np.sqrt(2 * count)


def test_a_quiet_run_does_not_disturb_the_rest(noise_free):
    """A run that shows nothing but noise, its start and speed anywhere: the vehicle stays."""
    runs, _ = noise_free
    campaign = recorded(noise_free, 3, ("herringbone", "washboard"))
    vehicle = drawn_vehicle(7, set(ATV) - {k for k in ATV if k.startswith(FIXED)})
    _, without = fitted_to(campaign, vehicle)
    rng = np.random.default_rng(11)
    quiet_run = truth.Run(
        truth.Track("chassis-twist", {"amplitude_mm": 1.0, "pitch_mm": 4000.0}),
        *(1.4, 35.0, runs["washboard"].time_s),
    )
    quiet = campaign_of(
        {"quiet": quiet_run},
        {"quiet": 0.13 * rng.normal(size=(len(quiet_run.time_s), 8))},
        nominal_m_s={"quiet": 1.5},
        noise_rms=NOISE,
    )
    _, fitted = fitted_to(replace(campaign, runs=(*campaign.runs, *quiet.runs)), vehicle)
    for free in fitted.shared:
        moved = fitted.model.values[free.name] - without.model.values[free.name]
        assert abs(moved) < 0.3 * without.uncertainty(free.name), free.name
    assert fitted.model.runs["quiet"]["speed_m_s"] == pytest.approx(1.5, rel=0.25)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_nominal_vehicle_wrong_by_two_sigma_still_converges(noise_free, seed):
    """Every number 20 % off (a tape's 2 %), up or down: the error still ends at the noise."""
    campaign = recorded(noise_free, seed)
    rng, sigma = np.random.default_rng(seed), uncertainty_of(ATV)
    values = {k: v + 2 * sigma[k] * rng.choice([-1.0, 1.0]) for k, v in ATV.items()}
    workshop, fitted = fitted_to(campaign, Vehicle("wrong", values, sigma))
    assert fitted.error < 1.05 * _noise_error(workshop)


def test_what_nothing_depends_on_stays_as_believed(noise_free):
    campaign = recorded(noise_free, 1)
    vehicle = drawn_vehicle(4, {"body.mass_kg"})
    names = {f.name for f in vehicle_parameters(campaign, vehicle)}
    assert names == {key for key in ATV if not key.startswith(FIXED)}


@pytest.mark.filterwarnings("error")
def test_a_fit_that_begins_at_an_unstable_vehicle_leaves_infinitely_much(noise_free):
    """So that it comes last wherever fits are compared: NaN would be neither before nor behind."""
    runs, _ = noise_free
    runaway = dict(ATV) | {f"suspension.{axle}.damping_N_s_m": -5e4 for axle in ("front", "rear")}
    campaign = recorded(noise_free, 1)
    _, fitted = fitted_to(
        campaign, Vehicle("true", ATV, uncertainty_of(ATV)), model_of(runaway, runs)
    )
    assert fitted.error == np.inf
    assert fitted.evidence == -np.inf


@pytest.mark.filterwarnings("error")
def test_a_residual_too_large_to_square_is_infinitely_much():
    assert RunFit(None, (), np.full(4, 1e200), None, np.ones(4)).rss == np.inf


@pytest.mark.filterwarnings("error")
def test_a_step_to_where_the_vehicle_runs_away_is_no_news(noise_free, monkeypatch):
    """It leaves more than can be squared: the fit stays where it was, and warns nobody."""
    runs, _ = noise_free
    campaign, start = recorded(noise_free, 1), model_of(ATV, runs)
    workshop = Workshop(campaign, start)
    free = vehicle_parameters(campaign, Vehicle("true", ATV, uncertainty_of(ATV)))
    there = Bench.residual

    def elsewhere(bench, model, systems):
        residual = there(bench, model, systems)
        return residual if model.values == start.values else np.full_like(residual, 1e200)

    monkeypatch.setattr(Bench, "residual", elsewhere)
    fitted = fit(workshop, start, free, workshop.of_role("fit"))
    assert fitted.model.values == start.values and np.isfinite(fitted.cost)


def apart(fitted, other):
    """How far two fits' shared parameters are apart, in joint standard deviations of the other."""
    off = [fitted.model.values[f.name] - other.model.values[f.name] for f in other.shared]
    return np.linalg.solve(np.linalg.cholesky(other.covariance), off)


def test_runs_fitted_one_after_the_other_say_what_all_say_at_once(noise_free):
    """Bayes' rule: what the first runs leave uncertain is believed beforehand of the others; then
    numbers, their precision and the evidence are those of a fit to all of them."""
    runs, _ = noise_free
    campaign = recorded(noise_free, 5)
    vehicle = drawn_vehicle(9, set(ATV))
    workshop, everything = fitted_to(campaign, vehicle, model_of(vehicle.values, runs))
    benches = workshop.of_role("fit")
    start = model_of(vehicle.values, runs)
    first = fit(workshop, start, everything.shared, benches[:1])
    then = update(workshop, first, first.model, benches[1:])
    assert np.abs(apart(first, everything)).max() > 1.0
    assert np.abs(apart(then, everything)).max() < 0.3  # a posterior is handed on as normal
    unit = np.sqrt(np.diag(everything.precision))
    assert then.precision / np.outer(unit, unit) == pytest.approx(
        everything.precision / np.outer(unit, unit), abs=0.06
    )  # nor is what is believed in proportion
    assert first.evidence + then.evidence == pytest.approx(everything.evidence, abs=2.0)


def test_a_run_in_a_false_minimum_keeps_no_other_from_the_noise(noise_free):
    """One run begins half a wave along its track. The others come down to the noise as if it were
    not there, and the vehicle is theirs."""
    runs, _ = noise_free
    campaign, vehicle = recorded(noise_free, 5), drawn_vehicle(9, set(ATV))
    start = model_of(vehicle.values, runs)
    lost = start.runs["washboard"]["start_m"] + 0.3
    _, fitted = fitted_to(campaign, vehicle, start.with_run("washboard", {"start_m": lost}))
    power = {r.bench.run.id: r.rss / r.bench.size / fitted.sigma**2 for r in fitted.runs}
    assert power.pop("washboard") > 1000.0
    assert max(power.values()) < 1.1
    assert np.sqrt(np.mean(whitened(fitted, ATV) ** 2)) < 2.0
