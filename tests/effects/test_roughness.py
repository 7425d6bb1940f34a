"""Small-scale roughness: heights nobody knows, found in what all channels say of them."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, EFFECTS, campaign_of, model_of, relative, simulated
from wheelhop.diagnose import Rung
from wheelhop.diagnose.score import log_odds
from wheelhop.diagnose.screen.first_order import screen_best, screen_heights
from wheelhop.fit import Ground, Heights, Workshop, fit
from wheelhop.simulate import HeightSeries, Model
from wheelhop.simulate.motion import MotionSimulator

ROUGHNESS = EFFECTS["small-scale-roughness"]
TRACK = truth.Track("washboard", {"amplitude_mm": 15.0, "pitch_mm": 600.0})
RUNS = {"slow": truth.Run(TRACK, 2.9, 33.0, np.arange(512) / 100.0, seed=3)}
THETA = {"unevenness_m3": 1e-6, "waviness": 2.0}
HIDDEN = {"small-scale-roughness": THETA}


def bench_of(runs=RUNS, recorded=None):
    campaign = campaign_of(runs, recorded, noise_rms=0.1)
    model = model_of(ATV, runs)
    workshop = Workshop(campaign, model, jobs=1)
    return workshop, model, workshop.benches["slow"]


def heights_of(series, seed=1, theta=THETA):
    density = ROUGHNESS.height_density(theta, series.wave_number_rad_m)
    return series.drawn(density, np.random.default_rng(seed))


def test_the_density_is_that_of_iso_8608():
    """Class A at 1 rad/m, and a hundredth of it at ten times the wave number."""
    density = ROUGHNESS.height_density(THETA, np.array([1.0, 10.0]))
    np.testing.assert_allclose(density, [1e-6, 1e-8])


def test_rear_wheels_meet_what_front_wheels_met():
    series = HeightSeries(40.0, 300)
    way = np.linspace(0.0, 30.0, 4000)
    height, slope = series.at(heights_of(series), np.stack([way, way, way - 1.4, way - 1.4], 1))
    for side in (0, 1):
        later = np.interp(way[200:] - 1.4, way, height[:, side])
        np.testing.assert_allclose(height[200:, side + 2], later, atol=1e-5)
        rise = np.gradient(height[:, side], way)
        np.testing.assert_allclose(slope[2:-2, side], rise[2:-2], atol=0.05 * slope.std())
    assert abs(np.corrcoef(height[:, 0], height[:, 1])[0, 1]) < 0.5  # left and right: unlike


def test_the_variance_of_the_heights_is_the_integral_of_their_density():
    series = HeightSeries(200.0, 2000)
    way = np.linspace(0.0, 200.0, 40001)[:-1, None] * np.ones(4)
    variance = [series.at(heights_of(series, seed), way)[0].var() for seed in range(40)]
    # ∫ C κ⁻² dκ over the series' lines.
    expected = THETA["unevenness_m3"] * np.sum(series.wave_number_rad_m**-2.0) * series.step_rad_m
    assert np.mean(variance) == pytest.approx(expected, rel=0.2)


def test_heights_are_simulated_as_the_independent_simulator_rolls_over_them():
    """The heights of its wheels' centres as a series along the way: the accelerations they cause
    agree to 0.5 %."""
    run = truth.Run(truth.Track("flat", {}), 2.9, 33.0, np.arange(512) / 100.0, seed=3)
    runs, effects = {"slow": run}, truth.make_effects(HIDDEN)
    rolled = truth.integrate(ATV, run, effects)
    way = run.speed_m_s * rolled.time
    recent = (rolled.time > -1.4) & (np.arange(len(rolled.time)) % 8 == 0)
    series = bench_of(runs)[2].simulator.series
    waves = np.exp(1j * np.outer(way[recent], series.wave_number_rad_m))
    columns = np.hstack([waves.real, -waves.imag])
    parts = np.linalg.lstsq(columns, rolled.road[recent, :2], rcond=1e-4)[0]
    heights = (parts[: series.count] + 1j * parts[series.count :]).T
    model = model_of(ATV, runs).with_heights({"slow": heights})
    ours = simulated(campaign_of(runs), model)["slow"]
    assert relative(ours, truth.simulate_run(ATV, run, effects)[1]) < 0.005


@pytest.mark.parametrize("faster", [0.9, 1.0, 1.06])
def test_the_linear_map_is_what_the_simulation_does(faster):
    """To first order, at any speed; waves of negative frequency, which it leaves out, are 3 % in
    five seconds."""
    workshop, model, bench = bench_of()
    model = model.with_run("slow", {**model.runs["slow"], "speed_m_s": 2.9 * faster})
    heights = heights_of(bench.simulator.series)
    systems = workshop.systems(model)
    change = bench.modelled(model.with_heights({"slow": heights}), systems)
    change -= bench.modelled(model, systems)
    ground = Ground(bench, model, systems["road"])
    predicted = ground.apply(heights.reshape(-1, 1))[:, 0]
    assert np.linalg.norm(change - predicted) < 0.04 * np.linalg.norm(change)


def test_heights_go_along_with_speed_and_start():
    """A fit that corrects where a run was, and how fast, leaves the front wheels on the heights
    that the record showed, so it need not creep; the rear wheels meet them later or earlier."""
    flat = {"slow": replace(RUNS["slow"], track=truth.Track("flat", {}))}
    workshop, model, bench = bench_of(flat)
    rough = model.with_heights({"slow": heights_of(bench.simulator.series)})
    placed = {"speed_m_s": 2.9 * 1.05, "start_m": model.runs["slow"]["start_m"] + 0.3}
    simulator = MotionSimulator(bench.simulator.campaign, bench.run, 2.0)
    before, after = (
        simulator.motion(m, workshop.systems(m)["road"]).height
        for m in (rough, rough.with_run("slow", placed))
    )
    recent = slice(-len(RUNS["slow"].time_s) // 2, None)
    size = before[recent].std()
    np.testing.assert_allclose(after[recent, :2], before[recent, :2], atol=0.01 * size)
    assert np.abs(after[recent, 2:] - before[recent, 2:]).max() > 0.3 * size


@pytest.mark.parametrize("faster", [0.9, 1.06])
def test_what_is_believed_of_heights_does_not_depend_on_the_speed(faster):
    """The height's variance between two wave numbers of the ground as it is."""
    workshop, model, bench = bench_of()
    model = model.with_run("slow", {**model.runs["slow"], "speed_m_s": 2.9 * faster})
    ground = Ground(bench, model, workshop.systems(model)["road"])
    count = 2 * ground.series.count
    heights = Heights(ground, np.zeros(count, complex), np.ones(count), 1.0)
    variance = heights.believed(ROUGHNESS, THETA, 1.0).variance[: ground.series.count]
    wave = ground.wave_number_rad_m
    low, high = (wave[4] + wave[5]) / 2, (wave[60] + wave[61]) / 2
    within = np.sum(variance[5:61])
    expected = THETA["unevenness_m3"] * (1 / low - 1 / high)  # ∫ C κ⁻² dκ
    assert within == pytest.approx(expected, rel=0.03)


