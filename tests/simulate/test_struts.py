"""Travel and force of the struts of a model, whatever drives it and whatever is measured."""

from dataclasses import replace

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, campaign_of, model_of, relative
from tests.simulate.test_against_mujoco import CASES, REACHED, RUNS
from tests.simulate.test_readings import POINTS, POTS, SENSORS
from tests.simulate.test_travel_drives import unsurveyed
from wheelhop.campaign import TrackSpec
from wheelhop.compare import InBand
from wheelhop.simulate import RunSimulator
from wheelhop.simulate.measured import offset_name
from wheelhop.simulate.struts import strut_motion

LAWS = ("nothing", "dry-friction that creeps", "progressive-spring cubic", "asymmetric-damper")
ALONG_TRAVEL = 0.05
"""As far as bodies moved by sampled travel are from what moved it, and a little: forces are not
smoothed by a mass."""


def shown(case, run_id="twist"):
    """What four pots and four strain gauges of another simulator show, per wheel, and a model that
    has the same law."""
    effect, choice, theta, theirs = CASES[case]
    physics = truth.make_effects({effect: theirs} if effect else {})
    seen = (*SENSORS[:4], *SENSORS[6:])
    recorded = truth.sense(ATV, RUNS[run_id], seen, physics) / [s.scale for s in seen]
    return physics, recorded, model_of(ATV, RUNS, effect, theta, choice=choice)


@pytest.mark.parametrize("case", LAWS)
def test_struts_do_as_in_another_simulator(case):
    """No channel need show them: here there are accelerometers alone."""
    _, recorded, model = shown(case)
    record = np.zeros((len(recorded), len(POINTS)))
    campaign = campaign_of({"twist": RUNS["twist"]}, {"twist": record}, channels=POINTS)
    simulator = RunSimulator(campaign, campaign.runs[0], 4.0)
    ((travel, force),) = strut_motion(model, [simulator])
    assert relative(travel, recorded[:, :4]) < REACHED
    assert relative(force, recorded[:, 4:]) < REACHED


def test_measured_travel_is_travel_and_gives_the_force():
    """On a road nobody knows."""
    physics, recorded, model = shown("dry-friction that creeps")
    campaign, _ = unsurveyed("twist", physics)
    rest = {offset_name(i): -float(mean) for i, mean in enumerate(recorded[:, :4].mean(axis=0))}
    simulator = RunSimulator(campaign, campaign.runs[0], 0.0)
    ((travel, force),) = strut_motion(model.with_run("twist", rest), [simulator])
    assert relative(travel, recorded[:, :4]) < REACHED
    assert relative(force, recorded[:, 4:]) < ALONG_TRAVEL


def test_measured_axles_give_travel_in_band():
    """What is slower is not known of them."""
    physics, recorded, model = shown("nothing")
    seen = [replace(s, name=c.name, quantity="acceleration", where=c.name, scale=1.0)
            for s, c in zip([SENSORS[0]] * 8, POINTS, strict=True)]  # fmt: skip
    record = truth.sense(ATV, RUNS["twist"], seen, physics)
    campaign = campaign_of({"twist": RUNS["twist"]}, {"twist": record}, channels=POINTS)
    run = replace(campaign.runs[0], track=TrackSpec("unknown", {}))
    simulator = RunSimulator(replace(campaign, runs=(run,)), run, 2.0)
    assert simulator.drive == "axles"
    ((travel, _),) = strut_motion(model, [simulator])
    band = InBand(len(travel), campaign.sample_rate_hz, (1.0, 30.0))
    middle = slice(len(travel) // 4, -len(travel) // 4)
    ours, theirs = band.signal(travel)[middle], band.signal(recorded[:, :4])[middle]
    assert relative(ours, theirs) < 0.05


def test_pots_change_nothing_of_what_struts_do():
    model = shown("nothing")[2]
    found = []
    for channels in (POINTS, (*POINTS, *POTS)):
        record = np.zeros((len(RUNS["twist"].time_s), len(channels)))
        campaign = campaign_of({"twist": RUNS["twist"]}, {"twist": record}, channels=channels)
        found += strut_motion(model, [RunSimulator(campaign, campaign.runs[0], 4.0)])
    np.testing.assert_allclose(found[0][0], found[1][0], rtol=0, atol=1e-12)
