"""Constants: what they make of codes, whom they refuse, and the file they live in."""

import datetime as dt
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.calibration import (
    CalibrationError,
    Constants,
    SensorConstants,
    Value,
    nominal_constants,
    read_constants,
    write_constants,
)
from wheelhop.calibration.merge import merged
from wheelhop.logger.recording import Channel, Recording

DAY = dt.date(2026, 5, 31)
NOON = dt.datetime(2026, 6, 1, 12, tzinfo=dt.UTC).timestamp()


def sensor(channel="B1", **changes):
    values = SensorConstants(
        channel=channel,
        serial=f"no. {channel}",
        gain=Value(0.5, 0.002),
        offset=Value(530.0, 0.3),
        date=DAY,
        valid_until=DAY + dt.timedelta(365),
        method="shaker",
        temperature_C=23.0,
        supply_V=3.3,
        reference="B&K 4382",
        certificate='C-"1"',
        corner_hz=Value(48.0, 0.4),
        delay_s=Value(0.0032, 0.00001),
    )
    return replace(values, **changes)


CONSTANTS = Constants("cal-1", 3, (sensor("B1"), sensor("A1", gain=Value(-0.4, 0.001))))


def recording(*channels, **changes):
    values = np.array([[530.0] * len(channels), [532.0] * len(channels), [np.nan] * len(channels)])
    known = {"notes": {"device": "3"}, "start_unix_s": NOON, **changes}
    return Recording(values, 100.0, channels, **known)


def test_codes_become_kinematic_acceleration_and_the_history_says_by_what():
    done = CONSTANTS.apply(recording(Channel("A1", "code"), Channel("B1", "code")))
    np.testing.assert_allclose(done.values, [[0, 0], [-0.8, 1.0], [np.nan, np.nan]])
    assert [(c.unit, c.sensor, c.calibration) for c in done.channels] == [
        ("m/s²", "no. A1", "cal-1"),
        ("m/s²", "no. B1", "cal-1"),
    ]
    assert done.history == ("codes to m/s² with calibration cal-1",)


@pytest.mark.parametrize(
    ("log", "words"),
    [
        (recording(Channel("B1", "code"), notes={"device": "4"}), "logger 4"),
        (recording(Channel("B9", "code")), "no constants for channel B9, only for B1, A1"),
        (recording(Channel("B1", "code", sensor="other")), "recorded with sensor other"),
        (recording(Channel("B1", "m/s²")), "calibrated before"),
        (recording(Channel("B1", "code"), notes={"calibration": "cal-2"}), "asks for cal-2"),
    ],
)
def test_constants_of_something_else_are_refused(log, words):
    with pytest.raises(CalibrationError, match=words) as error:
        CONSTANTS.apply(log)
    assert "\n" not in str(error.value)


def test_out_of_date_is_a_warning_that_stays_in_the_history():
    late = recording(Channel("B1", "code"), start_unix_s=NOON + 400 * 86400)
    assert CONSTANTS.warnings(late) == ("B1: out of date since 2027-05-31",)
    assert "out of date" in CONSTANTS.apply(late).history[-1]
    assert CONSTANTS.warnings(recording(Channel("B1", "code"))) == ()


def test_a_supply_that_sagged_is_a_warning_that_stays_in_the_history():
    notes = {"supply_mv": "3300", "low_supply_mv": "2950", "low_supply_s": "12.16"}
    sagged = recording(Channel("B1", "code"), notes=notes)
    sentence = "the sensors' supply fell from 3300 to 2950 mV (-11 %) at 12.16 s"
    assert CONSTANTS.warnings(sagged) == (sentence,)
    assert sentence in CONSTANTS.apply(sagged).history[-1]
    other = recording(Channel("B1", "code"), notes={"device": "3", "calibration": "cal-2"})
    assert "asks for calibration cal-2" in CONSTANTS.apply(other).history[-1]


