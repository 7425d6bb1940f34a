"""A drive is the same drive under any name, and two drives over one track are two."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.campaign.build import acceleration, csv_text, edit, write_campaign
from tests.work import calls
from wheelhop.campaign import (
    Campaign,
    CampaignError,
    Channel,
    Run,
    TrackSpec,
    find_duplicates,
    read_campaign,
)

RATE_HZ = 100.0
POINTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")


def campaign_of(*records: np.ndarray, roles: str = "") -> Campaign:
    """Runs r0, r1, …; a role is f or v, fit if none is given."""
    runs = tuple(
        Run(
            *(f"r{k}", None, "validate" if roles[k : k + 1] == "v" else "fit", 2.0),
            *(TrackSpec("unknown", {}), np.arange(len(record)) / RATE_HZ, record),
        )
        for k, record in enumerate(records)
    )
    width = records[0].shape[1]
    channels = tuple(Channel(p, p) for p in POINTS[:width])
    return Campaign(None, "t", None, RATE_HZ, (0.5, 30.0), 0.0, None, channels, runs)


def drive(seed: int, rows: int = 1500, channels: int = 8, noise: float = 0.12) -> np.ndarray:
    """A band-limited motion that every drive shares, at a speed and with noise that none does."""
    own = np.random.default_rng(seed)
    held = 1.0 + 0.01 * own.normal()  # the speed, by hand
    time_s = held * np.arange(rows)[:, None] / RATE_HZ
    rng = np.random.default_rng(0)
    frequency, phase = rng.uniform(0.5, 25.0, 40), rng.uniform(0, 2 * np.pi, (40, channels))
    motion = sum(np.sin(2 * np.pi * f * time_s + p) for f, p in zip(frequency, phase, strict=True))
    return motion + own.normal(0.0, noise, (rows, channels))


def test_what_was_fitted_cannot_judge_under_another_name_and_speed(tmp_path):
    folder = write_campaign(tmp_path / "c")
    (folder / "runs/fast.csv").write_text(csv_text(acceleration(1)))
    with pytest.raises(CampaignError, match=r'"fast" \(validate\) holds the samples of .*"slow"'):
        read_campaign(folder)
    edit(folder / "campaign.toml", 'role = "validate"', 'role = "fit"')
    (found,) = find_duplicates(read_campaign(folder))
    assert (found.first, found.second, found.exact, found.whole, found.leaks) == (
        *("slow", "fast"),
        *(True, True, False),
    )


ALTERED = {
    "rounded": lambda x: x.round(2),
    "another gain and offset": lambda x: 1.03 * x + 0.4,
    "a gain for each channel": lambda x: x * np.linspace(0.9, 1.1, x.shape[1]),
    "a little noise": lambda x: x + np.random.default_rng(9).normal(0, 0.005, x.shape),
}


@pytest.mark.parametrize("name", ALTERED)
@pytest.mark.parametrize("channels", [1, 4, 8])
def test_a_copy_that_was_altered_is_named(name, channels):
    copy = ALTERED[name](drive(1, channels=channels))
    (found,) = find_duplicates(campaign_of(drive(1, channels=channels), copy, roles="fv"))
    assert found.leaks and found.whole == (found.seconds == 15.0) and not found.exact
    assert found.seconds >= 10.0
    assert "one is fitted, the other judges" in str(found)


@pytest.mark.parametrize("noise", [0.12, 1.0])
def test_two_drives_over_one_track_are_two(noise):
    assert find_duplicates(campaign_of(*(drive(k, noise=noise) for k in range(6)))) == []


@settings(max_examples=30)
@given(
    rows=st.integers(350, 900), there=st.integers(0, 600), here=st.integers(0, 300),
    channels=st.sampled_from([1, 2, 8]),
)  # fmt: skip
def test_a_stretch_is_found_where_it_is(rows, there, here, channels):
    source = drive(1, channels=channels)
    copied = source[there : there + rows]
    second = np.vstack([drive(2, here, channels), copied, drive(3, 150, channels)])
    (found,) = find_duplicates(campaign_of(source, second, roles="fv"))
    assert found.leaks
    assert found.first_s - found.second_s == pytest.approx((there - here) / RATE_HZ)
    assert abs(found.second_s - here / RATE_HZ) <= 1.0  # a block
    assert abs(found.seconds - len(copied) / RATE_HZ) <= 2.0


def test_a_copy_to_judge_is_named_beside_the_fitted_one_among_copies():
    runs = [drive(1)] * 2 + [drive(1).round(3)] + [drive(4)]
    found = find_duplicates(campaign_of(*runs, roles="vffv"))
    assert [(d.first, d.second, d.leaks) for d in found] == [
        ("r0", "r1", True),
        ("r0", "r2", True),
        ("r1", "r2", False),
    ]


def test_signals_that_say_nothing_are_no_trouble():
    zero, short = np.zeros((400, 8)), drive(1, 3)
    wave = np.tile(np.sin(np.arange(40.0)), 10)[:, None]
    assert find_duplicates(campaign_of(zero, zero + 1.0)) == []
    assert find_duplicates(campaign_of(short, short[:2], drive(1, 1))) == []
    assert find_duplicates(campaign_of(wave, 2.0 * wave, -wave)) == []
    assert [d.exact for d in find_duplicates(campaign_of(zero, zero))] == [True]


def test_the_work_grows_with_the_runs_not_with_their_pairs():
    def work(count: int) -> int:
        many = campaign_of(*np.random.default_rng(1).normal(size=(count, 300, 4)))
        assert find_duplicates(many) == []
        return calls(find_duplicates, many)

    work(10)
    assert work(400) < 5 * work(100)  # pairs: 16 times
