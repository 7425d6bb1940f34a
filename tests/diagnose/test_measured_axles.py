"""Nobody knows the track: what the axles were recorded to do drives the body."""

import pytest

from tests import truth
from tests.diagnose.cases import CASES, LIBRARY
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import diagnose
from wheelhop.diagnose.baseline import axle_driven
from wheelhop.vehicle import read_vehicle


@pytest.mark.parametrize(
    "name",
    ["clean", "driver-seat", pytest.param("dry-friction", marks=pytest.mark.slow)],
)
def test_the_verdict_on_measured_axles(name, tmp_path):
    """Sharp washboards among the runs fold motion from above half the sample rate into the axles'
    records; nothing is made of it."""
    case = CASES[name]
    folder = truth.make_campaign(tmp_path, seed=case.seed, effects=case.hidden, short=True)
    campaign = read_campaign(folder)
    vehicle = read_vehicle(campaign.vehicle_file)
    axles = axle_driven(campaign, vehicle)
    assert axles is not None
    found = diagnose(axles, vehicle, LIBRARY, jobs=1)
    assert found.verdict == case.verdict
    assert found.confidence > 0.9
    assert found.ladder[-1].over_floor < 1.1
