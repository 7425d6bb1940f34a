"""National Instruments TDMS, as npTDMS writes it."""

import io
import logging
from datetime import UTC, datetime

import numpy as np
import pytest

from tests.formats.foreign import G
from wheelhop.formats import ExchangeError, Map, read, understand

nptdms = pytest.importorskip("nptdms")
START = datetime(2026, 5, 1, 12, tzinfo=UTC)


def channel(name, values, group="car", **properties):
    return nptdms.ChannelObject(group, name, np.asarray(values), properties=properties)


def wave(name, values, step=0.005, start=0.25, **properties):
    timing = {"wf_increment": step, "wf_start_offset": start}
    return channel(name, values, **timing, **properties)


def saved(tmp_path, *segments):
    path = tmp_path / "run.tdms"
    with nptdms.TdmsWriter(path) as writer:
        for segment in segments:
            writer.write_segment(segment)
    return path


def test_waveforms_go_on_from_segment_to_segment(tmp_path):
    since = {"wf_start_time": np.datetime64(START.replace(tzinfo=None))}
    one = [
        wave("A1", [1.0, 2.0], unit_string="g", **since),
        wave("B1", [3, 4], unit_string="m/s^2", **since),
    ]
    more = [
        wave("A1", [5.0], unit_string="g", **since),
        wave("B1", [6], unit_string="", **since),
    ]
    found = read(saved(tmp_path, one, more))
    assert found.values == pytest.approx(np.array([[G, 3], [2 * G, 4], [5 * G, 6]]))
    assert (found.rate_hz, found.start_s) == (200.0, 0.25)
    assert found.start_unix_s == START.timestamp()


def test_groups_and_timings_are_told_apart(tmp_path):
    car = [wave("A1", [1.0, 2.0]), wave("B1", [3, 4])]
    engine = wave("rpm", [700.0], step=0.1, group="engine")
    path = saved(tmp_path, [*car, engine])
    with pytest.raises(ExchangeError, match=r'"car" \(2 channels\), "engine" \(1 channels\)'):
        read(path)
    assert read(path, Map(group="car")).values.shape == (2, 2)
    assert read(path, Map(group="engine")).rate_hz == 10.0
    path = saved(tmp_path, [*car, wave("speed", [1.0, 2.0], step=0.1)])
    with pytest.raises(ExchangeError, match=r'"car 1" \(2 channels\), "car 2" \(1 channels\)'):
        read(path)
    assert read(path, Map(group="car 2")).rate_hz == 10.0


def test_what_is_no_number_or_empty_is_left_out(tmp_path):
    texts = channel("note", ["bump", "kerb"])
    path = saved(tmp_path, [wave("A1", [1.0, 2.0]), texts, channel("none", np.empty(0))])
    assert [found.name for found in read(path).channels] == ["A1"]


@pytest.mark.parametrize(
    ("properties", "unit"),
    [
        ({"unit_string": "V"}, "V"),
        ({"NI_UnitDescription": "V", "unit": "g"}, "V"),
        ({"unit_string": 3, "Unit": "V"}, "V"),
        ({"unit_string": "", "unit": "V"}, "V"),
        ({}, ""),
    ],
)
def test_the_unit_is_the_first_text_that_is_one(properties, unit, tmp_path):
    (found,) = read(saved(tmp_path, [wave("x", [1.0, 2.0], **properties)])).channels
    assert found.unit == unit


def test_without_timing_a_mapping_gives_the_rate(tmp_path):
    path = saved(tmp_path, [channel("A1", [1.0, 2.0])])
    with pytest.raises(ExchangeError, match="has no time: give time or rate_hz in a mapping"):
        read(path)
    found = read(path, Map(rate_hz=50.0))
    assert (found.rate_hz, found.start_s, found.start_unix_s) == (50.0, 0.0, None)
    assert read(saved(tmp_path, [channel("A1", [1.0, 2.0], wf_increment=0.02)])).start_s == 0.0


STAMPS = np.datetime64("2026-05-01T12:00:00") + np.arange(3) * np.timedelta64(10, "ms")


