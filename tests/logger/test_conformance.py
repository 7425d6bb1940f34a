"""Double and firmware speak alike: what SPEC.md says of the line, asked of both (if built)."""

import random
import re
import subprocess
import sys
import time

import pytest

from tests.firmware.promises.conftest import SMALL, built
from tests.firmware.promises.logger import configure
from tests.firmware.promises.reader import read_log
from tests.logger.benches import CODES, BoardBench, DoubleBench
from tests.patience import PATIENCE_S
from wheelhop.hil_sim import CardImage
from wheelhop.logger.block import BLOCK_BYTES, unpack_scans
from wheelhop.logger.download import Downloader
from wheelhop.logger.frames import acknowledgement, pack_command, streamed_scan
from wheelhop.logger.link import Refused, connect
from wheelhop.logger.record import RecordOptions
from wheelhop.logger.record import record as record_to_disk
from wheelhop.logger.record_file import HEADER_KEYS, SUMMARY_KEYS


@pytest.fixture(scope="module")
def elf(tmp_path_factory):
    return built("nano", tmp_path_factory.mktemp("nano"))


@pytest.fixture(scope="module", params=["double", "firmware"])
def powered(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    if request.param == "double":
        bench = DoubleBench(folder)
    else:
        bench = BoardBench(folder, request.getfixturevalue("elf"))
    yield bench
    bench.end()


@pytest.fixture
def bench(powered):
    """A logger that is ready, with settings as they are at the start."""
    link = powered.link
    link.stop()
    link.stream(False)
    for setting in ("rate=100", "channels=B1 B2 B3 B4 A1 A2 A3 A4", "name=", "size_mb=1"):
        link.command(f"set {setting}")
    link.receive(0.0)
    return powered


def collect(bench, seconds):
    """The frames of so long: what was sent in it comes before the answer to what is asked then."""
    frames = bench.link.receive(0.0)
    bench.run(seconds)
    bench.link.status()
    return frames + bench.link.receive(0.0)


def record(bench, seconds=1.0):
    """A streamed session: the name of its file, and all its frames."""
    bench.link.stream(True)
    bench.link.receive(0.0)
    name = bench.link.start()
    frames = collect(bench, seconds)
    bench.link.stop()
    bench.link.stream(False)
    return name, frames + collect(bench, 0.2)


def texts(frames, kind):
    return [frame.text for frame in frames if frame.kind == kind]


def answer(bench, line):
    """The text of the refusal of a line, None if it was carried out."""
    try:
        bench.link.command(line, tries=1)
    except Refused as refused:
        return refused.reason
    return None


def test_info_says_what_a_header_says(bench):
    values = bench.link.info()
    assert tuple(values) == HEADER_KEYS
    assert values["channels"] == "B1 B2 B3 B4 A1 A2 A3 A4"
    assert (values["rate_hz"], values["conversions"]) == ("100", "8")


def test_status_says_what_a_summary_says(bench):
    values = bench.link.status()
    assert tuple(values) == ("state", "card", *SUMMARY_KEYS)
    assert (values["state"], values["card"]) == ("ready", "ok")


REFUSALS = {
    "": None,
    "set rate=99": "rate must be 100, 200 or 400",
    "set rate=0100": None,
    "set rate=-100": "rate must be 100, 200 or 400",
    "set rate": "write KEY = VALUE",
    "set  rate = 200 ": None,
    "set channels=A A A A A A A A": "channels: 8 names or -",
    "set channels=- - - - - - - -": "channels: 8 names or -",
    "set channels=A B C D E F G HHHHH": "channels: 8 names or -",
    "set channels=A B C - E_1 F - h": None,
    "set name=123456789012345": None,
    "set name=1234567890123456": "name: at most 15 characters",
    "set start=never": "start: button or power",
    "set stream=maybe": "stream: on or off",
    "set size_mb=0": "size_mb must be 1 to 4095",
    "set size_mb=4096": "size_mb must be 1 to 4095",
    "set colour=red": "unknown key",
    "set device=65534": None,
    "set device=65535": "device must be 0 to 65534",
    "set calibration=2026-11-a": None,
    "set calibration=1234567890123456": "calibration: at most 15 characters",
    "set clock_ppm=-20000": None,
    "set clock_ppm=20001": "clock_ppm must be -20000 to 20000",
    "set clock_ppm=+1": "clock_ppm must be -20000 to 20000",
    "time 4294967295": None,
    "time 4294967296": "time: seconds since 1970",
    "time now": "time: seconds since 1970",
    "START": "unknown command",
    "stream": "unknown command",
    "get HOP65000.HOP 0 1": "no such file",
}


@pytest.mark.parametrize("line", [line for line in REFUSALS if line])
def test_a_line_is_carried_out_or_refused_for_a_reason(bench, line):
    assert answer(bench, line) == REFUSALS[line]


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (b"stop*0000\n", "checksum"),
        (b"stop*\n", "checksum"),
        (b"st\xf6p\n", "line too long or not plain text"),
        (b"x" * 60 + b"\n", "line too long or not plain text"),
        (b"  info\t\r", "unknown command"),
        (b"\t status\n", None),
        (b"# stop*0000\n\n  \nstop\n", None),
    ],
)
def test_lines_as_a_person_or_noise_writes_them(bench, line, reason):
    bench.link.port.write(line)
    reply = bench.link._reply(5.0, 5.0, None)
    assert (reply if isinstance(reply, str) else None) == reason


