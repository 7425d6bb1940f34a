"""The serial double: its scans are the converter's, its faults are as configured."""

import subprocess
import sys
import threading
import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.firmware.promises.reader import read_log
from tests.patience import wait_until
from wheelhop.campaign import CampaignError, Channel, read_campaign
from wheelhop.cli.emulate import _of_campaign
from wheelhop.hil_sim import constant, from_array, ramp
from wheelhop.hil_sim.double import DoubleFaults, SerialDouble, from_campaign, scan_sums
from wheelhop.hil_sim.double.card import Card
from wheelhop.hil_sim.double.codes import inputs_of
from wheelhop.hil_sim.double.device import Device
from wheelhop.hil_sim.double.wire import Wire
from wheelhop.logger import LoggerError
from wheelhop.logger import read_log as wheelhop_log
from wheelhop.logger.frames import FrameReader, acknowledgement, pack_command, streamed_scan
from wheelhop.logger.link import connect
from wheelhop.logger.port import PortLost

CAMPAIGN = "examples/clean"
POTS = "examples/pots-gyro-gps"
RUN = "washboard-high-fast"


@pytest.mark.parametrize("conversions", [8, 4, 2])
def test_all_sums_of_a_scan_have_the_instant_that_the_specification_says(conversions):
    """On a ramp the mean code of a channel tells the mean instant of its conversions."""
    slope = 100.0  # codes per second, the same for all
    sums = scan_sums(ramp(10.0, slope, seconds=9.0), conversions, 0, 800)
    number = np.arange(800)[:, None]
    instant_s = (number * 8 * conversions + (8 * conversions - 1) / 2) * 156.25e-6
    expected = 10.0 + slope * instant_s - 0.5  # rounded down: half a code less in the mean
    error = (sums / conversions - expected)[sums[:, 0] < 900 * conversions]
    assert abs(error.mean()) < 0.02 and np.abs(error).max() < 0.6


