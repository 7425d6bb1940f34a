"""A board that converts all inputs at once, with 16 bits: the double speaks it, we read it."""

import numpy as np
import pytest

from tests.patience import wait_until
from wheelhop.hil_sim import sines
from wheelhop.hil_sim.double import SerialDouble
from wheelhop.hil_sim.double.kind import ALL_AT_ONCE
from wheelhop.logger import LoggerError, read_log
from wheelhop.logger.block import BLOCK_BYTES, pack_scans, scan_bytes, unpack_scans
from wheelhop.logger.correct import correct_window
from wheelhop.logger.live import Live
from wheelhop.logger.record import RecordOptions, record
from wheelhop.logger.recovery import recover
from wheelhop.logger.settings import parse_settings

HEADER = {
    **{"rate_hz": "200", "conversions": "32", "channels": "B1 - - - - - - A4"},
    **{"order": "together", "sum_bits": "22", "code_bits": "16", "conversions_hz": "6400"},
}


@pytest.mark.parametrize("bits", [13, 16, 22, 24, 32])
def test_sums_of_any_width_come_back(bits):
    sums = np.random.default_rng(1).integers(0, 1 << bits, (50, 7))
    stored = pack_scans(sums, bits)
    assert len(stored) == 50 * scan_bytes(7, bits)
    assert np.array_equal(unpack_scans(stored, 7, bits), sums)


def test_codes_are_of_1024_whatever_the_converter_has():
    settings = parse_settings(HEADER, "log")
    assert settings.inputs == ((0, "B1"), (7, "A4")) and settings.steps == 32
    assert settings.codes(np.array([32 * 32768])) == pytest.approx([512.0])


@pytest.mark.parametrize(
    "wrong",
    [{"conversions": "16"}, {"sum_bits": "20"}, {"code_bits": ""}, {"channels": "B1"}],
)
def test_settings_that_contradict_one_another_are_refused(wrong):
    with pytest.raises(LoggerError):
        parse_settings(HEADER | wrong, "log")


def test_what_is_streamed_is_what_the_card_has_and_what_the_sensors_put_out(tmp_path):
    """To a 64th of a code, and behind the averaging that is undone to a tenth of one."""
    card, out = tmp_path / "card", tmp_path / "out"
    out.mkdir()
    shown = sines([2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0], seconds=30.0)
    live = Live()
    with SerialDouble(shown, card, factor=10.0, kind=ALL_AT_ONCE, acts=[shown]) as double:
        options = RecordOptions(out=out, port=double.url, start=True, seconds=3.0)
        (one,) = record(options, live).files
    log, told = read_log(one.path), read_log(card / one.path.name)
    for source in (one.path, card / one.path.name):
        data = source.read_bytes()
        assert {data[k : k + 4] for k in range(0, len(data), BLOCK_BYTES)} == {b"HOP2"}
    assert log.written == told.written == log.due > 250
    assert np.array_equal(log.recording().values, told.recording().values)
    assert live.scan.sum_bits == 22 and np.abs(live.window(1.0) - 512).max() < 201
    recording = correct_window(told.recording())
    inner = slice(60, -60)
    expected = 512 + 200 * np.sin(2 * np.pi * np.arange(2, 10) * recording.time_s[inner, None])
    assert np.abs(recording.values[inner] - expected).max() < 0.1


def test_a_file_without_its_end_is_recovered_as_format_2(tmp_path):
    card = tmp_path / "card"
    with SerialDouble(card=card, factor=20.0, kind=ALL_AT_ONCE) as double:
        double.press_button()
        wait_until(lambda: double.totals.get("written", 0) > 200)
    path = card / "HOP00001.HOP"
    (saved,) = recover(path, tmp_path / "saved")
    data = saved.path.read_bytes()
    assert {data[k : k + 4] for k in range(0, len(data), BLOCK_BYTES)} == {b"HOP2"}
    log = read_log(saved.path)
    assert log.summary is not None and log.written == read_log(path).written > 200