def test_identity_outlives_a_reset_and_settings_do_not(bench):
    link = bench.link
    for setting in ("device=7", "calibration=cal 7", "clock_ppm=-123", "rate=400"):
        link.command(f"set {setting}")
    link.command("reset")
    while not any(text.startswith("ready") for text in texts(link.receive(5.0), "M")):
        pass
    values = link.info()
    assert [values[key] for key in ("device", "calibration", "clock_ppm")] == ["7", "cal 7", "-123"]
    assert (values["rate_hz"], values["reset"], values["unix_s"]) == ("100", "watchdog", "0")


def test_a_session_on_the_line_is_the_session_in_the_file(bench):
    bench.link.set_time(1_800_000_000)
    name, frames = record(bench, 1.5)
    assert re.fullmatch(r"HOP\d{5}\.HOP", name)
    log = read_log(bench.read(name))
    session, *header = texts(frames, "H")
    assert session == f"session={log.session:08X}" and log.session >> 16 == int(name[3:8])
    assert dict(line.split("=", 1) for line in header) == log.header
    assert dict(line.split("=", 1) for line in texts(frames, "S")) == log.summary
    assert tuple(log.header) == HEADER_KEYS and tuple(log.summary) == SUMMARY_KEYS
    assert 1_800_000_000 <= int(log.header["unix_s"]) <= int(log.summary["unix_s"])
    scans = [scan for frame in frames if frame.kind == "D" and (scan := streamed_scan(frame))]
    sent = {
        scan.number: tuple(unpack_scans(scan.stored, 8)[0].tolist())
        for scan in scans
        if scan.session == log.session
    }
    assert sent == log.scans and sorted(sent) == list(range(len(sent))) and len(sent) >= 75
    assert set(log.scans.values()) == {tuple((8 * CODES).astype(int).tolist())}
    assert (log.summary["due"], log.summary["lost"]) == (str(len(sent)), "0")


def test_acknowledgements_say_what_is_safe(bench):
    name, frames = record(bench, 1.5)
    log = read_log(bench.read(name))
    told = [acknowledgement(frame) for frame in frames if frame.kind == "B"]
    assert len(told) >= 3
    for one in told:
        assert one.session == log.session
        assert one.written == sum(block.count for block in log.blocks[: one.blocks])
        assert (one.lost, one.late, one.card_errors) == (0, 0, 0) and one.due >= one.written
    assert [one.blocks for one in told] == sorted(one.blocks for one in told)


@pytest.mark.parametrize(("rate", "conversions"), [(200, 4), (400, 2)])
def test_rate_and_channels_are_as_set(bench, rate, conversions):
    bench.link.set("rate", rate)
    bench.link.set("channels", "- x - - y - - z")
    name, _ = record(bench)
    log = read_log(bench.read(name))
    assert log.header["channels"] == "- x - - y - - z"
    assert (log.header["rate_hz"], log.header["conversions"]) == (str(rate), str(conversions))
    wanted = tuple((conversions * CODES[[1, 4, 7]]).astype(int).tolist())
    # A busy computer is late, but not so late that half the rate would do.
    assert set(log.scans.values()) == {wanted} and len(log.scans) >= 0.6 * rate


def test_a_session_refuses_what_would_change_it(bench):
    name = bench.link.start()
    for line in ("set rate=200", "set name=x", "set device=1", "list", f"get {name} 0 1"):
        assert answer(bench, line) == "not during a session"
    assert bench.link.status()["state"] == "recording"
    bench.link.set("clock_ppm", 77)
    assert bench.link.command("time 1800000000").text == name
    bench.link.stop()
    log = read_log(bench.read(name))
    assert log.summary["clock_ppm"] == "77" and log.summary["end"] == "command"


def test_start_and_stop_may_be_repeated(bench):
    first, second = bench.link.start(), bench.link.start()
    assert first == second
    bench.link.stop()
    bench.link.stop()
    assert int(bench.link.start()[3:8]) == int(first[3:8]) + 1


