"""The conversation: answers are heard, what is not answered is asked again, troubles are told."""

import itertools
import threading
import time

import pytest

from tests.patience import PATIENCE_S
from wheelhop.hil_sim.double import DoubleFaults, SerialDouble
from wheelhop.logger import LoggerError
from wheelhop.logger import link as link_module
from wheelhop.logger.frames import pack_frame
from wheelhop.logger.link import Link, Refused, Silent, connect
from wheelhop.logger.port import PortLost, SerialPort


class Script:
    """A port whose other end follows a script: for each line that comes, bytes to answer with, or
    something to do. What it says is there at once, however late threads get their turn."""

    name = "script"

    def __init__(self, *answers):
        self.answers = list(answers)
        self.heard = []
        self.link, self.gone = None, threading.Event()

    def read(self):
        if self.gone.wait(0.02):
            raise PortLost("script: the connection is lost")
        return b""

    def say(self, data):
        self.link._queue.put((time.monotonic(), data))

    def write(self, data):
        self.heard.append(data.split(b"*")[0].decode())
        if self.answers:
            answer = self.answers.pop(0)
            for item in answer if isinstance(answer, list) else [answer]:
                item() if callable(item) else self.say(item)

    def close(self):
        pass


def later(port, data):
    """Longer than a link waits for the first frame of a reply."""
    threading.Timer(0.5, port.say, [data]).start()


COUNTERS = itertools.count()


def frames(*items):
    """Frames `K`, `Ltext` and so on, counted on."""
    return b"".join(pack_frame(item[0], next(COUNTERS), item[1:].encode()) for item in items)


@pytest.fixture
def talk():
    links = []

    def make(*answers):
        port = Script(*answers)
        port.link = Link(port, reply_s=0.1)
        links.append(port.link)
        return port.link, port

    yield make
    for link in links:
        link.close()


def test_a_reply_that_was_lost_is_asked_for_again(talk):
    link, port = talk(b"", b"\x01\x02", frames("Lfirmware=1", "Lchannels=A", "K"))
    assert link.info() == {"firmware": "1", "channels": "A"}
    assert port.heard == ["info"] * 3


def test_a_reply_with_a_hole_is_asked_for_again(talk):
    lines = ("Lstate=ready", "Lend=", "Lwritten=5", "K")
    torn, whole = frames(*lines).replace(b"end", b"emd"), frames(*lines)
    link, port = talk(torn, whole)
    assert link.status() == {"state": "ready", "end": "", "written": "5"}
    assert port.heard == ["status"] * 2


def test_what_is_said_meanwhile_is_kept_in_its_order(talk):
    link, _ = talk(frames("Dfirst", "Lx=1", "Mcard", "K", "Dlast"))
    link.command("x")
    assert [frame.payload for frame in link.receive(0.2)] == [b"first", b"card", b"last"]


def test_a_refusal_is_told_and_not_repeated(talk):
    link, port = talk(frames("Eno card"))
    with pytest.raises(Refused, match=r"script: start: no card"):
        link.start()
    assert port.heard == ["start"]


def test_a_refusal_for_noise_is_repeated(talk):
    link, port = talk(frames("Echecksum"), frames("Eline too long or not plain text"), frames("K"))
    link.stream(True)
    assert port.heard == ["stream on"] * 3


def test_a_reply_that_comes_late_is_not_taken_for_the_next_one(talk):
    link, port = talk(b"", frames("KHOP00001.HOP"), frames("Ex"))
    link.command("start")
    port.say(frames("KHOP00001.HOP"))
    with pytest.raises(Refused):
        link.command("set x=1")


@pytest.mark.parametrize("command", [Link.start, Link.stop])
def test_a_long_command_that_was_not_heard_is_asked_again_soon(talk, command, monkeypatch):
    """By how long it waits for each frame, not by how long that takes on this machine."""
    link, port = talk(b"", frames("Lwait", "K"))
    waits_s, next_frame = {1: [], 2: []}, link._next

    def noted(deadline):
        waits_s[len(port.heard)].append(deadline - time.monotonic())
        return next_frame(deadline)

    monkeypatch.setattr(link, "_next", noted)
    command(link)
    assert len(port.heard) == 2
    assert sum(waits_s[1]) < 1.0 < link_module.SLOW_REPLY_S


def test_a_long_command_that_was_heard_is_waited_for(talk):
    link, port = talk([frames("Lwait"), lambda: later(port, frames("KHOP00001.HOP"))])
    assert link.start() == "HOP00001.HOP"
    assert port.heard == ["start"]


def test_of_a_command_that_was_heard_twice_the_last_answer_counts(talk):
    heard = [frames("Eno card", "Lwait"), lambda: later(port, frames("KHOP00001.HOP"))]
    link, port = talk(b"", heard)
    assert link.start() == "HOP00001.HOP"
    assert port.heard == ["start"] * 2


