"""DataFrames of samples: there and back, units, times, and what cannot be one."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import wheelhop as wh
from wheelhop.campaign import AXLE_POINTS, BODY_POINTS

UNITS = ("m/s²", "m/s", "m", "N", "V")
ACCELERATIONS = st.floats(-50, 50)
POINTS = (*AXLE_POINTS, *BODY_POINTS)


@given(
    values=arrays(float, st.tuples(st.integers(2, 30), st.integers(1, 8)), elements=ACCELERATIONS),
    rate_hz=st.sampled_from([20.0, 100.0, 400.0, 833.25]),
    start_s=st.sampled_from([0.0, 0.005, 12.5]),
    unit=st.sampled_from(UNITS),
)
def test_a_recording_comes_back_from_its_table(values, rate_hz, start_s, unit):
    channels = tuple(wh.Channel(point, unit, point) for point in POINTS[: values.shape[1]])
    recording = wh.Recording(values, rate_hz, channels, start_s, averaging_s=1e-3)
    table = recording.to_dataframe()
    assert table.index.name == "time_s" and table.shape == values.shape
    back = wh.Recording.from_dataframe(table, averaging_s=1e-3)
    sits = unit in ("m/s²", "V")  # accelerations, and what may yet become one
    assert back.channels == tuple(replace(one, point=one.point * sits) for one in channels)
    assert back.averaging_s == 1e-3
    assert back.rate_hz == pytest.approx(rate_hz, rel=1e-6)
    np.testing.assert_allclose(back.time_s, recording.time_s, atol=1e-9)
    np.testing.assert_array_equal(back.values, values)


def table_of(rows=50, **columns):
    named = columns or {"A1_m_s2": np.arange(rows) * 1.0}
    return pd.DataFrame({"time_s": np.arange(rows) / 100.0, **named})


def test_g_becomes_si():
    table = table_of(**{"A1_g": np.full(50, 0.5), "dash [g]": np.ones(50)})
    recording = wh.Recording.from_dataframe(table)
    assert [c.name for c in recording.channels] == ["A1", "dash"]
    assert [c.point for c in recording.channels] == ["A1", ""]
    assert {c.unit for c in recording.channels} == {"m/s²"}
    np.testing.assert_allclose(recording.values[0], [0.5 * 9.80665, 9.80665])


@pytest.mark.parametrize("as_index", ["time_s", "timedelta", "dates"])
def test_time_may_be_the_index(as_index):
    table = table_of().set_index("time_s")
    if as_index == "timedelta":
        table.index = pd.to_timedelta(table.index, unit="s")
    if as_index == "dates":
        table.index = pd.Timestamp("2026-11-23 12:00") + pd.to_timedelta(table.index, unit="s")
    recording = wh.Recording.from_dataframe(table)
    assert (recording.rate_hz, recording.start_s) == (100.0, 0.0)


def test_a_gap_becomes_rows_of_nan_and_is_told():
    recording = wh.Recording.from_dataframe(table_of().drop(range(20, 25)))
    assert len(recording.values) == 50
    assert np.flatnonzero(recording.missing).tolist() == [20, 21, 22, 23, 24]
    assert any("missing" in step for step in recording.history)


@pytest.mark.parametrize(
    "table, said",
    [
        (table_of(A1=np.ones(50)), "in which unit"),
        (table_of(A1_m_s2=["a"] * 50), r"not numbers: make it numbers \(pandas\.to_numeric\) or"),
        (table_of()[["time_s"]], "no column beside the time"),
        (table_of()[["A1_m_s2"]], "no time"),
        (table_of().iloc[::-1], "does not rise"),
    ],
)
def test_what_cannot_be_a_recording_is_told_in_a_line(table, said):
    with pytest.raises(wh.InputError, match=said) as caught:
        wh.Recording.from_dataframe(table)
    assert "\n" not in str(caught.value)


def test_columns_of_one_name_are_kept_apart_by_their_units():
    recording = wh.Recording.from_dataframe(table_of().assign(A1_g=1.0))
    assert {"A1 (m/s²)", "A1 (g)"} <= {channel.name for channel in recording.channels}
    column = [channel.name for channel in recording.channels].index("A1 (g)")
    assert recording.values[:, column] == pytest.approx(9.80665)


def test_a_rate_and_a_unit_may_be_given_instead():
    table = pd.DataFrame({"A1": np.arange(10.0)})
    recording = wh.Recording.from_dataframe(table, rate_hz=50.0, unit="g")
    assert recording.rate_hz == 50.0
    assert recording.values[1, 0] == pytest.approx(9.80665)


def test_a_run_is_a_recording_with_the_campaign_s_samples(campaign):
    run = campaign.runs[1]
    recording = campaign.recording(run.id)
    np.testing.assert_array_equal(recording.values, run.record)
    np.testing.assert_allclose(recording.time_s, run.time_s, atol=1e-9)
    assert [c.point for c in recording.channels] == [c.point for c in campaign.channels]