@pytest.mark.parametrize(
    ("stamps", "unit", "start"),
    [
        (np.arange(3.0) * 10 + 500, "ms", 0.5),
        (np.arange(3.0) / 100 + 0.5, "s", 0.5),
        (STAMPS, "clock", 0.0),
    ],
)
def test_a_channel_may_be_time(stamps, unit, start, tmp_path):
    """Of those that are as long as it."""
    sets = [channel("when", stamps), channel("A1", [1.0, 2.0, 3.0]), channel("once", [7.0])]
    path = saved(tmp_path, sets)
    found = read(path, Map(time="when", time_unit=unit, group="car 1"))
    assert [channel.name for channel in found.channels] == ["A1"]
    assert (found.rate_hz, found.start_s) == (pytest.approx(100.0), start)
    with pytest.raises(ExchangeError, match="has no time"):
        read(path, Map(time="when", time_unit=unit, group="car 2"))
    if unit != "clock":
        with pytest.raises(ExchangeError, match="when holds numbers, not dates: give their time_"):
            read(path, Map(time="when", time_unit="clock", group="car 1"))


@pytest.mark.parametrize(
    ("step", "start"), [(-0.01, 0.0), (1e15, 0.0), (0.01, 1e15), (0.01, -1e15), (1e-15, 0.0)]
)
def test_absurd_timings_are_refused(step, start, tmp_path):
    path = saved(tmp_path, [wave("A1", [1.0, 2.0], step=step, start=start)])
    with pytest.raises(ExchangeError, match=r"run\.tdms: A1: from .* in steps of .* is no time"):
        read(path)


def test_a_file_whose_end_is_missing_says_so_in_its_history_and_nowhere_else(tmp_path):
    path = saved(tmp_path, [wave("A1", np.arange(100.0), step=0.01, start=0.0)])
    path.write_bytes(path.read_bytes()[:-80])
    console, printed = nptdms.log.log_manager.console_handler, io.StringIO()
    before, listeners = console.setStream(printed), list(logging.getLogger("nptdms").handlers)
    console.setLevel(logging.WARNING)
    try:
        found = read(path)
    finally:
        console.setStream(before)
    assert found.values[:, 0].tolist() == list(range(90))
    assert any("less data than expected" in step for step in found.history)
    assert printed.getvalue() == ""
    assert logging.getLogger("nptdms").handlers == listeners


def test_what_does_not_count_time_is_no_recording(tmp_path):
    """LabVIEW and DIAdem write spectra as waveforms."""
    found = read(saved(tmp_path, [wave("A1", [1.0, 2.0], 5.0, 250.0, wf_xunit_string="ms")]))
    assert (found.rate_hz, found.start_s) == (200.0, 0.25)
    with pytest.raises(
        ExchangeError, match="A1: its x axis is in Hz, not in time: this is a spectrum"
    ):
        read(saved(tmp_path, [wave("A1", [1.0, 2.0], wf_xunit_string="Hz")]))


@pytest.mark.parametrize(
    ("unit", "word"), [("Hz", "a spectrum"), ("mm", "a loop"), ("N", "a loop"), ("rev", "no recor")]
)
def test_what_is_no_recording_is_left_out_beside_one(unit, word, tmp_path):
    path = saved(tmp_path, [wave("A1", [1.0, 2.0]), wave("PSD", [1.0, 2.0], wf_xunit_string=unit)])
    found = read(path)
    assert [channel.name for channel in found.channels] == ["A1"]
    assert any(f"left out: PSD: its x axis is in {unit}, not in time" in s for s in found.history)
    assert any(word in step for step in found.history)


@pytest.mark.parametrize("kind", ["PieceWisePolynomial", "Rosette", "Map"])
def test_values_whose_scaling_is_not_known_are_raw_and_in_no_unit(kind, tmp_path):
    scaled = {"NI_Number_Of_Scales": 1, "NI_Scaling_Status": "unscaled", "unit_string": "g"}
    scaled["NI_Scale[0]_Scale_Type"] = kind
    found = read(saved(tmp_path, [wave("A1", [1.0, 2.0], **scaled)]))
    assert [(channel.unit, channel.point) for channel in found.channels] == [("", "")]
    assert found.values.tolist() == [[1.0], [2.0]]
    assert (
        f"A1: scaling {kind} is not known: the values are raw, in an unknown unit" in found.history
    )
    done = read(saved(tmp_path, [wave("A1", [1.0], **scaled | {"NI_Scaling_Status": "scaled"})]))
    assert done.channels[0].unit == "m/s²"


