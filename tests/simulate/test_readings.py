"""What is measured besides accelerations: travel and force of a strut, rates of the body."""

from dataclasses import replace

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, EFFECTS, campaign_of, model_of, relative, simulated
from tests.simulate.test_against_mujoco import CASES, REACHED, RUNS
from tests.truth.sensors import Sensor
from wheelhop.campaign import Channel
from wheelhop.fit import Ground, Workshop
from wheelhop.simulate import RunSimulator, frequency_response
from wheelhop.simulate.frequency import ForceResponse
from wheelhop.vehicle import struts

RATIO = 0.65
POTS = tuple(
    Channel(f"pot{i}", f"S{i}", quantity="travel", unit="m", per_wheel=RATIO) for i in (1, 2, 3, 4)
)
RODS = tuple(
    Channel(f"rod{i}", f"S{i}", quantity="force", unit="N", per_wheel=-1.4) for i in (1, 2, 3, 4)
)
GYROS = tuple(Channel(axis, axis, quantity="rate", unit="rad/s") for axis in ("pitch", "roll"))
POINTS = tuple(Channel(f"{p}{i}", f"{p}{i}") for p in "BA" for i in (1, 2, 3, 4))
EVERY = (*POINTS, *POTS, *GYROS, *RODS)
FREQUENCY = np.linspace(0.4, 35.0, 60)
OMEGA = 2 * np.pi * FREQUENCY[:, None, None]

SENSORS = (
    *(Sensor(f"pot{i}", "travel", str(i), 0.0, RATIO) for i in (1, 2, 3, 4)),
    *(Sensor(axis, "rate", axis, 0.0) for axis in ("pitch", "roll")),
    *(Sensor(f"rod{i}", "force", str(i), 0.0, -1.4) for i in (1, 2, 3, 4)),
)
OF_THE_VEHICLE = [
    case for case, (effect, *_) in CASES.items() if not effect or EFFECTS[effect].place != "sensor"
]


def response(drive, channels=EVERY):
    return frequency_response(model_of(ATV, RUNS).system(channels, drive), FREQUENCY)


def parts(shown):
    """Body points, axles, pots, gyros, rods."""
    return np.split(shown, [4, 8, 12, 14], axis=1)


def test_travel_twice_differentiated_is_body_less_axle():
    body, axle, pot, _, _ = parts(response("road"))
    np.testing.assert_allclose(-(OMEGA**2) * pot, RATIO * (body - axle), rtol=1e-9, atol=1e-9)


def test_on_measured_axles_travel_and_force_are_not_predicted():
    """What drifts below the band is taken out of measured axles, and travel would show it."""
    body, axle, pot, gyro, rod = parts(response("axles"))
    assert all(np.isnan(part).all() for part in (axle, pot, rod))
    assert np.isfinite(body).all() and np.isfinite(gyro).all()


@pytest.mark.parametrize("drive", ["road", "axles"])
def test_rates_differentiated_are_differences_over_the_body(drive):
    """Pitch positive nose down, roll positive left side up."""
    body, _, _, gyro, _ = parts(response(drive))
    length, width = ATV["geometry.wheelbase_m"], ATV["geometry.track_width_m"]
    pitch, roll = (body[:, 2] - body[:, 0]) / length, (body[:, 0] - body[:, 1]) / width
    expected = np.stack([pitch, roll], axis=1)
    np.testing.assert_allclose(1j * OMEGA * gyro, expected, rtol=1e-9, atol=1e-9)


def test_forces_move_the_body():
    """Newton: mass times heave is the pull of all four struts, their tension downwards."""
    body, _, pot, _, rod = parts(response("road"))
    tension = rod / -1.4
    ahead = ATV["geometry.cg_to_front_axle_m"] / ATV["geometry.wheelbase_m"]
    heave = (1 - ahead) * (body[:, 0] + body[:, 1]) / 2 + ahead * (body[:, 2] + body[:, 3]) / 2
    pull = -tension.sum(axis=1) / ATV["body.mass_kg"]
    np.testing.assert_allclose(pull, heave, rtol=1e-9, atol=1e-9)
    spring = np.array([s.stiffness_N_m for s in struts(ATV)])[:, None]
    damper = np.array([s.damping_N_s_m for s in struts(ATV)])[:, None]
    np.testing.assert_allclose(tension, (spring + 1j * OMEGA * damper) * pot / RATIO, rtol=1e-9)