def test_a_restart_in_the_middle_of_a_reply_is_survived(talk):
    link, _ = talk(frames("Lfirmware=1", "Mready"), frames("Lchannels=A", "K"))
    assert link.info() == {"channels": "A"}
    assert [frame.text for frame in link.receive(0.0)] == ["ready"]


def test_frames_that_came_before_the_port_went_are_delivered(talk):
    link, port = talk()
    port.say(frames("Da", "Db"))
    port.gone.set()
    link._thread.join()
    assert len(link.receive(1.0)) == 2
    for _ in range(2):
        with pytest.raises(PortLost):
            link.receive(1.0)


def test_silence_nonsense_and_another_speed_are_told_apart(talk):
    link, _ = talk()
    with pytest.raises(Silent, match=r"no answer: is it the logger's port"):
        link.info()
    link, _ = talk(*[b"\xe1\xe5\xff" * 20] * 4)
    with pytest.raises(Silent, match=r"another speed\? The logger talks at 500000 baud"):
        link.info()


def test_a_line_that_cannot_be_sent_is_refused_at_once(talk):
    link, port = talk()
    with pytest.raises(LoggerError, match="at most 54"):
        link.set("name", "x" * 60)
    assert port.heard == []


def test_a_garbled_logger_is_told_with_its_speed():
    with (
        SerialDouble(faults=DoubleFaults(garbled=True), factor=20) as double,
        Link(SerialPort(double.url), reply_s=0.2) as link,
        pytest.raises(Silent, match="another speed"),
    ):
        link.info()


def test_slow_replies_and_a_bad_line_are_coped_with():
    faults = DoubleFaults(noise=1e-3, dropped=5e-4, duplicated=5e-4, reply_delay_s=0.5, seed=4)
    with SerialDouble(faults=faults, factor=5) as double, Link(SerialPort(double.url)) as link:
        link._reply_s = 0.4
        for rate in (100, 200, 400):
            link.set("rate", rate)
            assert link.info()["rate_hz"] == str(rate)


def test_one_program_at_a_time():
    with SerialDouble() as double, connect(double.url) as link:
        with pytest.raises(LoggerError, match="another program uses the port: close it"):
            connect(double.url)
        assert link.info()["firmware"] == "1.4.0"


@pytest.mark.parametrize(
    ("url", "meaning"),
    [
        ("/dev/ttyNONE7", "there is no such port"),
        ("socket://127.0.0.1:1", "nobody listens there"),
        ("nonsense://x", "not a port"),
    ],
)
def test_a_port_that_cannot_be_opened_is_told_in_a_line(url, meaning):
    with pytest.raises(LoggerError, match=meaning) as caught:
        connect(url)
    assert str(caught.value).startswith(url) and "\n" not in str(caught.value)


def test_a_port_of_somebody_elses_is_told_with_the_remedy(monkeypatch):
    class Denied:
        def open(self):
            raise PermissionError(13, "could not open port /dev/ttyUSB0: Permission denied")

    monkeypatch.setattr("serial.serial_for_url", lambda *args, **options: Denied())
    with pytest.raises(LoggerError, match="usermod -a -G dialout"):
        connect("/dev/ttyUSB0")


def test_the_logger_is_found_among_several_ports(monkeypatch):
    with SerialDouble(factor=20) as double:
        monkeypatch.setattr(link_module, "find_ports", lambda: ["/dev/ttyNONE7", double.url])
        with connect() as link:
            assert link.port.name == double.url
        monkeypatch.setattr(link_module, "find_ports", lambda: ["/dev/ttyNONE7", "/dev/ttyNONE8"])
        with pytest.raises(LoggerError, match="no logger answers: /dev/ttyNONE7: there is no"):
            connect()
        monkeypatch.setattr(link_module, "find_ports", lambda: [])
        with pytest.raises(LoggerError, match="plug the logger in"):
            connect()


def test_no_thread_is_left_behind():
    before = threading.active_count()
    with SerialDouble(port=0) as double, connect(double.url) as link:
        link.info()
    assert threading.active_count() == before


def test_waiting_ends_on_a_busy_machine(talk, monkeypatch):
    """A wait so short that it is over before it has begun must not become one without end."""
    monkeypatch.setattr(link_module, "LEAST_WAIT_S", 1e-7)
    link, _ = talk()
    busy, ended = threading.Event(), threading.Event()

    def work():
        while not busy.is_set():
            sum(range(1000))

    def listen():
        until = time.monotonic() + 4.0
        while time.monotonic() < until:
            link._queue.put((0.0, b""))  # as if a byte had been read that makes no frame yet
            link.receive(0.0)
        ended.set()

    for task in (work, work, work, listen):
        threading.Thread(target=task, daemon=True).start()
    assert ended.wait(PATIENCE_S)
    busy.set()
