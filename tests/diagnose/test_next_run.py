"""The run to record next: when it has been driven, the doubt is settled as was expected."""

from dataclasses import replace

import numpy as np
import pytest

from tests import truth
from tests.diagnose.cases import LIBRARY, diagnosed
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import diagnose
from wheelhop.diagnose.next_run import angle_deg
from wheelhop.vehicle import read_vehicle

FAINT = {"digressive-damper": {"knee_m_s": 0.15, "slope_ratio": 0.95}}
TWO = ("dry-friction", "digressive-damper")


def log_odds(diagnosis):
    """Of the damper over friction, on the first rung."""
    evidence = {ranked.effect: ranked.evidence for ranked in diagnosis.ranking}
    return evidence["digressive-damper"] - evidence["dry-friction"]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Two runs over the lowest washboard: hardly enough to tell a damper's knee from friction."""
    folder = truth.make_campaign(
        tmp_path_factory.mktemp("faint"), seed=13, effects=FAINT, short=False
    )
    whole = read_campaign(folder)
    few = [run for run in whole.runs if run.id.startswith("washboard-low")]
    return folder, replace(whole, runs=tuple(few))


@pytest.mark.slow
def test_the_proposed_run_settles_the_doubt(recorded):
    folder, campaign = recorded
    vehicle = read_vehicle(campaign.vehicle_file)
    library = {name: LIBRARY[name] for name in TWO}
    doubtful = diagnose(campaign, vehicle, library, jobs=1)
    advice = doubtful.next_run
    assert advice is not None
    assert set(advice.separates) == set(TWO)
    assert advice.expected_log_odds > 0.0

    known = truth.read_truth(folder)
    like = next(run for run in campaign.runs if run.id == advice.like)
    driven = replace(
        known.runs[like.id], speed_m_s=advice.speed_kmph / 3.6, start_m=37.0, seed=4242
    )
    noise = np.random.default_rng(5).normal(size=like.record.shape)
    record = truth.simulate_run(known.vehicle, driven, known.effects)[1] + 0.13 * noise
    run = replace(like, id="next", role="fit", speed_m_s=driven.speed_m_s, record=record)
    settled = diagnose(replace(campaign, runs=(*campaign.runs, run)), vehicle, library, jobs=1)

    assert settled.verdict[0] == "digressive-damper"
    assert log_odds(settled) - log_odds(doubtful) > 0.3 * advice.expected_log_odds


def test_no_doubt_no_advice(tmp_path):
    folder = truth.make_campaign(
        tmp_path, seed=101, effects={}, short=True, seconds=6.4, draft=True
    )
    library = {name: LIBRARY[name] for name in TWO}
    assert diagnosed(folder, library).next_run is None


def test_angles_do_not_depend_on_sign_or_size():
    a, b = np.array([1.0, 0.0]), np.array([1.0, 1.0])
    assert angle_deg(a, b) == pytest.approx(45.0)
    assert angle_deg(-3 * a, b) == pytest.approx(45.0)
    assert angle_deg(a, 0 * b) == 90.0
