"""Measured travel of the struts moves the body: no track, no tyre, no speed."""

from dataclasses import replace

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, campaign_of, model_of, relative, simulated
from tests.simulate.test_against_mujoco import CASES, RUNS
from tests.simulate.test_readings import GYROS, POTS, SENSORS, parts, response
from tests.truth.sensors import Sensor
from wheelhop.campaign import Channel, TrackSpec
from wheelhop.simulate import RunSimulator, drive_of
from wheelhop.simulate.measured import offset_name
from wheelhop.vehicle import struts

BODY = tuple(Channel(f"B{i}", f"B{i}") for i in (1, 2, 3, 4))
CHANNELS = (*POTS, *BODY, *GYROS)
SEEN = (
    *SENSORS[:4],
    *(Sensor(f"B{i}", "acceleration", f"B{i}", 0.0) for i in (1, 2, 3, 4)),
    *SENSORS[4:6],
)
ON_BODY = slice(4, None)

REACHED = 0.04
"""What a spline through samples 10 ms apart misses of dampers' speeds and of friction's turns."""


def unsurveyed(run_id, physics, channels=CHANNELS, seen=SEEN):
    """A run as pots and the body's sensors recorded it, on a road nobody knows."""
    recorded = truth.sense(ATV, RUNS[run_id], seen, physics)
    campaign = campaign_of({run_id: RUNS[run_id]}, {run_id: recorded}, channels=channels)
    runs = tuple(replace(run, track=TrackSpec("unknown", {})) for run in campaign.runs)
    return replace(campaign, runs=runs), recorded


def test_forces_along_imposed_travel_move_the_body():
    """M q̈ = −Σ Pᵀ (k δ + c δ̇): heave by Newton, pitch and roll by their moments."""
    body, axle, pot, _, rod = parts(response("travel"))
    assert all(np.isnan(part).all() for part in (axle, pot, rod))
    omega = 2 * np.pi * np.linspace(0.4, 35.0, 60)[:, None]
    force = np.array([s.stiffness_N_m + 1j * omega * s.damping_N_s_m for s in struts(ATV)])
    x = ATV["geometry.cg_to_front_axle_m"] - np.array([0, 0, 1, 1]) * ATV["geometry.wheelbase_m"]
    y = np.array([1, -1, 1, -1]) * ATV["geometry.track_width_m"] / 2
    for strut in range(4):
        push = -force[strut][:, 0]
        heave = push / ATV["body.mass_kg"]
        pitch = -x[strut] * push / ATV["body.pitch_inertia_kg_m2"]
        roll = y[strut] * push / ATV["body.roll_inertia_kg_m2"]
        expected = heave[:, None] - np.outer(pitch, x) + np.outer(roll, y)
        np.testing.assert_allclose(body[:, :, strut], expected, rtol=1e-9)


ALONG_STRUTS = (
    *("nothing", "dry-friction that creeps", "dry-friction", "progressive-spring cubic"),
    *("progressive-spring air", "asymmetric-damper", "digressive-damper", "bump-stop"),
    *("backlash", "mount-bushing", "anti-roll-bar", "driver-seat"),
)


@pytest.mark.parametrize("case", ALONG_STRUTS)
def test_the_body_moves_as_in_another_simulator(case):
    """From the samples of four pots, whatever law is in the struts."""
    effect, choice, theta, theirs = CASES[case]
    physics = truth.make_effects({effect: theirs} if effect else {})
    campaign, recorded = unsurveyed("twist", physics)
    assert drive_of(campaign, campaign.runs[0]) == "travel"
    # Struts rest where they are at rest, not at their mean in the run.
    travel = recorded[:, :4] / np.array([pot.per_wheel for pot in POTS])
    rest = {offset_name(i): -float(mean) for i, mean in enumerate(travel.mean(axis=0))}
    model = model_of(ATV, {"twist": RUNS["twist"]}, effect, theta, choice=choice)
    ours = simulated(campaign, model.with_run("twist", rest))["twist"]
    assert relative(ours[:, 4:8], recorded[:, 4:8]) < REACHED
    assert relative(ours[:, 8:], recorded[:, 8:]) < REACHED
    assert np.isnan(ours[:, :4]).all()


def test_where_struts_rest_moves_what_is_not_linear():
    """A stop is met sooner by a strut that rests nearer to it; a linear one does not care."""
    campaign, _ = unsurveyed("twist", ())
    run = {"twist": RUNS["twist"]}
    effect, choice, theta, _ = CASES["bump-stop"]
    for model, moves in (
        (model_of(ATV, run), False),
        (model_of(ATV, run, effect, theta, choice=choice), True),
    ):
        moved = model.with_run("twist", {offset_name(0): 0.01})
        still, there = (simulated(campaign, each)["twist"][:, 4:8] for each in (model, moved))
        assert (relative(there, still) > 0.01) is moves


def test_a_reversed_pot_that_is_known_moves_the_body_the_right_way():
    """What sensors do to what drives is undone, as of measured axles."""
    campaign, recorded = unsurveyed("twist", ())
    turned = recorded.copy()
    turned[:, 1] *= -1.0
    runs = tuple(replace(run, record=turned) for run in campaign.runs)
    model = model_of(
        ATV, {"twist": RUNS["twist"]}, "sensor-polarity", {"wrong": 1.0}, choice="pot2"
    )
    found = simulated(replace(campaign, runs=runs), model)["twist"]
    assert relative(found[:, 4:8], recorded[:, 4:8]) < REACHED


def test_axles_that_are_measured_drive_before_travel_does():
    hubs = tuple(Channel(f"A{i}", f"A{i}") for i in (1, 2, 3, 4))
    seen = (*SEEN, *(Sensor(f"A{i}", "acceleration", f"A{i}", 0.0) for i in (1, 2, 3, 4)))
    campaign, _ = unsurveyed("twist", (), (*CHANNELS, *hubs), seen)
    assert RunSimulator(campaign, campaign.runs[0], 0.0).drive == "axles"
