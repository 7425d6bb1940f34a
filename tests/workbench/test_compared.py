"""Compare's state: what every event makes of it, and what is drawn of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.component import rig
from wheelhop.campaign import read_campaign
from wheelhop.report.stretch import WAVES, WINDOW_S
from wheelhop.workbench import kinds
from wheelhop.workbench.charts import MOST, WHOLE, Line, Panel, chart
from wheelhop.workbench.compared import (
    CLOSEST_S,
    DISTANCE,
    KINDS,
    OVERLAY,
    PAIRED,
    SPECTROGRAM,
    SPECTRUM,
    TIME,
    XY,
    Compared,
    address_of,
    of_address,
    offered_channels,
    offered_runs,
    opened,
)
from wheelhop.workbench.curves import Curve, Row, at_first, rows_of
from wheelhop.workbench.kinds import Look, picture, readings
from wheelhop.workbench.session import Session, read_session, write_session
from wheelhop.workbench.shown import Rung, Signals
from wheelhop.workbench.spectra import power_density, spectra
from wheelhop.workbench.spectrogram import power_over_time

CAMPAIGN = read_campaign(Path(__file__).parents[2] / "examples/clean")
CHANNELS = tuple(channel.name for channel in CAMPAIGN.channels)
RUNS = tuple(run.id for run in CAMPAIGN.runs)
LENGTHS = {run.id: len(run.time_s) / CAMPAIGN.sample_rate_hz for run in CAMPAIGN.runs}
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
windows = st.tuples(st.floats(0, 4), st.floats(5, 9)).map(lambda w: (round(w[0], 4), w[1] // 1))
states = st.builds(
    Compared,
    runs=st.lists(st.sampled_from(RUNS), min_size=1, max_size=3, unique=True).map(tuple),
    channels=st.lists(st.sampled_from(CHANNELS), min_size=1, max_size=3, unique=True).map(tuple),
    kind=st.sampled_from(list(KINDS)),
    window=st.one_of(st.none(), st.just(WHOLE), windows),
    ladder=st.just(LADDER),
    models=st.sets(st.sampled_from(range(3))).map(lambda found: tuple(sorted(found))),
)


def drawn(state, rungs=RUNGS):
    """The options of what is drawn of a state."""
    rows = rows_of(state, CAMPAIGN, rungs)
    window = state.window or at_first(rows, loops=state.kind == XY)
    return picture(state.kind, rows, Look(window, state.cursors, CAMPAIGN.band_hz)).options


@given(states, st.sampled_from(RUNS), st.sampled_from(CHANNELS))
def test_what_was_clicked_is_what_is_looked_at(state, run, channel):
    looked = state.at(run, channel)
    assert (looked.runs, looked.channels, looked.kind) == ((run,), (channel,), TIME)
    assert looked == state.at(channel=channel).at(run=run)  # in whatever order
    (row,) = rows_of(looked, CAMPAIGN, RUNGS)
    assert (row.run, row.channel, len(row.curves)) == (run, channel, 1 + len(state.models))
    record = CAMPAIGN.runs[RUNS.index(run)].record[:, CHANNELS.index(channel)]
    np.testing.assert_allclose(row.curves[0].signal, record - record.mean(), atol=1e-4)


@given(states)
def test_an_address_and_a_session_tell_the_state_again(tmp_path_factory, state):
    plain = replace(state, ladder=(), models=())
    assert of_address(address_of(state), CAMPAIGN) == plain
    assert of_address(address_of(state).replace(state.runs[0], "another"), CAMPAIGN) != plain
    campaign = replace(CAMPAIGN, folder=tmp_path_factory.mktemp("kept"))
    write_session(campaign, Session(looked_at=state), "test")
    kept = None if state.window == WHOLE else state.window
    assert read_session(campaign).looked_at == replace(plain, window=kept)


@given(states)
def test_a_new_ladder_shows_its_first_and_last_model(state):
    assert state.on(LADDER) == state
    assert state.on(LADDER[:2]).models == (0, 1)
    assert state.on(LADDER[:1]).models == (0,)
    assert state.on(()).models == ()


def test_it_opens_where_the_first_model_fails_worst_of_the_runs_held_out():
    ratio = np.ones((len(RUNS), len(CHANNELS)))
    ratio[2, 3], ratio[4, 1] = 9.0, 5.0
    rungs = (replace(RUNGS[0], ratio=ratio),)
    assert opened(CAMPAIGN, rungs, {RUNS[4]: "validate"}) == Compared((RUNS[4],), (CHANNELS[1],))
    assert opened(CAMPAIGN, rungs, {}) == Compared((RUNS[2],), (CHANNELS[3],))
    assert opened(CAMPAIGN, (), {}) == Compared(RUNS[:1], CHANNELS[:1])


def test_steps_go_round_among_the_runs_taken():
    offered = offered_runs(CAMPAIGN, RUNS[1:2], RUNS[:1])
    assert RUNS[1] not in offered
    state, seen = Compared(RUNS[:2], CHANNELS[:1], cursors=(1.0, 2.0)), []
    for _ in offered:
        seen.append(state.runs[0])
        state = state.stepped(1, offered)
        assert state.cursors is None
    assert seen == offered
    assert state.stepped(-1, offered).runs == (offered[-1],)
    assert offered_runs(CAMPAIGN, RUNS[1:2], RUNS[1:2])[1] == RUNS[1]  # it stays


@given(states)
def test_no_press_of_a_key_leaves_the_record(state):
    length, shown = LENGTHS[state.runs[0]], (1.0, 3.5)
    for key in ["+"] * 20 + ["ArrowLeft"] * 20 + ["-"] * 3 + ["ArrowRight"] * 20 + ["-"] * 20:
        shown = state.pressed(key, shown, length).window
        assert shown[0] >= -1e-9 and shown[1] <= length + 1e-9
        assert shown[1] - shown[0] >= 0.05 - 1e-9  # five samples of the slowest recorder
    assert shown == pytest.approx((0.0, length))
    assert CLOSEST_S < 2 * 0.05
    assert state.pressed("0", shown, length).window == WHOLE


def test_a_kind_of_pairs_gets_a_pair():
    """Of a body point the axle below it; on a rig displacement and velocity."""
    offered = offered_channels(CAMPAIGN)
    one = Compared(RUNS[:1], ("B3",))
    for kind in PAIRED:
        assert one.drawn_as(kind, offered).channels == ("B3", "A3")
    assert one.drawn_as(SPECTRUM, offered) == replace(one, kind=SPECTRUM)


@pytest.mark.parametrize("drive", ["displacement", "force"])
def test_a_rig_opens_with_its_loops_before_anything_is_fitted(drive, tmp_path):
    component = rig.Component(0.0 if drive == "displacement" else 5.0, 20000.0, 300.0)
    campaign = read_campaign(
        rig.make_campaign(tmp_path / "c", drive, component, seed=1, noise=0.003)
    )
    state = opened(campaign, (), {})
    rows = rows_of(state, campaign, ())
    assert [row.channel for row in rows] == ["force", "displacement", "velocity"]
    assert [row.unit for row in rows] == ["N", "mm", "m/s"]
    options = picture(XY, rows, Look(at_first(rows, loops=True), None, campaign.band_hz)).options
    assert [axis["name"] for axis in options["xAxis"]] == ["displacement, mm", "velocity, m/s"]
    run = campaign.runs[0]
    np.testing.assert_allclose(
        1e-3 * rows[1].curves[0].signal, run.displacement - run.displacement.mean(), atol=1e-12
    )


@given(states)
def test_all_panels_against_time_show_the_window(state):
    state = replace(state, kind=TIME)
    options = drawn(state)
    rows = len(state.runs) * len(state.channels)
    (zoom,) = options["dataZoom"]
    assert zoom["xAxisIndex"] == list(range(len(options["xAxis"])))
    left = rows == 1 and len(state.models) > 0
    assert len(options["xAxis"]) == (2 if left else rows)
    assert len(options["series"]) == rows * (1 + len(state.models)) + left * len(state.models)
    longest = max(LENGTHS[run] for run in state.runs)
    for axis in options["xAxis"]:
        assert (axis["min"], axis["max"]) == (0, pytest.approx(longest))
    if state.window is None:  # the stretch that the report shows: 25 waves of what is in band
        least = WAVES / CAMPAIGN.band_hz[1]
        assert least < zoom["endValue"] - zoom["startValue"] < WINDOW_S + 0.02


@given(states)
def test_every_kind_draws_every_channel_and_says_its_unit(state):
    state = state.drawn_as(state.kind, offered_channels(CAMPAIGN))
    options = drawn(state)
    panels = len(state.runs) if state.kind in (TIME, XY) else 1
    pairs = len(state.channels) - (state.kind in PAIRED)
    assert len(options["yAxis"]) >= panels * pairs
    assert all(one["data"] for one in options["series"])
    if state.kind in (TIME, XY, SPECTRUM):
        assert all("m/s²" in axis["name"] for axis in options["yAxis"])


@given(windows.filter(lambda w: w[1] - w[0] > 1))
def test_what_is_looked_at_is_drawn_with_its_detail(window):
    """Of a record longer than a screen has room for; in a small window every sample is there."""
    n = 40 * MOST
    time = np.arange(n) / RATE_HZ
    found = (Row("r", "A1", "", "m", RATE_HZ, (Curve("measured", kinds.MEASURED, time % 7.0),)),)

    def series(window):
        return picture(TIME, found, Look(window, None, (0.5, 30.0))).options["series"][0]

    wide = tuple(40 * end for end in window)
    shown = [x for x, _ in series(wide)["data"] if wide[0] <= x <= wide[1]]
    assert len(shown) >= MOST / 4  # those that are only passed by are far fewer
    small = tuple(end / 2 for end in window)
    inside = [x for x, _ in series(small)["data"] if small[0] <= x < small[1]]
    assert len(inside) == pytest.approx((small[1] - small[0]) * RATE_HZ, abs=2)
    pens = [series(w)["lineStyle"]["width"] for w in (small, WHOLE)]
    assert pens[0] > 2 * kinds.MODEL_PEN and pens[1] == 1.0  # thick behind, where it is cheap


def test_a_chart_without_a_window_keeps_what_the_browser_shows():
    """As when a slider moves the curves that somebody has zoomed into."""
    panel = Panel("frequency, Hz", "", [Line("ride", np.arange(9), np.arange(9), "#000")])
    (zoom,) = chart([panel], (100,), (0,))["dataZoom"]
    assert not {"start", "end", "startValue", "endValue"} & set(zoom)


def test_what_is_left_out_is_not_drawn():
    less = (replace(RUNGS[0], channels=CHANNELS[1:]),)
    state = Compared(RUNS[:1], CHANNELS[:2], ladder=LADDER[:1], models=(0,))
    assert [row.channel for row in rows_of(state, CAMPAIGN, less)] == [CHANNELS[1]]


def test_two_cursors_say_what_lies_between():
    """A ramp of 2 per second from 0: values, difference, and the range between."""
    ramp = 2.0 * np.arange(1001) / RATE_HZ
    row = Row("r", "A1", "acceleration", "m/s²", RATE_HZ, (Curve("measured", "#000", ramp),))
    ((name, curve, *numbers, unit),) = readings([row], (1.0, 4.0))
    assert (name, curve, unit) == ("A1, r", "measured", "m/s²")
    rms = np.sqrt(np.mean(ramp[100:400] ** 2))
    assert [float(number) for number in numbers] == pytest.approx([2, 8, 6, rms, 5.98], rel=0.01)


def test_a_histogram_shares_out_the_time_and_has_a_bin_about_rest():
    signal = np.concatenate([np.zeros(600), np.full(300, 1.0), np.full(100, -1.0)])
    row = Row("r", "A1", "", "m", RATE_HZ, (Curve("measured", "#000", signal),))
    (one,) = picture("histogram", [row], Look(WHOLE, None, (0.5, 30.0))).options["series"]
    x, share = np.array(one["data"]).T
    assert dict(zip(x[share > 0].round(2), share[share > 0], strict=True)).keys() >= {1.0, -1.0}
    begin, end = x[share == share.max()]  # an odd number of bins, none wider than a fortieth
    assert share.max() == pytest.approx(60.0) and begin == -end and end - begin < 2 / 40
    assert share[::2].sum() == pytest.approx(100.0)


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


def test_each_run_counts_by_its_length():
    """Parseval: the density's integral is the mean square of all samples, however they are split
    among runs."""
    rng = np.random.default_rng(2)
    runs = [rng.normal(0, 1.0, 40_000), rng.normal(0, 3.0, 4_000), rng.normal(0, 2.0, 20_000)]
    frequency, power = power_density(runs, RATE_HZ)
    mean_square = np.mean(np.concatenate(runs) ** 2)
    assert power.sum() * frequency[0] == pytest.approx(mean_square, rel=0.03)


def test_a_gain_and_its_coherence_are_those_of_a_noisy_amplifier():
    """Output = 3 input + as much noise: gain 3, coherence one half; of signals that have nothing
    to do with each other 5 % lie above what is said of chance."""
    rng = np.random.default_rng(3)
    x, noise = rng.normal(0, 1.0, (2, 200_000))
    both = spectra([x], [3.0 * x + 3.0 * noise], RATE_HZ, 400)
    assert np.median(both.gain) == pytest.approx(3.0, rel=0.02)
    assert np.median(both.coherence) == pytest.approx(0.5, abs=0.03)
    pieces = [rng.normal(0, 1.0, (2, 2000)) for _ in range(4)]
    apart = spectra([a for a, _ in pieces], [b for _, b in pieces], RATE_HZ)
    assert apart.segments == 4 * 3
    assert np.mean(apart.coherence > apart.by_chance) == pytest.approx(0.05, abs=0.04)


# Runs over one another, and power over time.


def test_runs_at_other_speeds_lie_together_by_distance():
    """Two runs over one bump 10 m ahead, at 2 and 4 m/s."""
    rows = []
    for run, speed in (("slow", 2.0), ("fast", 4.0)):
        place = speed * np.arange(1000) / RATE_HZ
        bump = Curve("measured", "#000", np.exp(-((place - 10.0) ** 2)))
        rows.append(Row(run, "A1", "", "m/s²", RATE_HZ, (bump,), place_m=place))
    look = Look(WHOLE, None, (0.5, 30.0))
    by_place, by_time = (
        picture(kind, rows, look).options["series"] for kind in (DISTANCE, OVERLAY)
    )
    tops = [
        [max(one["data"], key=lambda p: p[1])[0] for one in each] for each in (by_place, by_time)
    ]
    assert tops == [pytest.approx([10.0, 10.0], abs=0.05), pytest.approx([5.0, 2.5], abs=0.05)]
    assert len({one["itemStyle"]["color"] for one in by_place}) == 2
    on_rig = [replace(row, place_m=None) for row in rows]
    assert picture(DISTANCE, on_rig, look).options["xAxis"][0]["name"] == "time, s"


def test_a_spectrogram_follows_a_sweep():
    """5 to 25 Hz in 60 s: the strongest line rises with time; pieces are a tenth of the band's top
    times four waves long, and a fourth of that apart; a long record has no more of them."""
    time = np.arange(6000) / RATE_HZ
    sweep = np.sin(2 * np.pi * (5.0 * time + 20.0 / 60 / 2 * time**2))
    middle, frequency, power = power_over_time(sweep, RATE_HZ, (0.5, 30.0))
    strongest = frequency[power.argmax(axis=1)]
    assert strongest == pytest.approx(5.0 + 20.0 / 60 * middle, abs=1.0)
    assert frequency[1] - frequency[0] == pytest.approx(30.0 / 10 / 4, rel=0.01)
    assert middle[1] - middle[0] == pytest.approx(4 * 10 / 30.0 / 4, rel=0.1)
    assert 120 < len(middle) < 180
    assert 120 < len(power_over_time(np.tile(sweep, 10), RATE_HZ, (0.5, 30.0))[0]) < 180
    weak = sweep * np.where(time > 30.0, 10.0 ** (-40.0 / 20), 1.0)  # 40 dB down, still shown
    row = Row("r", "A1", "", "m/s²", RATE_HZ, (Curve("measured", "#000", weak),))
    (one,) = picture(SPECTROGRAM, [row], Look(WHOLE, None, (0.5, 30.0))).options["series"]
    levels = [cell[2] for cell in one["data"]]
    assert max(levels) == 0.0 and min(levels) >= -50.0
    assert max(cell[2] for cell in one["data"] if cell[0] > len(middle) * 0.6) < -35.0