def test_codes_are_rounded_down_and_limited():
    codes = [0.99, 1.0, 511.5, 1023.0, 1023.9, 2000.0, -5.0, 0.0]
    assert (scan_sums(constant(codes), 8, 0, 1)[0] // 8).tolist() == [0, 1, 511, *[1023] * 3, 0, 0]


def test_scans_do_not_depend_on_how_many_are_asked_for():
    rng = np.random.default_rng(2)
    signals = from_array(rng.uniform(0, 1024, (50, 8)), 37.0, repeat=True)
    whole = scan_sums(signals, 4, 0, 400)
    parts = [scan_sums(signals, 4, first, 100) for first in range(0, 400, 100)]
    np.testing.assert_array_equal(np.concatenate(parts), whole)


def test_a_run_of_a_campaign_comes_back_in_its_units():
    signals = from_campaign(CAMPAIGN, RUN)
    campaign = read_campaign(CAMPAIGN)
    (run,) = [run for run in campaign.runs if run.id == RUN]
    points = [channel.point for channel in campaign.channels]
    for column, point in ((0, "B1"), (7, "A4")):
        felt = (signals.codes[:, column] - 512.0) / 19.5 * 9.80665
        np.testing.assert_allclose(felt, run.record[:, points.index(point)], atol=1e-9)
    with pytest.raises(CampaignError, match=r"no run 'x', there are washboard"):
        from_campaign(CAMPAIGN, "x")


def test_potentiometers_are_at_the_inputs_left_over():
    """Four of them and the accelerometer of a shipped car; its gyros and GPS are no voltages."""
    campaign = read_campaign(POTS)
    places = {campaign.channels[k].name: place for k, place in inputs_of(campaign).items()}
    assert places == {"pot_fl": 0, "pot_fr": 1, "pot_rl": 2, "pot_rr": 3, "imu": 4}
    run = campaign.runs[0]
    signals = from_campaign(POTS, run.id)
    pot = [channel.name for channel in campaign.channels].index("pot_rl")
    travel = (signals.codes[:, 2] - 512.0) * 0.1 / 1024
    np.testing.assert_allclose(travel, run.record[:, pot], atol=1e-12)
    np.testing.assert_array_equal(signals.codes[:, 5:], 512.0)


def test_points_keep_their_inputs_beside_potentiometers():
    clean = read_campaign(CAMPAIGN)
    pot = Channel("pot", "S1", quantity="travel", unit="m")
    kept = [c for c in clean.channels if c.point != "B3"]
    found = inputs_of(replace(clean, channels=(pot, *kept)))
    assert found[0] == 2 and {found[k] for k in range(1, 8)} == {0, 1, 3, 4, 5, 6, 7}


def test_an_emulated_logger_says_what_is_at_its_inputs():
    ((words, signals),) = _of_campaign(POTS, None)
    assert "A0 pot_fl, A1 pot_fr, A2 pot_rl, A3 pot_rr, A4 imu" in words
    assert "100 mm are codes 0 to 1024" in words and signals.repeat


def device(card=None, **faults):
    one = Device(constant(300.0), card and Card(card), DoubleFaults(**faults))
    one.run(0.5)
    return one


def frames_of(data):
    reader = FrameReader()
    frames = reader.feed(data)
    assert reader.broken == reader.lost == 0
    return frames


def session_of(one, seconds):
    """The frames of a streamed session."""
    data = b""
    for command in ("stream on", "start"):
        one.receive(pack_command(command))
        data += one.run(one.time_s + 0.1)
    data += one.run(one.time_s + seconds)
    one.receive(pack_command("stop"))
    return frames_of(data + one.run(one.time_s + 6.0))


def test_the_same_bytes_come_of_the_same_arguments(tmp_path):
    runs = []
    for name in "ab":
        one = device(tmp_path / name, stalls={3: 0.4})
        runs.append([(f.kind, f.counter, f.payload) for f in session_of(one, 3.0)])
    assert runs[0] == runs[1]
    assert (tmp_path / "a/HOP00001.HOP").read_bytes() == (tmp_path / "b/HOP00001.HOP").read_bytes()


def test_a_stall_within_memory_loses_nothing_and_one_beyond_loses_what_does_not_fit(tmp_path):
    for stall_s, lost in ((0.6, 0), (2.0, 200 - 2 * 37)):
        card = tmp_path / f"{stall_s}"
        frames = session_of(device(card, stalls={4: stall_s}), 6.0)
        log = read_log((card / "HOP00001.HOP").read_bytes())
        assert int(log.summary["stall_ms"]) == 1000 * stall_s
        assert abs(int(log.summary["lost"]) - lost) <= 2
        assert len(log.scans) + int(log.summary["lost"]) == int(log.summary["due"])
        streamed = [streamed_scan(frame) for frame in frames if frame.kind == "D"]
        assert sum(scan.session == log.session for scan in streamed) == int(log.summary["due"])
        told = [acknowledgement(frame) for frame in frames if frame.kind == "B"]
        assert told[-1].lost == int(log.summary["lost"])


def test_lost_scans_are_counted_in_the_file(tmp_path):
    session_of(device(tmp_path, lost=(range(50, 60), range(200, 201))), 3.0)
    log = read_log((tmp_path / "HOP00001.HOP").read_bytes())
    assert log.summary["lost"] == "11" and 55 not in log.scans and 200 not in log.scans


def test_a_full_file_rolls_over_to_the_next(tmp_path, monkeypatch):
    monkeypatch.setattr("wheelhop.hil_sim.double.session.MEBIBYTE", 20 * 512)
    one = device(tmp_path)
    for command in ("set size_mb=1", "start"):
        one.receive(pack_command(command))
        one.run(one.time_s + 0.1)
    one.run(one.time_s + 10.0)
    log = read_log((tmp_path / "HOP00001.HOP").read_bytes())
    assert log.summary["end"] == "full" and 16 < len(log.blocks) <= 20
    following = read_log((tmp_path / "HOP00002.HOP").read_bytes())
    assert following.header["continues"] == f"{log.session:08X}"


def test_without_a_card_it_says_so():
    one = device()
    one.receive(b"start\n")
    heard, answer = frames_of(one.run(one.time_s + 1.0))
    assert heard.kind == "L" and heard.text == "wait"
    assert answer.kind == "E" and answer.text.startswith("no card")


def test_the_line_does_what_the_faults_say():
    data = bytes(range(256)) * 400
    assert Wire(DoubleFaults(), 0).carry(data) == data
    noisy = np.frombuffer(Wire(DoubleFaults(noise=0.01), 0).carry(data), np.uint8)
    changed = noisy ^ np.frombuffer(data, np.uint8)
    assert 0.008 < (changed > 0).mean() < 0.012
    assert (changed & (changed - 1) == 0).all()  # never more than one bit
    assert 0.98 < len(Wire(DoubleFaults(dropped=0.01), 0).carry(data)) / len(data) < 0.995
    assert 1.005 < len(Wire(DoubleFaults(duplicated=0.01), 0).carry(data)) / len(data) < 1.02
    assert b"\0" not in Wire(DoubleFaults(garbled=True), 0).carry(data)


@pytest.mark.parametrize("port", [None, 0])
def test_the_line_goes_and_comes_back_under_its_name(port):
    with SerialDouble(factor=10, port=port) as one:
        for _ in range(2):
            with connect(one.url) as link:
                assert link.info()["firmware"] == "1.4.0"
                one.tear(3.0)
                with pytest.raises(PortLost):
                    for _ in range(3):
                        link.receive(5.0)
                with pytest.raises(LoggerError):
                    connect(one.url)
            back_s = one.time_s + 3.5
            wait_until(lambda back_s=back_s: one.time_s > back_s)


def test_disconnects_happen_when_they_are_due():
    with SerialDouble(faults=DoubleFaults(disconnects=((0.0, 1e9),)), factor=10) as gone:
        wait_until(lambda: gone.time_s > 0.1)
        with pytest.raises(LoggerError, match="there is no such port"):
            connect(gone.url)
    with SerialDouble(faults=DoubleFaults(disconnects=((0.0, 1.0),)), factor=10) as back:
        wait_until(lambda: back.time_s > 1.1)
        connect(back.url).close()


def test_faster_than_real_time_it_waits_for_a_computer_that_is_busy(monkeypatch):
    """In real time it makes up for it."""
    stands_still = threading.Event()

    def clock():
        """Ten seconds have passed since the first look, and none afterwards."""
        if stands_still.is_set():
            return 10.0
        stands_still.set()
        return 0.0

    for factor, passes in ((10.0, False), (1.0, True)):
        stands_still.clear()
        busy = SimpleNamespace(monotonic=clock, sleep=time.sleep)
        monkeypatch.setattr("wheelhop.hil_sim.double.serial_double.time", busy)
        with SerialDouble(factor=factor) as one:
            wait_until(lambda: one.time_s > 0.0)
            assert one.totals == {}  # said when the turn is over
            assert one.time_s == pytest.approx(10.0 if passes else 0.1)


def test_it_runs_as_a_program(tmp_path):
    command = [sys.executable, "-m", "wheelhop.hil_sim.double"]
    options = ["--campaign", CAMPAIGN, "--run", RUN, "--card", str(tmp_path), "--seconds", "20"]
    with subprocess.Popen([*command, *options], stdout=subprocess.PIPE, text=True) as process:
        url = process.stdout.readline().split()[-1]
        with connect(url) as link:
            assert link.start() == "HOP00001.HOP"
        process.kill()
    done = subprocess.run([*command, "--campaign", CAMPAIGN, "--run", "x"], capture_output=True)
    assert done.returncode == 2 and done.stderr.count(b"\n") == 1


def test_a_sag_of_the_supply_is_in_its_file(tmp_path):
    session_of(device(tmp_path, supply=((1.0, 2950), (1.6, 3300))), 3.0)
    log = wheelhop_log(tmp_path / "HOP00001.HOP")
    (fell, low), (rose, again) = log.supply
    assert (low, again) == (2950, 3300) and 30 <= rose - fell <= 90
    assert log.summary["lowest_mv"] == "2950" and log.missing == 0 and not log.damage
