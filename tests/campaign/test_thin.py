"""A fast recording is thinned to its band: what a slower instrument would have recorded."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import read_campaign
from wheelhop.campaign.thin import thinned
from wheelhop.effects import load_effects
from wheelhop.gate import gate
from wheelhop.predict import Case, read_drives, read_effects
from wheelhop.simulate.run import RunSimulator
from wheelhop.vehicle import read_nominal, read_vehicle

CLEAN = Path(__file__).parents[2] / "examples/clean"
FAST_HZ, SLOW_HZ = 500.0, 100.0


def fast_campaign(record, averaging_s):
    """The clean campaign, its runs replaced by one record (n, 8) at 500 Hz."""
    campaign = read_campaign(CLEAN)
    run = replace(campaign.runs[0], time_s=np.arange(len(record)) / FAST_HZ, record=record)
    return replace(campaign, sample_rate_hz=FAST_HZ, averaging_s=averaging_s, runs=(run,))


def recorded(campaign, model):
    """What the model says of the campaign's only run."""
    simulator = RunSimulator(campaign, campaign.runs[0], run_up_s=3.0)
    return simulator.record(model, model.system(campaign.channels, "road"))


@pytest.mark.parametrize(("window_s", "off"), [(2e-3, 1e-3), (6.6e-3, 1e-3), (0.0, 5e-3)])
def test_means_of_fast_samples_are_what_the_model_takes_them_for(window_s, off):
    """Dry friction makes overtones far above the slow rate: they fold alike, whether the windows
    of neighbouring samples abut, overlap, or there are none: then a jump may lie between an instant
    and the next step of the integration."""
    drives = read_drives(["washboard/low"], [8.0])
    effects = read_effects(["dry-friction:front_N=80:rear_N=60"], load_effects())
    case = Case(read_vehicle(CLEAN / "vehicle.toml"), effects, drives, 4.0, 1)
    whole, model = case.campaign(noise_rms=0.1)
    run = replace(whole.runs[0], time_s=np.arange(round(4.0 * FAST_HZ)) / FAST_HZ)
    fast = replace(whole, sample_rate_hz=FAST_HZ, averaging_s=window_s, runs=(run,))
    light = thinned(replace(fast, runs=(replace(run, record=recorded(fast, model)),)))
    assert light.sample_rate_hz == SLOW_HZ
    assert light.runs[0].time_s[0] == pytest.approx(2 / FAST_HZ)
    difference = recorded(light, model) - light.runs[0].record
    assert difference.std() < off * light.runs[0].record.std()


def test_the_gate_thins_and_says_so_and_leaves_alone_what_is_slow_enough():
    campaign = read_campaign(CLEAN)
    vehicle = read_nominal(campaign)
    assert thinned(campaign) is campaign
    assert thinned(replace(campaign, band_hz=(0.5, 2.0))).sample_rate_hz == SLOW_HZ
    assert not [f for f in gate(campaign, vehicle).findings if f.kind == "thinned"]
    noise = np.random.default_rng(0).normal(size=(5003, 8))
    fast = fast_campaign(noise, 2e-3)
    gated = gate(fast, vehicle)
    (finding,) = [f for f in gated.findings if f.kind == "thinned"]
    assert "500 Hz" in finding.text and "means of 5 samples, at 100 Hz" in finding.text
    (run,) = gated.campaign.runs
    assert run.record.shape == (1000, 8)
    assert gate(replace(fast, band_hz=(0.5, 140.0)), vehicle).campaign.sample_rate_hz == FAST_HZ
