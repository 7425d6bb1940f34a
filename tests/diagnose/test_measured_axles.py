"""Nobody knows the track: what the axles were recorded to do drives the body."""

import numpy as np
import pytest

from tests import truth
from tests.diagnose.cases import CASES, LIBRARY
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import diagnose
from wheelhop.diagnose.baseline import axle_driven
from wheelhop.vehicle import read_vehicle


@pytest.mark.parametrize(
    "name",
    [
        "driver-seat",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("clean", "dry-friction")),
    ],
)
def test_the_verdict_on_measured_axles(name, tmp_path):
    """Sharp washboards among the runs fold motion from above half the sample rate into the axles'
    records; nothing is made of it."""
    case = CASES[name]
    folder = truth.make_campaign(
        tmp_path, seed=case.seed, effects=case.hidden, short=True, seconds=6.4, draft=True
    )
    campaign = read_campaign(folder)
    vehicle = read_vehicle(campaign.vehicle_file)
    axles = axle_driven(campaign, vehicle)
    assert axles is not None
    found = diagnose(axles, vehicle, LIBRARY, jobs=1)
    assert found.verdict == case.verdict
    assert found.confidence > 0.9
    assert found.ladder[-1].over_floor < 1.1


@pytest.mark.slow
@pytest.mark.parametrize("zeta", [0.05, 0.01])
def test_a_loose_sensor_on_an_axle_that_drives_the_body(zeta, tmp_path):
    """Its motion is restored before it drives; it was knocked, too, just before each record. What
    is left is no larger in the outer tenths of a second, where the restoring must guess."""
    loose = {"channel": "A3", "freq_hz": 24.5, "zeta": zeta, "struck_m_s": 0.1}
    folder = truth.make_campaign(tmp_path, seed=101, effects={"sensor-mount": loose}, short=True)
    campaign = read_campaign(folder)
    vehicle = read_vehicle(campaign.vehicle_file)
    axles = axle_driven(campaign, vehicle)
    assert axles is not None
    faults = {name: effect for name, effect in LIBRARY.items() if effect.place == "sensor"}
    found = diagnose(axles, vehicle, faults, jobs=1)
    assert found.verdict == ("sensor-mount",)
    assert found.ladder[-1].over_floor < 1.1
    values = found.ladder[-1].rung.model.values
    assert values["sensor-mount.freq_hz"] == pytest.approx(24.5, rel=0.01)
    assert values["sensor-mount.zeta"] == pytest.approx(zeta, rel=0.1)
    left = [
        run.bench.band.from_coefficients(
            run.bench.undoubted(run.residual).reshape(run.bench.band.count, -1)
        )
        for rung in [found.ladder[-1].rung]
        for run in (*rung.fit.runs, *rung.validation.runs)
    ]
    outer = sum(float(np.sum(r[:10] ** 2) + np.sum(r[-10:] ** 2)) for r in left)
    share, of_time = outer / sum(float(np.sum(r**2)) for r in left), 20 * len(left)
    assert share < 1.4 * of_time / sum(len(r) for r in left)
