"""The host's file says what the logger sent, whatever happens to line, logger and disk."""

import signal
import subprocess
import sys
import threading
import time
from itertools import pairwise
from types import SimpleNamespace

import pytest

from tests.firmware.promises.reader import read_log
from tests.patience import PATIENCE_S, wait_until
from wheelhop.hil_sim import constant
from wheelhop.hil_sim.double import DoubleFaults, SerialDouble
from wheelhop.logger import LoggerError
from wheelhop.logger.link import connect
from wheelhop.logger.live import Live
from wheelhop.logger.record import RecordOptions, record
from wheelhop.logger.record_file import LogWriter

FACTOR = 20.0
CARD_TOTALS = ("due", "written", "lost")
HEADER = {"rate_hz": "100", "conversions": "8", "channels": "B1 - - - - - - A4"}

SCRIPT = """
import sys
from pathlib import Path
from wheelhop.logger import LoggerError
from wheelhop.logger.record import RecordOptions, free_path, record
{before}
def tell(live):
    print(live.written, flush=True)
try:
    record(RecordOptions(out=Path(sys.argv[2]), port=sys.argv[1], start=True), on_tick=tell)
except LoggerError as error:
    print(error)
    sys.exit(2)
"""


def go(double, out, live=None, **options):
    """Record from a double."""
    return record(RecordOptions(out=out, port=double.url, **options), live or Live())


def log_of(recorded):
    """The file as a decoder written from the specification reads it; its totals agree."""
    log = read_log(recorded.path.read_bytes())
    assert log.bad == [] and len(log.scans) == recorded.written
    before = 0
    for block in log.blocks:
        if block.kind == b"D":
            assert block.first_scan == before + block.lost
            before += block.count
    if log.summary:
        due, written, lost = (int(log.summary[key]) for key in CARD_TOTALS)
        assert due == written + lost and written == len(log.scans) and lost == recorded.lost
    return log


def when(double, due, action):
    """Do something as soon as so many scans of a session are due."""

    def wait():
        until_due(double, due)
        action()

    threading.Thread(target=wait, daemon=True).start()


def until_due(double, due):
    """Wait until so many scans of a session are due."""
    wait_until(lambda: double.totals.get("due", 0) >= due)


@pytest.fixture
def card(tmp_path):
    return tmp_path / "card"