def test_the_button_starts_and_stops(bench):
    bench.press_button()
    frames = collect(bench, 0.6)
    assert texts(frames, "H")[0].startswith("session=")
    bench.press_button()
    assert "end=button" in texts(collect(bench, 0.6), "S")


def test_streaming_without_a_session(bench):
    bench.link.stream(True)
    frames = collect(bench, 0.7)
    bench.link.stream(False)
    scans = [streamed_scan(frame) for frame in frames if frame.kind == "D"]
    assert len(scans) >= 50 and {scan.session for scan in scans} == {0}
    assert [scan.number for scan in scans] == list(range(len(scans)))
    collect(bench, 0.1)
    assert texts(collect(bench, 0.3), "D") == []


def test_noise_does_no_harm(bench):
    name = bench.link.start()
    noise = random.Random(3)
    for _ in range(12):
        bench.link.port.write(noise.randbytes(noise.randrange(1, 50)))
        bench.run(0.05)
    bench.link.port.write(b"\n")
    bench.run(0.2)
    bench.link._drop_late_replies()
    assert bench.link.status()["state"] == "recording"
    bench.link.stop()
    log = read_log(bench.read(name))
    assert sorted(log.scans) == list(range(int(log.summary["due"])))


def test_every_line_is_answered_once(bench):
    for line in (b"nonsense\n", pack_command("info"), b"\n", b"stop\r\n"):
        bench.link.port.write(line)
        patience_s = PATIENCE_S if line != b"\n" else 0.0
        while patience_s and bench.link._next(time.monotonic() + patience_s).kind not in "KE":
            pass
        bench.run(0.3)
        while (frame := bench.link._next(0.0)) is not None:
            assert frame.kind not in "KE"


def test_files_are_listed_and_fetched_in_pieces(bench):
    name, _ = record(bench)
    whole = bench.read(name)
    assert bench.link.files()[name] == len(whole)
    pieces, size = bench.link.get(name.lower(), 1, 2)
    assert size == len(whole)
    wanted = [512 + block + at for block in (0, 512) for at in range(0, 512, 44)]
    assert list(pieces) == wanted
    assert {len(piece) for piece in pieces.values()} == {44, 28}
    assert b"".join(pieces.values()) == whole[BLOCK_BYTES : 3 * BLOCK_BYTES]
    rest, _ = bench.link.get(name, 2, 0xFFFF)
    assert b"".join(rest.values()) == whole[2 * BLOCK_BYTES :]
    assert bench.link.get(name, 8_388_607, 1) == ({}, len(whole))


@pytest.mark.parametrize("words", ["", " 0", " 0 0", " x 1", " 0 65536", " 8388608 1", " 0 1 2"])
def test_get_wants_name_block_and_count(bench, words):
    name, _ = record(bench, 0.1)
    assert answer(bench, f"get {name}{words}")


def test_the_real_firmware_is_recorded_and_its_card_downloaded(elf, tmp_path):
    """Through a pseudo-terminal and in real time, as a user would."""
    card = configure(CardImage.fat32(tmp_path / "card.img"), SMALL)
    command = [sys.executable, "-m", "wheelhop.hil_sim", str(elf), "--card", str(card.path)]
    with subprocess.Popen([*command, "--seconds", "60"], stdout=subprocess.PIPE) as board:
        url = board.stdout.readline().decode().split()[-1]
        (one,) = record_to_disk(RecordOptions(tmp_path, url, start=True, seconds=2.0)).files
        downloader = Downloader(connect(url))
        (tmp_path / "card").mkdir()
        # The host's file may have more blocks: it begins a new one where the line lost something.
        size = downloader.link.files()[one.path.name]
        file = downloader.download(one.path.name, size, tmp_path / "card")
        downloader.close()
        board.kill()
    mine, told = read_log(one.path.read_bytes()), read_log(file.path.read_bytes())
    assert one.card == (int(told.summary["due"]), len(told.scans), 0) and mine.bad == told.bad == []
    assert mine.scans.items() <= told.scans.items() and len(mine.scans) + one.lost == one.card[0]


def test_a_session_that_a_reset_has_ended_is_closed_and_gone_on_with(bench):
    link = bench.link
    link.stream(True)
    name = link.start()
    bench.run(1.5)
    link.command("reset")
    before = f"{read_log(bench.read(name)).session:08X}"
    assert link.info()["continues"] == before
    bench.run(0.5)
    after = link.start()  # runs already
    assert link.status()["state"] == "recording" and after != name
    link.stop()
    assert name in link.files() and not link.info().get("continues")
    log, next_log = (read_log(bench.read(n)) for n in (name, after))
    assert next_log.header["continues"] == before
    assert (log.summary["end"], log.summary["lost"]) == ("recovered", "0")
    assert int(log.summary["written"]) == len(log.scans) == int(log.summary["due"]) >= 111