def test_accelerations_are_the_same_beside_readings():
    """Readings have coordinates of their own in the integration, which act on nothing."""
    run = {"twist": RUNS["twist"]}
    _, choice, theta, _ = CASES["dry-friction"]
    model = model_of(ATV, run, "dry-friction", theta, choice=choice)
    alone = simulated(campaign_of(run, channels=POINTS), model)["twist"]
    beside = simulated(campaign_of(run, channels=EVERY), model)["twist"]
    np.testing.assert_allclose(beside[:, :8], alone, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("case", OF_THE_VEHICLE)
def test_readings_agree_with_another_simulator(case):
    """With every law of the library: forces hold what the laws add, or take away."""
    effect, choice, theta, theirs = CASES[case]
    run = {"twist": RUNS["twist"]}
    physics = truth.make_effects({effect: theirs} if effect else {})
    measured = truth.sense(ATV, RUNS["twist"], SENSORS, physics)
    model = model_of(ATV, run, effect, theta, choice=choice)
    ours = simulated(campaign_of(run, channels=(*POTS, *GYROS, *RODS)), model)["twist"]
    travel, rate, force = np.split(ours, [4, 6], axis=1)
    assert relative(travel, measured[:, :4]) < REACHED
    assert relative(rate, measured[:, 4:6]) < REACHED
    assert relative(force, measured[:, 6:]) < REACHED


def test_the_response_to_a_force_is_that_of_its_integration():
    """An engine shakes the body: derivatives by its force are superposed, not integrated."""
    run = {"twist": RUNS["twist"]}
    campaign = campaign_of(run, channels=EVERY)
    own = {"cos_m_s2": 0.4, "sin_m_s2": -0.2}
    model = model_of(ATV, run, "engine-vibration", {"freq_hz": 14.0}, own=own)
    still = model.with_run("twist", {f"engine-vibration.{name}": 0.0 for name in own})
    simulator = RunSimulator(campaign, campaign.runs[0], 4.0)
    system = model.system(campaign.channels, "road")
    (change,) = simulator.changes((still, system), [(model, system)])
    fresh = RunSimulator(campaign, campaign.runs[0], 4.0)
    whole = fresh.record(model, model.system(campaign.channels, "road"))
    rest = simulated(campaign, still)["twist"]
    for part in (slice(0, 8), slice(8, 12), slice(12, 14), slice(14, 18)):
        assert relative(change[:, part], (whole - rest)[:, part]) < 0.01


def test_a_constant_force_lets_travel_rest_where_springs_hold_it():
    """Lifted by its weight, all four struts together pull as much."""
    campaign = campaign_of({"twist": RUNS["twist"]}, channels=EVERY)
    engine = model_of(ATV, RUNS).with_effect(EFFECTS["engine-vibration"], ())
    engine = engine.with_values({"engine-vibration.freq_hz": 1.0})
    system = engine.system(EVERY, "road")
    pushed = ForceResponse(system, 4000, 0, 0.01, campaign.averaging)(np.ones((4000, 1)))
    held = (pushed[-1, 14:] / -1.4).sum()
    assert held == pytest.approx(ATV["body.mass_kg"], rel=1e-6)


def test_exchanged_channels_are_of_one_quantity():
    choices = EFFECTS["sensor-polarity"].choices(EVERY)
    assert {"pot1/pot4", "B1/A2", "pitch/roll", "rod2"} <= set(choices)
    assert not {"pot1/B1", "B1/pitch", "pot1/rod1"} & set(choices)
    for fault in ("sensor-clipping", "sensor-mount"):
        assert set(EFFECTS[fault].choices(EVERY)) - {"all"} == {c.name for c in POINTS}


def test_heights_nobody_knows_are_heard_by_every_channel_in_units_of_its_noise():
    """To first order, what small waves of the ground do to a record."""
    run = {"twist": RUNS["twist"]}
    quantities = {"acceleration": 0.1, "travel": 2e-4, "rate": 0.004, "force": 8.0}
    channels = tuple(replace(c, noise_rms=quantities[c.quantity]) for c in EVERY)
    model = model_of(ATV, run)
    workshop = Workshop(campaign_of(run, channels=channels, noise_rms=0.1), model)
    bench, systems = workshop.benches["twist"], workshop.systems(model)
    count = bench.simulator.series.count
    rng = np.random.default_rng(2)
    heights = 1e-6 * (rng.normal(size=(2, 2, count)).T @ [1.0, 1.0j]).T
    rough = model.with_heights({"twist": heights})
    records = bench.records([(model, systems), (rough, systems)])
    change = bench.coefficients(records[1] - records[0]).reshape(bench.band.count, -1)
    ground = Ground(bench, model, systems["road"])
    heard = ground.apply(heights.reshape(-1, 1))[:, 0].reshape(bench.band.count, -1)
    for column in range(len(channels)):
        error = np.linalg.norm(heard[:, column] - change[:, column])
        assert error < 0.15 * np.linalg.norm(change[:, column]), channels[column].name
