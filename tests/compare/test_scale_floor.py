"""What scales and measured axles that drive a model may add to the floor."""

from dataclasses import replace

import numpy as np
import pytest

from tests.campaign.build import write_campaign
from wheelhop.calibration import nominal_constants, write_constants
from wheelhop.campaign import read_campaign
from wheelhop.compare.breakdown import breakdown
from wheelhop.compare.floor import noise_floor
from wheelhop.compare.records import in_band
from wheelhop.simulate import Response


def test_a_calibration_beside_the_campaign_says_how_well_scales_are_known(tmp_path):
    folder = write_campaign(tmp_path / "c")
    assert {c.scale_uncertainty for c in read_campaign(folder).channels} == {0.0}
    write_constants(nominal_constants(["A1", "B1"]), folder / "calibration.toml")
    known = {c.name: c.scale_uncertainty for c in read_campaign(folder).channels}
    # Data sheet: gain ± 10 %, across the axis ± 1 %, both rectangular.
    assert known["A1"] == pytest.approx(np.hypot(0.10, 0.01) / np.sqrt(3), rel=1e-6)
    assert known["A2"] == 0.0


def test_scales_may_add_their_share_of_the_measured_power(tmp_path):
    folder = write_campaign(tmp_path / "c")
    campaign = read_campaign(folder)

    records = in_band(campaign, [Response(run.id, run.record, None) for run in campaign.runs])
    sure = noise_floor(campaign, records)
    unsure = replace(
        campaign, channels=tuple(replace(c, scale_uncertainty=0.03) for c in campaign.channels)
    )
    floor = noise_floor(unsure, records)
    assert floor.expected == pytest.approx(np.hypot(sure.error, 0.03), rel=1e-9)
    assert floor.error == sure.error == sure.expected
    assert np.array_equal(floor.noise_rms, sure.noise_rms)
    assert "scales" in floor.beside_noise and not sure.beside_noise


def test_uncertain_axle_motion_is_in_every_cut_alike(tmp_path):
    """The noise of the axles' sensors in the floor, what is folded into their records beside it."""
    campaign = read_campaign(write_campaign(tmp_path / "c"))
    rng = np.random.default_rng(1)
    records = [
        replace(
            record,
            doubt=rng.uniform(5.0, 9.0, record.measured.shape),
            noise_ratio=rng.uniform(1.0, 5.0, record.measured.shape),
        )
        for record in in_band(
            campaign, [Response(r.id, 0.5 * r.record, None) for r in campaign.runs]
        )
    ]
    unheard = np.array([channel.is_axle for channel in campaign.channels])
    for record in records:  # the axles drive the model: it does not predict them
        record.predicted[unheard], record.doubt[:, unheard] = False, np.nan
        record.noise_ratio[:, unheard] = np.nan
        record.measured[:, unheard] = record.residual[:, unheard] = 0.0
    floor = noise_floor(campaign, records)
    sure = noise_floor(
        campaign, [replace(record, doubt=None, noise_ratio=None) for record in records]
    )
    assert floor.error > 2.5 * sure.error and floor.expected > 2.0 * floor.error
    assert "folded" in floor.beside_noise
    where = breakdown(campaign, records, floor)
    assert where.total.floor == pytest.approx(floor.error, rel=1e-9)
    expected = where.total.expected(0.0) / where.total.measured
    assert expected == pytest.approx(floor.expected**2, rel=1e-9)
    for cut in (where.run, where.channel, where.band, where.motion, where.time, where.amplitude):
        assert sum(part.noise for part in cut) == pytest.approx(where.total.noise, rel=1e-9)
        assert sum(part.folded for part in cut) == pytest.approx(where.total.folded, rel=1e-9)
    assert where.locking.noise == pytest.approx(where.total.noise / where.total.residual, rel=1e-9)
