"""What an effect may see of the runs while it seeks where its fit may begin."""

import numpy as np
import pytest

from tests.report.small import write_small_campaign
from tests.simulate.setup import ATV, campaign_of, model_of
from tests.simulate.test_against_mujoco import RUNS
from wheelhop.campaign import Channel, read_campaign
from wheelhop.diagnose.baseline import fit_baseline
from wheelhop.fit import FitProbe, Workshop
from wheelhop.vehicle import read_nominal

RUN = "washboard-low-fast"


@pytest.fixture(scope="module")
def base(tmp_path_factory):
    campaign = read_campaign(write_small_campaign(tmp_path_factory.mktemp("probe")))
    return fit_baseline(campaign, read_nominal(campaign), jobs=1, progress=lambda text: None)


def test_travel_is_what_the_struts_ends_differ_by_integrated_twice(base):
    """One column a strut, left and right of each end; its acceleration in band is that of body over
    axle, but for its own ends, where what is slower than the band is cut off."""
    bench = base.workshop.benches[RUN]
    travel = FitProbe(base.workshop, base.rung.model, [bench]).travel(RUN)
    model = base.rung.model
    record = bench.response(model, base.workshop.systems(model)).record
    at = {(c.corner, c.is_axle): i for i, c in enumerate(base.workshop.campaign.channels)}
    assert set(travel) == {"front", "rear"}
    for end, corners in (("front", (0, 1)), ("rear", (2, 3))):
        assert travel[end].shape == (len(bench.run.time_s), 2)
        for column, corner in zip(travel[end].T, corners, strict=True):
            relative = record[:, at[corner, False]] - record[:, at[corner, True]]
            omega = 2.0 * np.pi * np.tile(bench.band.frequency_hz, 2)
            expected = bench.band.coefficients(relative)
            found = -(omega**2) * bench.band.coefficients(column)
            assert np.linalg.norm(found - expected) < 0.2 * np.linalg.norm(expected)


def test_travel_that_is_measured_is_what_its_channel_shows():
    """Per wheel, in band; what drives the model is not predicted, and is the record itself."""
    run = {"twist": RUNS["twist"]}
    pot = Channel("pot", "S3", quantity="travel", unit="m", per_wheel=0.5)
    channels = (Channel("B1", "B1"), pot)
    model = model_of(ATV, run)
    workshop = Workshop(campaign_of(run, channels=channels, noise_rms=0.1), model)
    bench = workshop.benches["twist"]
    travel = FitProbe(workshop, model, [bench]).travel("twist")
    record = bench.response(model, workshop.systems(model)).record
    assert set(travel) == {"rear"}
    np.testing.assert_allclose(travel["rear"], bench.band.signal(record[:, 1:] / 0.5), atol=1e-12)
