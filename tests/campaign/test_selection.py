"""A campaign is a collection of runs, and a part of it is a campaign."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import wheelhop as wh

EXAMPLE = Path(__file__).parents[2] / "examples/clean"


@pytest.fixture(scope="module")
def campaign():
    return wh.read(EXAMPLE)


def test_it_has_a_length_members_and_an_order(campaign):
    ids = [run.id for run in campaign]
    assert len(campaign) == len(ids) == len(campaign.runs)
    assert all(id_ in campaign and campaign[id_] in campaign for id_ in ids)
    assert "no-such-run" not in campaign and campaign[ids[1]] is campaign.runs[1]
    with pytest.raises(wh.CampaignError, match=f"did you mean '{ids[0]}'"):
        campaign[ids[0][:-1]]


def test_runs_are_chosen_by_role_track_and_id(campaign):
    parts = [campaign.select(role=role) for role in ("fit", "validate")]
    assert sum(map(len, parts)) == len(campaign)
    assert parts[0].runs == campaign.fit_runs
    kinds = {run.track.kind for run in campaign}
    assert sum(len(campaign.select(track=kind)) for kind in kinds) == len(campaign)
    first = campaign.runs[0]
    assert campaign.select(first.id, role=first.role, track=first.track.kind).runs == (first,)
    assert campaign.select().runs == campaign.runs


def test_what_is_not_there_is_told_with_what_is(campaign):
    with pytest.raises(wh.CampaignError, match='track "moon"; there are fit on'):
        campaign.select(track="moon")
    with pytest.raises(wh.CampaignError, match='no channel "B9"'):
        campaign.select(channels=["B9"])
    with pytest.raises(wh.CampaignError, match="list of names"):
        campaign.select(channels="B1")


def test_channels_left_out_take_their_columns_with_them(campaign):
    part = campaign.select(channels=["A1", "B2"])
    names = [channel.name for channel in campaign.channels]
    columns = [i for i, name in enumerate(names) if name in ("A1", "B2")]
    assert [channel.name for channel in part.channels] == [names[i] for i in columns]
    for whole, run in zip(campaign, part, strict=True):
        np.testing.assert_array_equal(run.record, whole.record[:, columns])
        assert not run.record.flags.writeable
    assert part.noise_rms == campaign.noise_rms


def test_the_noise_is_that_of_the_quantity_that_leads_now(campaign):
    first, *others = campaign.channels
    travel = replace(first, quantity="travel", unit="m", point="S1", noise_rms=0.002)
    mixed = replace(campaign, channels=(travel, *others))
    assert mixed.leading.is_acceleration and mixed.noise_rms == campaign.noise_rms
    assert mixed.select(channels=[first.name]).noise_rms == 0.002
    silent = replace(mixed, channels=(replace(travel, noise_rms=None), *others))
    assert silent.select(channels=[first.name]).noise_rms is None