@pytest.fixture
def out(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    return folder


def card_log(card, recorded):
    return read_log((card / recorded.path.name).read_bytes())


def test_a_session_is_recorded_as_the_card_has_it(card, out):
    live = Live()
    with SerialDouble(card=card, factor=FACTOR) as double:
        (one,) = go(double, out, live, start=True, seconds=20).files
        totals = double.totals
    log, told = log_of(one), card_log(card, one)
    assert one.card == (totals["due"], totals["written"], totals["lost"]) and one.lost == 0
    assert log.scans == told.scans and log.session == told.session
    assert {**told.header, "source": "stream"} == log.header
    assert told.summary.items() <= log.summary.items()
    assert log.summary["card_written"] == told.summary["written"]
    assert "B1" in live.channels and live.broken == 0 and live.told.blocks > 40


def test_what_the_line_loses_is_missing_and_never_made_up(card, out):
    faults = DoubleFaults(noise=6e-4, duplicated=2e-4, dropped=2e-4)
    with SerialDouble(card=card, faults=faults, factor=FACTOR) as double:
        (one,) = go(double, out, start=True, seconds=20).files
        totals = double.totals
    log, told = log_of(one), card_log(card, one)
    assert 0 < one.lost < 0.06 * one.card[0] and one.card == (totals["due"], totals["written"], 0)
    assert log.scans.items() <= told.scans.items()
    assert int(log.summary["due"]) == len(told.scans)


def test_what_the_card_loses_the_line_may_still_have(card, out):
    faults = DoubleFaults(lost=(range(100, 130),), stalls={20: 2.0})
    with SerialDouble(card=card, faults=faults, factor=FACTOR) as double:
        (one,) = go(double, out, start=True, seconds=20).files
    log, told = log_of(one), card_log(card, one)
    assert one.lost == 0 and sorted(log.scans) == list(range(int(told.summary["due"])))
    assert one.card[2] == int(told.summary["lost"]) > 30 + 2 * 100 - 74 - 37
    assert set(log.scans) - set(told.scans) >= set(range(100, 130))


def test_a_line_that_comes_back_goes_on_in_the_same_file(card, out):
    live = Live()
    with SerialDouble(card=card, factor=FACTOR) as double:
        for due in (500, 1800):
            when(double, due, lambda: double.tear(6.0))
        (one,) = go(double, out, live, start=True, seconds=30).files
        totals = double.totals
    log, told = log_of(one), card_log(card, one)
    # Twice six seconds, less what the logger kept for the line, and until the host is back.
    assert one.card == (totals["due"], totals["written"], 0) and 1100 < one.lost < one.card[0]
    assert log.scans.items() <= told.scans.items() and told.summary["lost"] == "0"
    assert sum("is back" in message for message in live.messages) == 2


def test_a_restart_begins_another_file_and_both_are_whole(card, out):
    live = Live()
    with SerialDouble(card=card, factor=FACTOR) as double:
        when(double, 1000, double.reset)
        first, second = go(double, out, live, start=True, seconds=30).files
    for one in (first, second):
        log, told = log_of(one), card_log(card, one)
        assert log.session == told.session
        # What was in the logger's memory at the restart is on the host alone; what the logger has
        # recorded afterwards, until the host asked for it, on the card.
        common = set(log.scans) & set(told.scans)
        assert len(common) > 500
        assert all(number < min(log.scans) for number in set(told.scans) - common)
        assert all(log.scans[number] == told.scans[number] for number in common)
    assert read_log(first.path.read_bytes()).summary["end"] == "recovered"
    assert first.card is None and second.card is not None
    assert "the logger has restarted" in live.messages


def test_the_button_ends_the_file(card, out):
    with SerialDouble(card=card, factor=FACTOR) as double:
        when(double, 800, double.press_button)
        (one,) = go(double, out, start=True).files
    assert log_of(one).summary["end"] == "button" and one.lost == 0


def test_a_session_that_runs_already_is_joined_and_left_running(card, out):
    with SerialDouble(card=card, factor=FACTOR) as double:
        double.press_button()
        until_due(double, 200)
        (one,) = go(double, out, seconds=5).files
        until_due(double, one.written + one.lost + 1)  # it goes on
    log = log_of(one)
    assert one.written >= 500  # five seconds of its rest
    assert log.session >> 16 == 1 and one.lost == min(log.scans) > 100
    assert log.header["channels"] == "B1 B2 B3 B4 A1 A2 A3 A4"


def test_without_a_card_the_stream_is_recorded(out):
    with SerialDouble(constant(300.0), factor=FACTOR) as double:
        (one,) = go(double, out, seconds=10).files
        with pytest.raises(LoggerError, match="start: no card"):
            go(double, out, start=True)
    log = log_of(one)
    assert one.path.name == "HOP00000.HOP" and 0 < log.session < 0x10000
    assert set(log.scans.values()) == {(2400,) * 8} and one.lost == 0


def test_no_file_is_overwritten(card, out):
    with SerialDouble(factor=FACTOR) as double:
        names = [go(double, out, seconds=2).files[0].path.name for _ in range(2)]
        mine = out / "mine.HOP"
        assert go(double, mine, seconds=2).files[0].path == mine
        before = mine.read_bytes()
        with pytest.raises(LoggerError, match="it will not be overwritten"):
            go(double, mine, seconds=2)
        with pytest.raises(LoggerError, match="there is no such folder"):
            go(double, out / "none", seconds=2)
    assert names == ["HOP00000.HOP", "HOP00000-2.HOP"] and mine.read_bytes() == before


def spawn(double, out, before=""):
    command = [sys.executable, "-c", SCRIPT.format(before=before), double.url, str(out)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def test_who_kills_the_process_loses_less_than_a_second(card, out):
    """Of what had come when it was killed, and it told before that."""
    with SerialDouble(card=card, factor=1.0) as double:
        process = spawn(double, out)
        came = next(int(line) for line in process.stdout if int(line) >= 200)
        process.kill()
        process.wait()
    data = (out / "HOP00001.HOP").read_bytes()
    log = read_log(data)
    assert len(data) % 512 == 0 and log.bad == [] and log.summary is None
    assert sorted(log.scans) == list(range(len(log.scans))) and len(log.scans) > came - 100


def test_an_interrupt_ends_it_in_good_order(card, out):
    with SerialDouble(card=card, factor=FACTOR) as double:
        process = spawn(double, out)
        until_due(double, 500)
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=PATIENCE_S) and process.returncode == 0
        log = read_log((out / "HOP00001.HOP").read_bytes())
        assert log.summary["end"] == "command" and log.summary["lost"] == "0"
        assert int(log.summary["due"]) == double.totals["written"]


def test_who_gives_up_waiting_for_the_line_keeps_what_came(card, out):
    """The line is lost when 300 scans have come: the logger may be ahead of a slow host."""
    with SerialDouble(card=card, factor=FACTOR) as double:
        live = Live()

        def tear(live):
            if live.connected and live.written > 300:
                double.tear(1e6)

        options = RecordOptions(out=out, port=double.url, start=True)
        (one,) = record(options, live, tear, lambda: not live.connected).files
    assert log_of(one).summary["end"] == "command" and one.written > 300 and one.card is None


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on the size of files")
def test_a_full_disk_is_told_and_harms_nothing(card, out):
    limit = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000))"
    with SerialDouble(card=card, factor=FACTOR) as double:
        process = spawn(double, out, limit)
        told = process.communicate(timeout=PATIENCE_S)[0].splitlines()[-1]
        assert process.returncode == 2
        until_due(double, double.totals["due"] + 100)  # it goes on on its card
        assert double.totals["due"] >= double.totals["written"] > 16 * 37
    file = out / "HOP00001.HOP"
    assert told.startswith(f"{file}: ") and "wheelhop download" in told
    log = read_log(file.read_bytes())
    assert file.stat().st_size == 17 * 512 and log.bad == []
    assert sorted(log.scans) == list(range(len(log.scans))) and len(log.scans) > 500