def test_a_sensors_fault_is_part_of_the_map():
    """Swapped channels, late ones: the heights' response is what such sensors give of it."""
    for effect_id, theta, choice in (
        ("sensor-polarity", {"wrong": 1.0}, "A1/B4"),
        ("sensor-skew", {"delay_s": 4e-4}, ""),
    ):
        form = EFFECTS[effect_id].with_choice(choice) if choice else EFFECTS[effect_id]
        workshop, model, bench = bench_of()
        faulty = model.with_effect(
            form, form.parameters_for(ATV, bench.simulator.campaign.channels)
        )
        faulty = faulty.with_values({f"{effect_id}.{k}": v for k, v in theta.items()})
        heights = heights_of(bench.simulator.series)
        systems = workshop.systems(faulty)
        change = bench.modelled(faulty.with_heights({"slow": heights}), systems)
        change -= bench.modelled(faulty, systems)
        ground = Ground(bench, faulty, systems["road"])
        predicted = ground.apply(heights.reshape(-1, 1))[:, 0]
        assert np.linalg.norm(change - predicted) < 0.04 * np.linalg.norm(change)


@pytest.fixture(scope="module")
def ground():
    workshop, model, bench = bench_of()
    return Ground(bench, model, workshop.systems(model)["road"])


def test_it_does_not_matter_when_a_record_began(ground):
    """Nor where on the track, if nobody says it: heights are those under the run's own way."""
    time = RUNS["slow"].time_s
    later = {"slow": truth.Run(TRACK, 2.9, 33.0 - 2.9 * 4.0, 4.0 + time, seed=3)}
    workshop, model, bench = bench_of(later)
    moved = Ground(bench, model, workshop.systems(model)["road"])
    assert moved.speed_m_s == pytest.approx(ground.speed_m_s) == pytest.approx(2.9)
    wave = 2.0 * np.pi * np.array([1.0, 5.0, 12.0]) / 2.9
    np.testing.assert_allclose(moved.response(wave), ground.response(wave), rtol=1e-9)
    nowhere = Model(model.values, (), {"slow": {"speed_m_s": 2.9}})
    still = Ground(bench, nowhere, workshop.systems(model)["road"])
    size = np.abs(moved.square()).max()
    np.testing.assert_allclose(still.square(), moved.square(), atol=1e-9 * size)


