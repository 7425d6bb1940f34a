"""A campaign in memory, as if measured."""

from pathlib import Path

import numpy as np
import pytest

import wheelhop as wh
from wheelhop.cli.main import main

VEHICLE = Path(__file__).parents[2] / "examples/clean/vehicle.toml"
BUMP = "half-sine-bump:amplitude_mm=50:length_mm=1000"
TRACKS = ["washboard/low", BUMP]


def test_it_is_the_campaign_the_command_writes(tmp_path):
    made = wh.simulate(VEHICLE, TRACKS, [8.0, 12.0], "dry-friction:front_N=60", seed=5, seconds=4.0)
    words = ["--tracks", *TRACKS, "--speed", "8", "12", "--with", "dry-friction:front_N=60"]
    out = ["--seed", "5", "--seconds", "4", "--out", str(tmp_path / "made")]
    assert main(["simulate", str(VEHICLE), *words, *out]) == 0
    written = wh.read(tmp_path / "made")
    assert [(r.id, r.role, r.track) for r in made.runs] == [
        (r.id, r.role, r.track) for r in written.runs
    ]
    assert made.noise_rms == written.noise_rms and made.channels == written.channels
    for one, other in zip(made.runs, written.runs, strict=True):
        assert one.speed_m_s == pytest.approx(other.speed_m_s)
        np.testing.assert_allclose(one.record, other.record, atol=1e-4)
    assert wh.read_vehicle(made).values == wh.read_vehicle(VEHICLE).values


def test_without_noise_another_seed_of_a_fixed_start_changes_nothing():
    """A bump is reached 1.5 s after the record has begun: only noise is drawn."""
    vehicle = wh.read_vehicle(VEHICLE)
    quiet = [
        wh.simulate(vehicle, BUMP, 10.0, noise_rms=0.0, seed=seed, seconds=3.0) for seed in (1, 2)
    ]
    assert np.array_equal(*(campaign.runs[0].record for campaign in quiet))
    noisy = wh.simulate(vehicle, BUMP, 10.0, noise_rms=0.2, seed=1, seconds=3.0)
    noise = noisy.runs[0].record - quiet[0].runs[0].record
    # White up to 50 Hz, and 0.2 m/s² of it from 0.5 to 30 Hz.
    assert noise.std() == pytest.approx(0.2 * np.sqrt(50 / 29.5), rel=0.05)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"tracks": "washbord/low"}, "washboard"),
        ({"add": "dry-frictoin"}, "dry-friction"),
        ({"seconds": 0.1}, "must be from 2 to 600"),
        ({"noise_rms": -1.0}, "noise -1"),
    ],
)
def test_a_mistake_is_one_line(options, says):
    with pytest.raises(wh.CampaignError, match=says) as caught:
        wh.simulate(VEHICLE, **{"tracks": "washboard/low", **options})
    assert "\n" not in str(caught.value)
