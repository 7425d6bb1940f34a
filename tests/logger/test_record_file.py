"""The file that the host writes from frames, without a logger."""

from functools import partial

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.firmware.promises.reader import read_log
from tests.logger.test_record import HEADER, log_of
from wheelhop.hil_sim import sines
from wheelhop.hil_sim.double import DoubleFaults
from wheelhop.hil_sim.double.card import Card
from wheelhop.hil_sim.double.device import Device
from wheelhop.hil_sim.double.wire import Wire
from wheelhop.logger.block import pack_scans, scan_bytes
from wheelhop.logger.frames import Frame, FrameReader, pack_command, pack_scan_frame
from wheelhop.logger.link import Refused, Silent
from wheelhop.logger.live import Live
from wheelhop.logger.port import PortLost
from wheelhop.logger.read import read_log as decoded
from wheelhop.logger.record import free_path
from wheelhop.logger.record_file import LogWriter, StreamRecorder


@settings(max_examples=60)
@given(
    st.lists(st.integers(0, 2000), min_size=1, max_size=300),
    st.integers(1, 8),
    st.none() | st.integers(0, 50),
)
def test_any_scans_in_any_order_make_a_good_file(tmp_path_factory, numbers, channels, more):
    path = tmp_path_factory.mktemp("any") / "x.HOP"
    names = ["A", "B", "C", "D", "E", "F", "G", "H"][:channels] + ["-"] * (8 - channels)
    writer = LogWriter(path, 0x10001, {**HEADER, "channels": " ".join(names)}, channels)
    kept = {}
    for number in numbers:
        sums = [(number * 7 + k) % 8185 for k in range(channels)]
        if writer.add(number, pack_scans([sums])):
            kept[number] = tuple(sums)
        assert not writer.add(number, bytes(scan_bytes(channels) + 1))
    due = max(kept) + 1
    assert (writer.written, writer.due, writer.lost) == (len(kept), due, due - len(kept))
    writer.close(None if more is None else {"end": "command", "due": due + more})
    log = read_log(path.read_bytes())
    assert log.scans == kept and log.bad == []
    if more is not None:
        assert log.summary == {
            "end": "command",
            "due": str(due + more),
            "written": str(len(kept)),
            "lost": str(due + more - len(kept)),
        }


@settings(max_examples=60)
@given(st.data())
def test_no_sequence_of_frames_breaks_the_recorder(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("wild")
    count = iter(range(10_000))
    recorder = StreamRecorder(
        lambda session: folder / f"{next(count)}.HOP", lambda: dict(HEADER), dict, Live()
    )
    sessions = st.sampled_from([0, 0x10001, 0x20002])
    lines = st.sampled_from(
        ["session=00010001", "session=x", "rate_hz=0", "channels=", "due=5", "unix_s=1", "", "="]
    )
    for _ in range(data.draw(st.integers(0, 40))):
        kind = data.draw(st.sampled_from("DDDDBHSMX"))
        if kind == "D":
            number = data.draw(st.integers(0, 50) | st.integers(0, 2**32 - 1))
            size = data.draw(st.sampled_from([4, 4, 4, 13]))
            payload = pack_scan_frame(data.draw(sessions), number, bytes(size))
        else:
            payload = data.draw(lines.map(str.encode) | st.binary(max_size=48))
        recorder.feed(Frame(kind, 0, payload))
        recorder.tick()
    recorder._told_s = 0.0
    recorder.tick()
    recorder.end()
    for one in recorder.recorded:
        log_of(one)


@pytest.mark.parametrize("seed", range(12))
def test_through_any_noise_a_recording_is_a_part_of_the_session(tmp_path, seed):
    device = Device(sines(3.0), Card(tmp_path / "card"), DoubleFaults(seed=seed))
    sent = device.run(0.5)
    for command, seconds in (("stream on", 0.1), ("start", 15.0), ("stop", 1.0)):
        device.receive(pack_command(command))
        sent += device.run(device.time_s + seconds)
    chance = 10 ** -(2 + seed % 4)
    device_header = {**HEADER, "channels": "B1 B2 B3 B4 A1 A2 A3 A4"}
    wire = Wire(DoubleFaults(noise=chance, dropped=chance, duplicated=chance, seed=seed), 0)
    reader = FrameReader()
    recorder = StreamRecorder(partial(free_path, tmp_path), lambda: device_header, dict, Live())
    for begin in range(0, len(sent), 500):
        for frame in reader.feed(wire.carry(sent[begin : begin + 500])):
            recorder.feed(frame)
        recorder._told_s = 0.0
        recorder.tick()
    recorder.end()
    told = read_log((tmp_path / "card/HOP00001.HOP").read_bytes())
    mine = [one for one in recorder.recorded if one.session == told.session]
    assert len(mine) == 1 and log_of(mine[0]).scans.items() <= told.scans.items()
    assert mine[0].lost <= reader.lost + 1


@pytest.mark.parametrize("trouble", [PortLost, Silent, partial(Refused, reason="checksum")])
def test_scans_wait_for_a_logger_that_does_not_say_what_they_are(monkeypatch, tmp_path, trouble):
    """Lines of the header were lost, and then the port, or a logger in noise."""
    monkeypatch.setattr("wheelhop.logger.record_file.LINES_S", 0.0)
    answers = [trouble("the line is bad"), HEADER]

    def info():
        answer = answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    live = Live()
    recorder = StreamRecorder(partial(free_path, tmp_path), info, dict, live)
    stored = pack_scans([[1, 2]])
    for number in range(3):
        recorder.feed(Frame("D", number, pack_scan_frame(0xC0001, number, stored)))
        recorder.tick()
    recorder.end()
    (one,) = recorder.recorded
    assert (one.written, one.lost) == (3, 0) and sorted(log_of(one).scans) == [0, 1, 2]
    assert "the line is bad" in live.messages


def test_late_triggers_of_the_last_moment_are_told(tmp_path):
    writer = LogWriter(tmp_path / "HOP00012.HOP", 0xC0001, HEADER, 2)
    writer.add(0, pack_scans([[1, 2]]))
    writer.close({"end": "button", "due": 1, "late": 3})
    assert decoded(writer.path).late == 3


def test_a_wild_number_in_a_frame_makes_no_gap(tmp_path):
    path = tmp_path / "x.HOP"
    recorder = StreamRecorder(lambda session: path, lambda: dict(HEADER), dict, Live())
    recorder._told_s = 0.0
    for number in (0, 1, 2, 4_000_000, 3, 4, 5_000, 5_001):
        recorder.feed(Frame("D", 0, pack_scan_frame(0x10001, number, bytes(4))))
        recorder.tick()
    recorder.end()
    log = log_of(recorder.recorded[0])
    assert sorted(log.scans) == [0, 1, 2, 3, 4, 5_000, 5_001]