def dense(ground):
    """G (size, 2k) as a complex matrix, column by column."""
    count = 2 * ground.series.count
    return ground.complex_of(ground.apply(np.eye(count, dtype=complex))).reshape(-1, count)


def test_projection_and_square_belong_to_the_map(ground):
    matrix = dense(ground)
    rng = np.random.default_rng(0)
    record = rng.normal(size=(ground.bench.size, 2))
    flat = ground.complex_of(record).reshape(-1, 2)
    np.testing.assert_allclose(ground.project(record), matrix.conj().T @ flat, rtol=1e-9)
    size = np.abs(ground.square()).max()
    np.testing.assert_allclose(ground.square(), matrix.conj().T @ matrix, atol=1e-9 * size)


@pytest.mark.parametrize("unevenness", [1e-16, 1e-7, 1e-2])
def test_elimination_is_ridge_regression(ground, unevenness):
    """The estimate, the degrees of freedom it spends and the volume it leaves, against the normal
    equations in full; none are spent on even ground, nearly one per unknown on very rough ground
    that is heard above the noise."""
    matrix, sigma = dense(ground), 0.4
    start = Heights(ground, np.zeros(matrix.shape[1], complex), np.ones(1), 1.0)
    heights = start.believed(ROUGHNESS, {**THETA, "unevenness_m3": unevenness}, sigma)
    precision = np.diag(1.0 / heights.variance)
    normal = matrix.conj().T @ matrix / sigma**2 + precision
    record = np.random.default_rng(0).normal(size=(ground.bench.size, 1))
    flat = ground.complex_of(record).reshape(-1)
    ridge = np.linalg.solve(normal, matrix.conj().T @ flat) / sigma**2
    scale = np.abs(ridge).max()
    none = np.empty((len(ridge), 0))
    step, _ = heights.step(ground.project(record)[:, 0], none)
    np.testing.assert_allclose(step, ridge, atol=1e-5 * scale)
    at_optimum = Heights(ground, ridge, heights.variance, sigma)
    left = record - at_optimum.contribution()[:, None]
    again, _ = at_optimum.step(ground.project(left)[:, 0], none)
    np.testing.assert_allclose(again, 0.0, atol=1e-5 * scale)
    spent = 2 * np.trace(np.eye(len(normal)) - np.linalg.solve(normal, precision)).real
    assert heights.freedom == pytest.approx(spent, abs=0.05)
    assert heights.freedom < 2 * len(ridge)
    volume = -2 * np.linalg.slogdet(normal @ np.diag(heights.variance))[1]
    assert heights.log_volume == pytest.approx(volume, rel=1e-4, abs=1e-2)


