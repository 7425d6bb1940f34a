"""A residual of known make is found where it was put."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.compare.conftest import Bench
from wheelhop.compare import breakdown, compare, describe, in_band, noise_floor

SPEEDS = [2.0, 3.1, 2.6, 4.2]
PITCH = 0.5
CUTS = ("run", "channel", "band", "motion", "time", "amplitude")
ROLL = np.array([1, -1, 1, -1, 0, 0, 0, 0])


def largest(parts):
    return max(parts, key=lambda part: part.share)


def sine(time, frequency):
    return np.sin(2 * np.pi * frequency * time + 0.3)[:, None]


def where_of(campaign, responses):
    return compare(campaign, responses).breakdown


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_shares_of_every_cut_sum_to_one_and_to_the_same_residual(seed):
    rng = np.random.default_rng(seed)
    gain = rng.uniform(-1.0, 1.0, 8)
    campaign, responses = Bench().campaign(
        SPEEDS, lambda t, v: gain * sine(t, rng.uniform(1, 25)) + rng.normal(size=(len(t), 8))
    )
    records = in_band(campaign, responses)
    where = breakdown(campaign, records, noise_floor(campaign, records))
    for cut in CUTS:
        parts = getattr(where, cut)
        assert sum(part.share for part in parts) == pytest.approx(1.0), cut
        assert sum(part.residual for part in parts) == pytest.approx(where.total.residual), cut
        assert sum(part.measured for part in parts) == pytest.approx(where.total.measured), cut
        assert sum(part.noise for part in parts) == pytest.approx(where.total.noise), cut
    locking = where.locking
    assert locking.road + locking.time + locking.neither == pytest.approx(1.0)


def test_white_noise_is_locked_to_nothing_and_leaves_no_excess(bench):
    rms = 0.3 * np.sqrt(604 / 1024)
    campaign, responses = bench.campaign(SPEEDS, lambda t, v: bench.noise(0.3), noise=rms)
    where = where_of(campaign, responses)
    assert where.locking.road == pytest.approx(0.0, abs=0.02)
    assert where.locking.time == 0.0
    assert where.locking.neither == pytest.approx(where.locking.noise, rel=0.05)
    for cut in CUTS:
        for part in getattr(where, cut):
            # Within five standard deviations of what so few degrees of freedom can show.
            freedom = where.count * part.noise / where.total.noise
            assert part.ratio**2 == pytest.approx(1.0, abs=5 * np.sqrt(2 / freedom)), part.name
    (sentence,) = describe(where)
    assert sentence.startswith("In every band and run the residual is no more than expected")


def test_many_harmonics_in_band_do_not_make_noise_locked_to_the_road(bench):
    # 0.3 m/s over 0.5 m: fifty harmonics in band, a sixth of all degrees of freedom.
    campaign, responses = bench.campaign([0.3, 0.35], lambda t, v: bench.noise(0.3), noise=0.23)
    assert where_of(campaign, responses).locking.road == pytest.approx(0.0, abs=0.03)


@pytest.mark.parametrize("seed", range(20))
def test_noise_alone_never_shows_a_line(bench, seed):
    bench.rng = np.random.default_rng(seed)
    campaign, responses = bench.campaign(SPEEDS, lambda t, v: bench.noise(0.3), noise=0.2)
    assert where_of(campaign, responses).locking.lines == ()


def test_pure_roll_is_reported_as_roll(bench):
    campaign, responses = bench.campaign(SPEEDS, lambda t, v: 0.7 * sine(t, 8.0) * ROLL)
    where = where_of(campaign, responses)
    shares = {part.name: part.share for part in where.motion}
    assert shares["roll"] == pytest.approx(1.0)
    assert largest(where.band).name == "8"
    assert "mostly roll" in describe(where)[0]


def test_a_fixed_frequency_in_runs_of_different_speed_is_locked_to_time(bench):
    campaign, responses = bench.campaign(
        [2.0, 3.0], lambda t, v: 0.5 * sine(t, 22.5) + bench.noise(0.05), noise=0.05
    )
    where = where_of(campaign, responses)
    (line,) = where.locking.lines
    assert line.frequency_hz == pytest.approx(22.5, abs=0.02)
    assert where.locking.time == pytest.approx(1.0, abs=0.03)
    assert where.locking.road < 0.01
    text = " ".join(describe(where))
    assert "locked to time" in text
    assert "22.50 Hz" in text


def test_records_of_different_length_show_the_same_line(bench):
    def engine(time, speed):
        return 0.05 * sine(time, 17.03) + bench.noise(0.1, (len(time), 8))

    runs, responses = [], []
    for n, speed in ((1000, 1.0), (1404, 2.0), (777, 3.0)):
        part, answer = bench.campaign([speed], engine, n=n)
        runs.append(replace(part.runs[0], id=f"{n}"))
        responses.append(replace(answer[0], run_id=f"{n}"))
    where = where_of(replace(part, runs=tuple(runs)), responses)
    (line,) = where.locking.lines
    assert line.frequency_hz == pytest.approx(17.03, abs=0.01)
    # A sine of 0.05 over noise of 0.1 rms, 60 % of it in band.
    assert line.share == pytest.approx(0.5 * 0.05**2 / (0.5 * 0.05**2 + 0.59 * 0.1**2), rel=0.1)


def test_an_unsteady_line_is_one_line(bench):
    def engine(time, speed):
        return (0.5 + 0.2 * sine(time, 0.17)) * sine(time, 22.5) + bench.noise(0.02)

    campaign, responses = bench.campaign([2.0, 3.0], engine, noise=0.02)
    (line,) = where_of(campaign, responses).locking.lines
    assert line.frequency_hz == pytest.approx(22.5, abs=0.05)


def test_a_fixed_frequency_at_one_speed_only_is_not_called_locked_to_time(bench):
    campaign, responses = bench.campaign(
        [2.0, 2.02, 2.05], lambda t, v: 0.5 * sine(t, 22.5) + bench.noise(0.05), noise=0.05
    )
    assert where_of(campaign, responses).locking.lines == ()


def test_a_standing_vehicle_settles_that_a_line_is_locked_to_time(bench):
    campaign, responses = bench.campaign(
        [0.0], lambda t, v: 0.5 * sine(t, 22.5) + bench.noise(0.05), noise=0.05, kind="unknown"
    )
    (line,) = where_of(campaign, responses).locking.lines
    assert line.frequency_hz == pytest.approx(22.5, abs=0.02)


def test_a_line_that_moves_with_speed_is_not_locked_to_time(bench):
    campaign, responses = bench.campaign(
        SPEEDS, lambda t, v: 0.5 * sine(t, 3.7 * v) + bench.noise(0.05), noise=0.05
    )
    locking = where_of(campaign, responses).locking
    assert locking.lines == ()
    assert locking.neither == pytest.approx(1.0, abs=0.02)


def test_harmonics_of_the_road_are_locked_to_the_road(bench):
    def residual(time, speed):
        return sum(sine(time, m * speed / PITCH) for m in (1, 2, 4)) + bench.noise(0.05)

    campaign, responses = bench.campaign(SPEEDS, residual, noise=0.05)
    where = where_of(campaign, responses)
    assert where.locking.road == pytest.approx(1.0, abs=0.02)
    assert "locked to the road" in describe(where)[0]


def test_the_road_is_followed_through_a_wandering_speed(bench):
    wander = 0.05
    campaign, responses = bench.campaign([3.0, 4.0], lambda t, v: np.zeros((len(t), 8)))
    runs, moved = [], []
    for run, response in zip(campaign.runs, responses, strict=True):
        x = run.speed_m_s * (run.time_s + wander * np.sin(run.time_s))
        again = np.sin(4 * np.pi * x / PITCH)[:, None] * np.ones(8)
        runs.append(replace(run, record=run.record + again))
        moved.append(replace(response, position_m=x))
    campaign = replace(campaign, runs=tuple(runs))
    assert where_of(campaign, moved).locking.road == pytest.approx(1.0, abs=0.02)
    assert where_of(campaign, responses).locking.road < 0.5


def test_off_periodic_tracks_road_means_coherent_with_the_modelled_response(bench):
    def random_motion(time, speed):
        return np.random.default_rng(round(10 * speed)).standard_normal((len(time), 8))

    for residual, road in (
        (lambda t, v: 0.3 * np.roll(random_motion(t, v), 1, axis=0), 1.0),
        (lambda t, v: 0.3 * bench.noise(1.0), 0.0),
    ):
        campaign, responses = bench.campaign(
            SPEEDS, residual, motion=random_motion, kind="iso8608", noise=0.01
        )
        assert where_of(campaign, responses).locking.road == pytest.approx(road, abs=0.15)


def test_time_of_the_failure_is_found(bench):
    def residual(time, speed):
        return ((time > 4.1) & (time < 5.1))[:, None] * 2.0 * sine(time, 12.0)

    campaign, responses = bench.campaign(SPEEDS, residual)
    where = where_of(campaign, responses)
    assert largest(where.time).name == "40-50 %"
    assert any("of the runs' time" in s for s in describe(where))


@pytest.mark.parametrize("power", [0.0, 1.0, 3.0])
def test_growth_with_amplitude_is_measured(bench, power):
    # Residual amplitude a^power under a motion of amplitude a, over runs of several a.
    def motion(time, speed):
        return speed * sine(time, 5.0) * np.ones(8)

    def residual(time, speed):
        return 0.2 * (speed / 8.0) ** power * sine(time, 11.0) * np.ones(8)

    campaign, responses = bench.campaign(
        [1.0, 2.0, 4.0, 8.0], residual, motion=motion, kind="unknown", noise=1e-5
    )
    assert where_of(campaign, responses).growth == pytest.approx(power, abs=0.1)


def test_one_bad_channel_in_one_run_is_named(bench):
    def residual(time, speed):
        bad = np.zeros(8)
        bad[6] = 3.0 if speed == SPEEDS[2] else 0.0
        return bad * sine(time, 6.0) + bench.noise(0.1)

    campaign, responses = bench.campaign(SPEEDS, residual, noise=0.08)
    where = where_of(campaign, responses)
    assert largest(where.run).name == "run-2"
    assert largest(where.channel).name == "a3"
    assert np.unravel_index(np.nanargmax(where.runs_channels.ratio), (4, 8)) == (2, 6)
    text = " ".join(describe(where))
    assert "channel a3" in text
    assert "1 of 4 runs: run-2" in text


def test_rear_axle_hop_is_described_as_such(bench):
    hop = np.array([0, 0, 0, 0, 0, 0, 1, 1])
    campaign, responses = bench.campaign(
        SPEEDS, lambda t, v: sine(t, 10.0 + v / 10) * hop + bench.noise(0.1), noise=0.08
    )
    first = describe(where_of(campaign, responses))[0]
    assert "at the rear axles, mostly rear hop" in first
    assert "between 8.9 and 11 Hz" in first


def test_channels_that_are_not_predicted_count_nowhere(bench):
    campaign, responses = bench.campaign(SPEEDS, lambda t, v: bench.noise(0.3), noise=0.3)
    for response in responses:
        response.record[:, 4:] = np.nan
    comparison = compare(campaign, responses)
    where = comparison.breakdown
    assert [part.measured > 0 for part in where.channel] == [True] * 4 + [False] * 4
    assert {part.name for part in where.motion} == {"heave", "pitch", "roll", "warp"}
    assert len(comparison.figures) == 4 * len(SPEEDS)
    assert where.count == 604 * 4 * len(SPEEDS)