def since(ms):
    return {"wf_start_time": np.datetime64(START.replace(tzinfo=None)) + np.timedelta64(ms, "ms")}


def test_channels_that_began_at_other_times_are_shifted_and_not_put_in_step(tmp_path):
    early, late = wave("A1", [1.0, 2.0, 3.0], **since(10)), wave("B1", [4.0, 5.0, 6.0], **since(0))
    found = read(saved(tmp_path, [early, late]))
    nan = np.nan
    expected = [[nan, 4], [nan, 5], [1, 6], [2, nan], [3, nan]]
    assert np.array_equal(found.values, expected, equal_nan=True)
    assert found.start_unix_s == START.timestamp()
    path = saved(tmp_path, [early, wave("B1", [4.0, 5.0, 6.0], **since(7))])  # 0.6 steps
    with pytest.raises(ExchangeError, match="were not sampled together"):
        read(path)


def test_groups_on_one_clock_are_one_recording(tmp_path):
    one, two = since(0), since(0)
    path = saved(
        tmp_path, [wave("A1", [1.0, 2.0], **one), wave("A1", [3.0, 4.0], group="b", **two)]
    )
    found = read(path)
    columns = dict(zip((c.name for c in found.channels), found.values.T.tolist(), strict=True))
    assert columns == {"car/A1": [1.0, 2.0], "b/A1": [3.0, 4.0]}
    assert read(path, Map(group="b")).values.tolist() == [[3.0], [4.0]]
    unknown = saved(tmp_path, [wave("A1", [1.0, 2.0]), wave("B1", [3.0, 4.0], group="b")])
    with pytest.raises(ExchangeError, match="were not sampled together"):
        read(unknown)


def test_a_channel_that_is_called_time_is_time_if_its_unit_is_said(tmp_path):
    sets = [channel("Time", [0.0, 10.0, 20.0], unit_string="ms"), channel("A1", [1.0, 2.0, 3.0])]
    found = read(saved(tmp_path, sets))
    assert found.rate_hz == 100.0 and [c.name for c in found.channels] == ["A1"]
    sets[0] = channel("Time", [0.0, 10.0, 20.0])
    with pytest.raises(ExchangeError, match=r"has no time .the unit of Time is not said"):
        read(saved(tmp_path, sets))


def test_a_mapping_that_names_a_time_that_is_not_there_is_refused(tmp_path):
    path = saved(tmp_path, [wave("A1", [1.0, 2.0])])
    with pytest.raises(ExchangeError, match="there is no channel 'nope'; it has A1"):
        read(path, Map(time="nope"))


def test_an_axis_that_is_called_something_else_than_time_is_none(tmp_path):
    """Also where nobody says its unit."""
    for axis in ("Frequency", "Distance"):
        path = saved(tmp_path, [wave("A1", [1.0, 2.0], wf_xname=axis)])
        with pytest.raises(ExchangeError, match=f"A1: its x axis is {axis}, not time"):
            read(path)
    assert read(saved(tmp_path, [wave("A1", [1.0, 2.0], wf_xname="Time")])).rate_hz == 200.0


@pytest.mark.parametrize(("step", "odd"), [(1.0, True), (1e-6, True), (0.2, False), (1e-5, False)])
def test_a_rate_at_which_no_suspension_is_recorded_is_asked_about(step, odd, tmp_path):
    """A step of 1 is what LabVIEW writes where nobody has set one."""
    path = saved(tmp_path, [wave("A1", [1.0, 2.0, 3.0], step)])
    asked = [question.key for question in understand(path).questions]
    assert asked == (["rate_hz"] if odd else [])
    if odd:
        with pytest.raises(ExchangeError, match="Hz, at which no suspension is recorded"):
            read(path)
        said = understand(path, {"rate_hz": "200"}).mapping()
        assert read(path, said).rate_hz == 200.0
    else:
        assert read(path).rate_hz == pytest.approx(1 / step)