@pytest.mark.parametrize("unevenness", [1e-16, 1e-8, 1e-7])
def test_what_heights_leave_is_what_the_best_of_them_leave(ground, unevenness):
    """Frequency by frequency, but for what leaks: of noise, and of what such heights do."""
    start = Heights(ground, np.zeros(2 * ground.series.count, complex), np.ones(1), 1.0)
    theta = {**THETA, "unevenness_m3": unevenness}
    heights = start.believed(ROUGHNESS, theta, 0.4)
    assert heights.freed(np.zeros((ground.bench.size, 0))).shape == (ground.bench.size, 0)
    noise = np.random.default_rng(0).normal(size=ground.bench.size)
    rough = ground.apply(heights_of(ground.series, theta=theta).reshape(-1, 1))[:, 0]
    found = heights.freed(np.stack([noise, rough], axis=1))
    for record, freed in zip((noise, rough), found.T, strict=True):
        none = np.empty((2 * ground.series.count, 0))
        step, _ = heights.step(ground.project(record[:, None])[:, 0], none)
        left = record - ground.apply(step[:, None])[:, 0]
        assert np.linalg.norm(freed - left) < 0.15 * np.linalg.norm(record)
        assert np.linalg.norm(freed) == pytest.approx(np.linalg.norm(left), rel=0.15)


def recorded(hidden, seed, noise=0.1, samples=1024):
    runs = {
        name: truth.Run(
            truth.Track("washboard", {"amplitude_mm": 15.0, "pitch_mm": pitch}),
            speed,
            33.0,
            np.arange(samples) / 100.0,
            seed=seed + i,
        )
        for i, (name, pitch, speed) in enumerate([("slow", 400.0, 2.2), ("fast", 600.0, 3.4)])
    }
    rng = np.random.default_rng(seed)
    effects = truth.make_effects(hidden)
    records = {name: truth.simulate_run(ATV, run, effects)[1] for name, run in runs.items()}
    noise_rms = noise * np.sqrt(50.0 / 29.5)  # in band: `noise`
    noisy = {name: r + noise_rms * rng.normal(size=r.shape) for name, r in records.items()}
    model = model_of(ATV, runs)
    workshop = Workshop(campaign_of(runs, noisy, noise_rms=noise), model, jobs=1)
    return workshop, model, fit(workshop, model, (), workshop.of_role("fit"))


def screened(hidden, seed=1):
    workshop, _, base = recorded(hidden, seed)
    return screen_heights(workshop, base, ROUGHNESS)


@pytest.mark.parametrize(("unevenness", "waviness"), [(2e-8, 2.4), (1e-6, 1.8)])
def test_the_density_is_found(unevenness, waviness):
    """On records of the independent simulator, weak and strong; it is that of the paths of the
    wheels' centres, smoother at short waves than the ground itself."""
    theta = {"unevenness_m3": unevenness, "waviness": waviness}
    found = screened({"small-scale-roughness": theta})
    assert found.worth > 100.0
    assert found.theta["waviness"] == pytest.approx(waviness, abs=0.35)
    assert 0.5 < found.theta["unevenness_m3"] / unevenness < 2.5


def test_paths_that_resemble_each_other_are_found_too():
    found = screened({"small-scale-roughness": THETA | {"likeness": 0.8}})
    assert found.worth > 0.0
    assert found.theta["waviness"] == pytest.approx(2.0, abs=0.35)


@pytest.mark.parametrize("other", ["friction", "digressive", "seat"])
def test_rough_ground_is_seen_beside_what_leaves_lines(other):
    """Lines that follow from the known track tell nothing of the ground: its density is that of the
    frequencies between them."""
    theta = {"unevenness_m3": 1e-6, "waviness": 2.4}
    found = screened(OTHERS[other] | {"small-scale-roughness": theta})
    assert found.worth > 100.0
    assert found.theta["waviness"] == pytest.approx(theta["waviness"], abs=0.35)
    assert 0.5 < found.theta["unevenness_m3"] / theta["unevenness_m3"] < 2.5


@pytest.mark.parametrize("seed", [1, 2])
def test_random_heights_have_no_lines(seed, monkeypatch):
    """Of random heights hardly a frequency is so far from what is expected that it is set aside:
    they are worth what they are worth where none ever is."""
    rough = {"small-scale-roughness": {"unevenness_m3": 1e-7, "waviness": 2.0}}
    found = screened(rough, seed).worth
    monkeypatch.setattr(import_module("wheelhop.diagnose.screen.first_order"), "LINE", np.inf)
    assert found == pytest.approx(screened(rough, seed).worth, rel=3e-3)