def test_the_file_gives_back_what_was_written(tmp_path):
    write_constants(CONSTANTS, tmp_path / "calibration.toml")
    assert read_constants(tmp_path / "calibration.toml") == CONSTANTS
    bare = nominal_constants(["B1", "B2"])
    write_constants(bare, tmp_path / "nominal.toml")
    again = read_constants(tmp_path / "nominal.toml")
    assert again.sensors[1].gain.value == pytest.approx(bare.sensors[1].gain.value, rel=1e-6)
    assert again.sensors[1].delay_s is None and np.isnan(again.sensors[1].supply_V)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("format = 1", "", "'format' is missing"),
        ("gain_m_s2_per_code = 0.5\n", "", "'gain_m_s2_per_code' is missing"),
        ("gain_m_s2_per_code = 0.5\n", "gain_m_s2_per_code = 0\n", "must not be 0"),
        ("offset_code = 530.0", 'offset_code = "530"', "must be a number"),
        ("offset_code = 530.0", "offset_codes = 530.0", "did you mean 'offset_code'"),
        ("offset_code = 530.0", "offset_code = nan", "finite"),
        ("date = 2026-05-31", 'date = "yesterday"', "a day without quotes"),
        ('channel = "A1"', 'channel = "B1"', "several"),
        ("[[sensor]]", "[[sensor]", "not valid TOML"),
    ],
)
def test_a_mistake_in_the_file_is_one_line_that_names_it(tmp_path, old, new, words):
    path = tmp_path / "calibration.toml"
    write_constants(CONSTANTS, path)
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(CalibrationError, match=words) as error:
        read_constants(path)
    assert str(error.value).startswith(str(path)) and "\n" not in str(error.value)


@given(st.data())
def test_a_damaged_file_is_read_or_refused_and_nothing_else(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "damaged.toml"
    write_constants(CONSTANTS, path)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(content)))
        content[start : start + data.draw(st.integers(0, 8))] = data.draw(st.binary(max_size=6))
    path.write_bytes(content)
    try:
        read_constants(path)
    except CalibrationError as error:
        assert "\n" not in str(error)


@pytest.mark.parametrize(
    "number", ["1" + "0" * 400, "1e999", "inf", "true", "[1.0]", "0.0", "-48.0"]
)
def test_a_number_that_is_none_is_refused(tmp_path, number):
    path = tmp_path / "calibration.toml"
    write_constants(CONSTANTS, path)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("corner_hz = 48.0", f"corner_hz = {number}"), encoding="utf-8")
    with pytest.raises(CalibrationError, match="corner_hz"):
        read_constants(path)


def test_no_file_is_an_error_of_the_same_kind(tmp_path):
    with pytest.raises(CalibrationError, match="no such file"):
        read_constants(tmp_path / "none.toml")


def test_the_data_sheet_is_within_ten_per_cent():
    gain = nominal_constants(["B1"]).of("B1").gain
    assert gain.value == pytest.approx(9.80665 / (0.057 / 3 * 1024))
    assert gain.relative == pytest.approx(2 * 0.1 / 3**0.5)


def test_sessions_of_one_logger_make_one_file():
    again = Constants("cal-2", 3, (sensor("A1", serial="new"), sensor("A2")))
    both = merged(CONSTANTS, again)
    assert [(s.channel, s.serial) for s in both.sensors] == [
        ("B1", "no. B1"),
        ("A1", "new"),
        ("A2", "no. A2"),
    ]
    assert both.id == "cal-2"
    with pytest.raises(CalibrationError, match="logger 3"):
        merged(CONSTANTS, replace(again, device=5))


@given(st.floats(-1e6, 1e6), st.floats(1e-6, 1e3))
def test_a_value_is_written_to_two_digits_of_its_uncertainty(value, expanded):
    shown, limit = map(float, str(Value(value, expanded)).split(" ± "))
    assert abs(shown - value) <= 0.051 * max(expanded, limit)
    assert limit == pytest.approx(expanded, rel=0.06)
