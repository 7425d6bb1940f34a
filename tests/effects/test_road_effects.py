"""Effects between track and axle: against closed forms, and against the same physics in MuJoCo."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests import truth
from tests.simulate.setup import (
    ATV,
    CHANNELS,
    EFFECTS,
    TIME,
    campaign_of,
    model_of,
    relative,
    simulated,
)
from tests.simulate.test_against_mujoco import RUNS
from wheelhop.effects import OwnValues, RunSetting
from wheelhop.effects.progressive_tyre import beyond_linear
from wheelhop.effects.tyre_lift_off import no_pull
from wheelhop.vehicle import baseline
from wheelhop.vehicle.layout import body_inertia

REACHED = 2e-4
"""What the two simulators differ by, band rms, with or without these effects."""

SETTING = RunSetting("run", 5.0, -4.0, 0.0, 10.3, True)
GROWTH, BEND, STIFFNESS = st.floats(1.0, 80.0), st.floats(0.0, 5e3), st.floats(1e4, 3e5)
EXTENSION = st.floats(-0.05, 0.05)


# --- progressive tyre ---------------------------------------------------------------------------


@given(EXTENSION, STIFFNESS, GROWTH, BEND)
def test_tyre_force_is_the_integral_of_its_stiffness(x, stiffness, growth, bend):
    """k (1 − g x + b x²), the part that grows never below zero."""
    along = np.linspace(0.0, x, 4001)
    rate = stiffness * (np.maximum(1.0 - growth * along, 0.0) - 1.0 + bend * along**2)
    expected = float(np.trapezoid(rate, along))
    tolerance = 1e-6 * stiffness * abs(x)
    assert beyond_linear(x, stiffness, growth, bend) == pytest.approx(expected, abs=tolerance)


@given(EXTENSION, STIFFNESS, BEND)
def test_a_cubic_tyre_is_odd_and_a_quadratic_one_stiffens_in_compression(x, stiffness, bend):
    odd = beyond_linear(x, stiffness, 0.0, bend)
    assert odd == -beyond_linear(-x, stiffness, 0.0, bend)
    assert beyond_linear(-abs(x), stiffness, 20.0, 0.0) <= 0.0  # pushes the wheel up harder
    assert beyond_linear(x, stiffness, 0.0, 0.0) == 0.0


@given(EXTENSION, st.floats(-1.0, 1.0), STIFFNESS, GROWTH, BEND, st.floats(100.0, 5e3))
def test_a_tyre_that_stiffens_lifts_off_when_all_of_its_force_is_used_up(
    x, v, stiffness, growth, bend, load
):
    """Linear part, stiffening and lift-off are three parts; together they never pull."""
    p = np.array([stiffness, 200.0, load, 1.0, growth, bend])
    linear = stiffness * x + 200.0 * v
    whole = linear + beyond_linear(x, stiffness, growth, bend)
    total = whole + no_pull(x, v, 0.0, 0.0, 0.0, p)[0]
    assert total == pytest.approx(min(whole, load), abs=1e-9 * stiffness)


def test_both_tyre_effects_together_agree_with_mujoco():
    """Lift-off must know of the stiffening, and in whatever order they were added."""
    run = {"washboard": RUNS["washboard"]}
    hidden = {"progressive-tyre": {"growth_per_m": 30.0}, "tyre-lift-off": {}}
    measured = truth.simulate_run(ATV, RUNS["washboard"], truth.make_effects(hidden))[1]
    model = model_of(ATV, run, "progressive-tyre", {"front_1_m": 30.0, "rear_1_m": 30.0})
    lifting = model_of(ATV, run, "tyre-lift-off", {"lifts": 1.0})
    values = {**model.values, **lifting.values}
    for effects in (model.effects + lifting.effects, lifting.effects + model.effects):
        both = type(model)(values, effects, model.runs)
        assert relative(simulated(campaign_of(run), both)["washboard"], measured) < 0.002
    assert relative(simulated(campaign_of(run), lifting)["washboard"], measured) > 0.02


# --- against MuJoCo -----------------------------------------------------------------------------

LENGTHS = {"front_m": 0.13, "rear_m": 0.09}
CASES = {
    "progressive-tyre": (
        "quadratic",
        {"front_1_m": 25.0, "rear_1_m": 25.0},
        {"growth_per_m": 25.0},
    ),
    "tyre-envelope path": ("path", LENGTHS, LENGTHS),
    "tyre-envelope ground": ("ground", LENGTHS, {**LENGTHS, "averages": "ground"}),
    "tyre-envelope footprint": (
        "footprint",
        {**LENGTHS, "follows": 1.0},
        {**LENGTHS, "averages": "footprint"},
    ),
}


@pytest.mark.parametrize("run_id", RUNS)
@pytest.mark.parametrize("case", CASES)
def test_accelerations_agree_with_mujoco(case, run_id):
    """To 2e-4 of the response, and to 1 % of what the effect itself does."""
    effect, (choice, theta, hidden) = case.split()[0], CASES[case]
    run = {run_id: RUNS[run_id]}
    measured = truth.simulate_run(ATV, RUNS[run_id], truth.make_effects({effect: hidden}))[1]
    ours = simulated(campaign_of(run), model_of(ATV, run, effect, theta, choice=choice))[run_id]
    without = simulated(campaign_of(run), model_of(ATV, run))[run_id]
    assert relative(ours, measured) < REACHED
    assert relative(ours, measured) < 0.01 * relative(without, measured)


@pytest.mark.parametrize("corner", [1, 4])
def test_a_wheel_out_of_balance_agrees_with_mujoco(corner):
    """Whose force is m e ω² cos(way / radius + phase), the phase drawn for each run; here the
    angle is counted from mid-record."""
    run_id, imbalance = "herringbone", 0.8
    run, name = RUNS[run_id], {1: "front_left", 4: "rear_right"}[corner]
    hidden = {"wheel-imbalance": {"imbalance_kg_m": imbalance, "corner": corner}}
    measured = truth.simulate_run(ATV, run, truth.make_effects(hidden))[1]
    end = "front" if corner == 1 else "rear"
    radius = ATV[f"wheel.{end}.radius_m"]
    campaign = campaign_of({run_id: run})
    way = run.start_m + run.speed_m_s * middle_s(campaign, model_of(ATV, {run_id: run}))
    phase = way / radius + np.random.default_rng(run.seed).uniform(0.0, 2 * np.pi)
    eccentricity = imbalance / ATV[f"wheel.{end}.unsprung_mass_kg"]
    own = {
        f"{name}_cos_m": eccentricity * np.cos(phase),
        f"{name}_sin_m": -eccentricity * np.sin(phase),
    }
    model = model_of(
        ATV, {run_id: run}, "wheel-imbalance", {f"{end}_m": radius}, choice=name, own=own
    )
    ours = simulated(campaign, model)[run_id]
    without = simulated(campaign, model_of(ATV, {run_id: run}))[run_id]
    assert relative(ours, measured) < REACHED
    assert relative(ours, measured) < 0.01 * relative(without, measured)


def middle_s(campaign, model):
    """Mid-record as effects are told."""
    from wheelhop.simulate import RunSimulator

    setting = RunSimulator(campaign, campaign.runs[0], 4.0).setting
    return (setting.record_start_s + setting.end_s) / 2


# --- wheel imbalance ----------------------------------------------------------------------------


def turning(theta, way, speed, time, form="all"):
    effect = EFFECTS["wheel-imbalance"].with_choice(form)
    return np.stack(effect.forces(theta, SETTING, time, way, speed), axis=1)


@given(st.integers(0, 3), st.floats(0.01, 1.0), st.floats(0.0, 6.28), st.floats(1.0, 30.0))
def test_an_imbalance_pulls_once_a_turn_with_u_omega_squared(corner, u, phase, speed):
    time = np.linspace(0.0, 10.3, 4001)
    way = np.repeat(speed * time[:, None], 4, axis=1)
    names = ("front_left", "front_right", "rear_left", "rear_right")
    theta = {"front_m": 0.3, "rear_m": 0.25}
    theta |= {f"{names[corner]}_cos_m": u * np.cos(phase)}
    theta |= {f"{names[corner]}_sin_m": u * np.sin(phase)}
    force = turning(theta, way, np.full_like(way, speed), time)
    omega = speed / (0.3 if corner < 2 else 0.25)
    expected = u * omega**2 * np.cos(omega * (time - 10.3 / 2) - phase)
    np.testing.assert_allclose(force[:, corner], expected, atol=1e-6 * u * omega**2)
    assert not np.delete(force, corner, axis=1).any()


def test_an_imbalance_follows_its_own_wheel_as_its_speed_changes():
    time = np.linspace(0.0, 10.3, 8001)
    way = np.stack([5.0 * time + 0.1 * i * time**2 for i in range(4)], axis=1)
    speed = np.stack([5.0 + 0.2 * i * time for i in range(4)], axis=1)
    theta = {"front_m": 0.3, "rear_m": 0.3, "rear_right_cos_m": 0.1}
    force = turning(theta, way, speed, time)[:, 3]
    up = np.flatnonzero((force[:-1] < 0) & (force[1:] >= 0))
    turns = np.diff(way[up, 3]) / (2 * np.pi * 0.3)
    np.testing.assert_allclose(turns, 1.0, atol=0.01)
    peaks = np.maximum.reduceat(force, up)[:-1]
    omega_then = np.interp(way[up[:-1], 3] + np.pi / 2 * 0.3, way[:, 3], speed[:, 3]) / 0.3
    np.testing.assert_allclose(peaks, 0.1 * omega_then**2, rtol=0.01)


class Turning:
    """Records of three runs in which something turns with the front wheels."""

    def __init__(self, radius, seed):
        rng = np.random.default_rng(seed)
        self.time = np.arange(1024) / 100.0
        self.values = ATV
        self.settings = [RunSetting(f"{v}", v, -4.0, 0.0, 10.3, True) for v in (3.0, 4.1, 5.3)]
        self.records = {}
        for setting in self.settings:
            angle = setting.speed_m_s * self.time / radius + rng.uniform(0, 2 * np.pi)
            noise = rng.normal(size=(1024, 8))
            self.records[setting.run_id] = 0.5 * np.cos(angle)[:, None] + noise

    def measured(self, run_id):
        return self.records[run_id]

    def modelled(self, run_id, changes):
        return np.zeros((1024, 8))

    def time_s(self, run_id):
        return self.time

    def way_m(self, run_id):
        return np.repeat(float(run_id) * self.time[:, None], 4, axis=1)


@given(st.floats(0.96, 1.04), st.integers(0, 2**32 - 1))
def test_an_imbalance_finds_the_radius_its_wheel_rolls_on(ratio, seed):
    """A line half as strong as the noise: to 0.3 %, less than a radian over half a record."""
    radius = ratio * ATV["wheel.front.radius_m"]
    effect = EFFECTS["wheel-imbalance"].with_choice("front_left")
    (start,) = effect.shape_starts(Turning(radius, seed))
    assert start == {"front_m": pytest.approx(radius, rel=3e-3)}


@pytest.mark.parametrize("exponent", [0.0, 2.0])
def test_imbalance_summary_tells_run_out_from_imbalance(exponent):
    """Force ∝ speed²: one imbalance, exponent 2. The same force at every speed: exponent 0."""
    effect = EFFECTS["wheel-imbalance"].with_choice("rear_left")
    runs = []
    for v in (2.0, 3.0, 4.0, 6.0):
        theta = {**ATV, "rear_left_cos_m": 0.02 * v ** (exponent - 2.0), "rear_left_sin_m": 0.0}
        runs.append(OwnValues(RunSetting(f"{v}", v, -4.0, 0.0, 10.3, True), theta))
    summary = effect.summary(runs)
    assert summary["speed_exponent"] == pytest.approx(exponent, abs=1e-6)
    if exponent == 2.0:
        imbalance = 0.02 * ATV["wheel.rear.unsprung_mass_kg"]
        assert summary["rear_left_kg_m"] == pytest.approx(imbalance)


def test_imbalance_summary_keeps_quiet_about_an_exponent_the_runs_do_not_show():
    effect = EFFECTS["wheel-imbalance"].with_choice("rear_left")
    runs = [
        OwnValues(RunSetting(f"{v}", v, -4.0, 0.0, 10.3, True), {**ATV, "rear_left_cos_m": u})
        for v, u in ((2.0, 0.1), (3.0, 0.9), (4.0, 0.05), (6.0, 0.2))
    ]
    assert set(effect.summary(runs)) == {"rear_left_kg_m"}


def test_an_imbalance_pushes_its_axle():
    parts = baseline(ATV, CHANNELS, "road")
    EFFECTS["wheel-imbalance"].with_choice("rear_left").modify({"rear_m": 0.28}, ATV, parts)
    force = parts.system(body_inertia(ATV)).force
    mass = ATV["wheel.rear.unsprung_mass_kg"]
    np.testing.assert_allclose(force[:, 0], [0, 0, 0, 0, 0, mass, 0])


# --- tyre envelope ------------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["path", "ground"])
def test_a_contact_without_length_is_the_rigid_wheel(form):
    run = {"herringbone": RUNS["herringbone"]}
    rigid = simulated(campaign_of(run), model_of(ATV, run))["herringbone"]
    theta = {"front_m": 0.0, "rear_m": 0.0}
    model = model_of(ATV, run, "tyre-envelope", theta, choice=form)
    assert relative(simulated(campaign_of(run), model)["herringbone"], rigid) < 1e-4


@pytest.mark.parametrize("form", ["path", "ground", "footprint"])
def test_a_contact_as_long_as_a_wave_feels_none_of_it(form):
    """The mean of a sine over its period is nought, of whatever is averaged first."""
    track = truth.Track("washboard", {"amplitude_mm": 5.0, "pitch_mm": 500.0})
    run = {"waves": truth.Run(track, 4.0, 35.0, TIME)}
    theta = {"front_m": 0.5, "rear_m": 0.5, "follows": 1.0}
    model = model_of(ATV, run, "tyre-envelope", theta, choice=form)
    felt = simulated(campaign_of(run), model)["waves"]
    rigid = simulated(campaign_of(run), model_of(ATV, run))["waves"]
    assert np.abs(felt).max() < 1e-3 * np.abs(rigid).max()


def test_a_wheel_that_shrunk_to_nothing_leaves_only_the_footprint():
    """A baseline that seeks to follow the ground makes its wheels tiny; path and ground are then
    the same as a footprint, and would hold the wheels where they are."""
    shrunk = {**ATV, "wheel.front.radius_m": 0.006, "wheel.rear.radius_m": 0.006}
    effect = EFFECTS["tyre-envelope"]
    for form in effect.choices(CHANNELS):
        applies = bool(effect.with_choice(form).parameters_for(shrunk, CHANNELS))
        assert applies == (form == "footprint")
        assert effect.with_choice(form).parameters_for(ATV, CHANNELS)