OTHERS = {
    "nothing": {},
    "friction": {"dry-friction": {"coulomb_front_N": 75.0, "coulomb_rear_N": 55.0}},
    "speed": {"speed-fluctuation": {"fraction": 0.04}},
    "drift": {"left-right-drift": {"rate": 0.004}},
    "digressive": {"digressive-damper": {"knee_m_s": 0.1, "slope_ratio": 0.4}},
    "seat": {"driver-seat": {"mass_kg": 68.0, "freq_hz": 3.2, "zeta": 0.28, "x_m": -0.1}},
}


@pytest.mark.parametrize("other", OTHERS)
def test_other_physics_is_not_taken_for_heights(other):
    """Free heights explain a part of any residual; the controls say that it was not the ground."""
    assert screened(OTHERS[other]).worth < 10.0


LAWS = {
    "tyre": {"progressive-tyre": {"growth_per_m": 4.0}},
    "spring": {"progressive-spring": {"cubic_front_N_m3": 4e6, "cubic_rear_N_m3": 2.5e6}},
}


@pytest.mark.parametrize("law", LAWS)
def test_what_is_left_between_lines_is_not_taken_for_heights(law):
    """Of such a law a little stays between its lines: about one per cent of what heights are worth
    with them, but more than heights of its own under every wheel make of it."""
    assert screened(LAWS[law], seed=2).worth <= 0.0


def fitted_rough(hidden, theta, seed):
    """A model with heights, fitted to records in which more may be hidden."""
    workshop, model, base = recorded(hidden | {ROUGHNESS.id: theta}, seed)
    rough = model.with_effect(ROUGHNESS, ROUGHNESS.parameters_for(ATV, ()))
    rough = Model(rough.values, rough.effects, base.model.runs).with_values(
        {f"{ROUGHNESS.id}.{k}": v for k, v in theta.items()}
    )
    return workshop, base, fit(workshop, rough, (), workshop.of_role("fit"))


def test_the_fit_leaves_the_noise_and_charges_for_the_heights():
    """Residual per degree of freedom: the sensors' noise, to 5 %."""
    workshop, base, fitted = fitted_rough({}, {"unevenness_m3": 1e-7, "waviness": 2.0}, 5)
    left = fitted.rss / (fitted.size - sum(run.freedom for run in fitted.runs))
    assert np.sqrt(left) == pytest.approx(workshop.noise, rel=0.05)
    assert base.rss > 3.0 * fitted.rss
    for run in fitted.runs:
        assert 0.2 * run.bench.size < run.freedom < 0.27 * run.bench.size
    assert fitted.evidence > base.evidence + 1000.0


def test_heights_that_are_not_there_gain_no_odds():
    """Following noise with a little roughness lowers the residual and is worth nothing."""
    workshop, model, base = recorded({}, 2)
    rough = model.with_effect(ROUGHNESS, ROUGHNESS.parameters_for(ATV, ())).with_values(
        {f"{ROUGHNESS.id}.unevenness_m3": 1e-9, f"{ROUGHNESS.id}.waviness": 2.0}
    )
    fitted = fit(workshop, rough, (), workshop.of_role("fit"))
    assert fitted.rss < 0.99 * base.rss
    assert log_odds(Rung(base, base), Rung(fitted, fitted), workshop.noise) < 0.0
    assert fitted.evidence < base.evidence


def test_beside_rough_ground_the_best_are_sought_like_anywhere():
    """Friction stands out where heights are free in every run, too."""
    hidden = {"dry-friction": {"coulomb_front_N": 75.0, "coulomb_rear_N": 55.0}}
    workshop, _, fitted = fitted_rough(hidden, {"unevenness_m3": 1e-7, "waviness": 2.0}, 5)
    library = [EFFECTS["driver-seat"], EFFECTS["dry-friction"], EFFECTS["sensor-gain"]]
    best, *_ = screen_best(workshop, fitted, library)
    assert best.variant.effect.id == "dry-friction"
