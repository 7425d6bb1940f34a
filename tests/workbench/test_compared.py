"""Compare's state: what every event makes of it, and what is drawn of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.campaign import read_campaign
from wheelhop.workbench.charts import MOST, WHOLE, Line, Panel, chart, power_density
from wheelhop.workbench.compared import (
    ALL_RUNS,
    NOTHING,
    Compared,
    Curve,
    Curves,
    curves,
    runs_offered,
    spectrum,
    time_chart,
    words_of,
)
from wheelhop.workbench.shown import Rung, Signals

CAMPAIGN = read_campaign(Path(__file__).parents[2] / "examples/clean")
CHANNELS = tuple(channel.name for channel in CAMPAIGN.channels)
LADDER = ((), ("dry-friction",), ("dry-friction", "bump-stop"))
RATE_HZ = 100.0


def rung(added, scale):
    """A model that has every channel `scale` times as large as it was measured."""
    signals = {}
    for run in CAMPAIGN.runs:
        measured = (run.record - run.record.mean(axis=0)).astype(np.float32)
        signals[run.id] = Signals(
            CAMPAIGN.sample_rate_hz, measured, scale * measured, measured, measured, None
        )
    return Rung(
        **{"added": added, "error": 0.1, "error_fit": 0.1, "floor": 0.05, "floor_fit": 0.05},
        **{"at_floor": False, "runs": tuple(signals), "channels": CHANNELS, "points": CHANNELS},
        **{"shape": None, "numbers": {}, "ratio": np.ones((len(signals), len(CHANNELS)))},
        **{"noise_rms": np.full(len(CHANNELS), 0.05), "signals": signals, "sentences": ()},
        html={},
    )


RUNGS = tuple(rung(added, scale) for added, scale in zip(LADDER, (0.5, 0.8, 0.9), strict=True))
RUNS = range(len(CAMPAIGN.runs))
windows = st.tuples(st.floats(0, 49), st.floats(51, 100))
states = st.builds(
    Compared,
    run=st.sampled_from([*RUNS, ALL_RUNS]),
    channel=st.sampled_from(range(len(CHANNELS))),
    ladder=st.just(LADDER),
    models=st.sets(st.sampled_from(range(3))).map(lambda found: tuple(sorted(found))),
    window=windows,
)


@given(states, st.sampled_from(RUNS), st.sampled_from(range(len(CHANNELS))))
def test_what_was_clicked_is_what_is_looked_at(state, run, channel):
    looked = state.at(run, channel)
    assert (looked.run, looked.channel, looked.models) == (run, channel, state.models)
    assert looked == state.at(channel=channel).at(run=run)  # in whatever order
    found = curves(looked, CAMPAIGN, RUNGS, ())
    record = CAMPAIGN.runs[run].record[:, channel]
    assert found.channel.name == CHANNELS[channel]
    np.testing.assert_allclose(found.curves[0].whole, record - record.mean(), atol=1e-4)


@given(states, st.sampled_from([*RUNS, ALL_RUNS]), windows)
def test_another_run_is_looked_at_as_a_whole(state, run, window):
    looked = state.at(run=run)
    assert looked.window == (state.window if run == state.run else WHOLE)
    stale = looked.zoomed(state.run, window)  # the browser had not heard of it yet
    assert stale == (looked if run != state.run else replace(looked, window=window))


@given(states)
def test_a_new_ladder_shows_its_first_and_last_model(state):
    assert state.on(LADDER) == state
    assert state.on(LADDER[:2]).models == (0, 1)
    assert state.on(LADDER[:1]).models == (0,)
    assert state.on(()).models == ()


def test_steps_go_round_among_the_runs_taken():
    state = Compared(run=0)
    offered = runs_offered(state, CAMPAIGN, (CAMPAIGN.runs[1].id,))
    assert 1 not in offered
    seen = []
    for _ in offered:
        seen.append(state.run)
        state = state.stepped(1, offered)
    assert seen == offered
    assert state.run == 0
    assert state.stepped(-1, offered).run == offered[-1]
    assert runs_offered(Compared(run=1), CAMPAIGN, (CAMPAIGN.runs[1].id,))[1] == 1  # it stays


@given(states)
def test_both_panels_show_the_window(state):
    options = time_chart(curves(state, CAMPAIGN, RUNGS, ()), state.window)
    (zoom,) = options["dataZoom"]
    assert zoom["xAxisIndex"] == list(range(len(options["xAxis"])))
    assert (zoom["start"], zoom["end"]) == state.window
    assert len(options["xAxis"]) == (2 if state.models else 1)
    assert len(options["series"]) == 2 * len(state.models) + 1
    assert all(axis["min"] == 0 for axis in options["xAxis"])  # however few points are drawn
    assert len({axis["max"] for axis in options["xAxis"]}) == 1


@given(windows)
def test_what_is_looked_at_is_drawn_with_its_detail(window):
    """Of a record longer than a screen has room for; in a small window every sample is there."""
    n = 40 * MOST
    time = np.arange(n) / RATE_HZ
    found = Curves(CAMPAIGN.channels[0], RATE_HZ, (Curve("measured", "#000", (time % 7.0,)),))
    (series,) = time_chart(found, window)["series"]
    first, last = (n * percent / 100 for percent in window)
    drawn = [x for x, _ in series["data"] if first <= x * RATE_HZ <= last]
    assert len(drawn) >= MOST / 4  # those that are only passed by are far fewer
    (small,) = time_chart(found, (50.0, 51.0))["series"]
    inside = [x for x, _ in small["data"] if 0.5 * n <= x * RATE_HZ < 0.51 * n]
    assert len(inside) == pytest.approx(0.01 * n, abs=2)


def test_a_chart_without_a_window_keeps_what_the_browser_shows():
    """As when a slider moves the curves that somebody has zoomed into."""
    panel = Panel("frequency, Hz", "", [Line("ride", np.arange(9), np.arange(9), "#000")])
    (zoom,) = chart([panel], (100,), (0,))["dataZoom"]
    assert not {"start", "end"} & set(zoom)


def test_what_is_left_out_is_not_drawn_and_nothing_of_before_stays():
    found = curves(Compared(channel=1), CAMPAIGN, (), ())
    assert len(found.curves) == 1  # nothing is fitted yet
    less = (replace(RUNGS[0], channels=CHANNELS[1:]),)
    found = curves(Compared(ladder=LADDER[:1], models=(0,)), CAMPAIGN, less, ())
    assert (words_of(found), time_chart(found, WHOLE), spectrum(found, (1, 9))) == (NOTHING, {}, {})
    one = time_chart(curves(Compared(), CAMPAIGN, RUNGS, ()), WHOLE)
    assert one["series"][-1]["markLine"]["data"] == []
    left_out = [run.id for run in CAMPAIGN.runs[2:]]
    both = curves(Compared(run=ALL_RUNS), CAMPAIGN, RUNGS, left_out)
    lengths = [len(run.time_s) for run in CAMPAIGN.runs[:2]]
    assert [len(record) for record in both.curves[0].records] == lengths
    join = time_chart(both, WHOLE)["series"][-1]["markLine"]["data"]
    assert join == [{"xAxis": pytest.approx(lengths[0] / CAMPAIGN.sample_rate_hz)}]


# The spectrum of runs.


def sine(frequency_hz, phase, n, mean=0.0):
    return mean + np.sin(2 * np.pi * frequency_hz * np.arange(n) / RATE_HZ + phase)


def test_no_spectrum_goes_across_a_join():
    """Whole periods of a sine in each half-overlapping window: a Hann window leaks into its two
    neighbours, and nowhere else. Across a join, where the phase jumps, it leaks everywhere."""
    runs = [sine(5.0, phase, 800) for phase in (0.0, 2.0, 4.0)]
    frequency, power = power_density(runs, RATE_HZ)
    far = np.abs(frequency - 5.0) > 1.0
    assert power[far].max() < 1e-6 * power.max()


def test_the_spectrum_of_runs_is_the_mean_of_theirs():
    """Runs of one length: the plain mean; the order of the runs does not matter."""
    rng = np.random.default_rng(1)
    runs = [rng.normal(0, sigma, 600) for sigma in (1.0, 2.0, 3.0)]
    each = [power_density([run], RATE_HZ)[1] for run in runs]
    np.testing.assert_allclose(power_density(runs, RATE_HZ)[1], np.mean(each, axis=0))
    again = power_density(runs[::-1], RATE_HZ)[1]
    np.testing.assert_allclose(again, power_density(runs, RATE_HZ)[1])


def test_each_run_counts_by_its_length():
    """Parseval: the density's integral is the mean square of all samples, however they are split
    among runs."""
    rng = np.random.default_rng(2)
    runs = [rng.normal(0, 1.0, 40_000), rng.normal(0, 3.0, 4_000), rng.normal(0, 2.0, 20_000)]
    frequency, power = power_density(runs, RATE_HZ)
    mean_square = np.mean(np.concatenate(runs) ** 2)
    assert power.sum() * frequency[0] == pytest.approx(mean_square, rel=0.03)