def test_a_folder_that_takes_no_files_is_told(monkeypatch, out):
    with monkeypatch.context() as patch, pytest.raises(LoggerError, match="may not write there"):
        patch.setattr("wheelhop.logger.record.os.access", lambda *_: False)
        record(RecordOptions(out=out, port="never opened"))

    def denied(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("wheelhop.logger.record_file.os.open", denied)
    with pytest.raises(LoggerError, match=r"HOP00001.HOP: Permission denied"):
        LogWriter(out / "HOP00001.HOP", 0x10001, HEADER, 2)


def test_the_clock_error_is_stored_in_the_logger(monkeypatch, card, out):
    """The host's clock is the double's own, but for the error: however slow the machine is, both
    are."""
    monkeypatch.setattr("wheelhop.logger.record.CLOCK_AFTER_S", 30.0)
    monkeypatch.setattr("wheelhop.logger.clock.SOUND_PPM", 10_000.0)
    with SerialDouble(card=card, factor=FACTOR) as double:
        clock = SimpleNamespace(monotonic=lambda: 1.01 * double.time_s, time=time.time)
        monkeypatch.setattr("wheelhop.logger.link.time", clock)
        result = go(double, out, start=True, seconds=40.0)
        stored = int(card_log(card, result.files[0]).summary["clock_ppm"])
    assert stored == round(result.clock.ppm) and abs(stored - 10_000) < 2000


@pytest.fixture
def small_files(monkeypatch):
    """A file is full after 20 blocks: 7 s of eight channels."""
    monkeypatch.setattr("wheelhop.hil_sim.double.session.MEBIBYTE", 20 * 512 // 128)


def test_a_file_that_is_full_does_not_cut_the_recording(card, out, small_files):
    """The logger goes on in the next file, and so does the host, until the time is over."""
    with SerialDouble(card=card, factor=FACTOR) as double:
        files = go(double, out, start=True, seconds=20).files
    assert len(files) >= 3 and sum(one.written for one in files) >= 19 * 100
    for before, after in pairwise(files):
        log, told = log_of(after), card_log(card, after)
        assert log.header["continues"] == f"{before.session:08X}" == told.header["continues"]
        assert log.scans == told.scans and after.lost == 0
    assert log_of(files[0]).summary["end"] == "full"


def test_a_full_file_ends_the_recording_where_nothing_goes_on(card, out, small_files):
    with SerialDouble(card=card, factor=FACTOR) as double:
        with connect(double.url) as link:
            link.set("resume", "off")
        (one,) = go(double, out, start=True, seconds=60).files
    assert log_of(one).summary["end"] == "full" and one.lost == 0
