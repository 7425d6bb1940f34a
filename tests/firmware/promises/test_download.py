"""`list` and `get`: the host gets from the line, byte for byte, what lies on the card."""

import random
import subprocess

import pytest

from tests.firmware.promises.logger import configure
from wheelhop.hil_sim import CardImage, sines

PIECES = (*[44] * 11, 28)  # of a block
BYTES = random.Random(3).randbytes(7 * 512 + 100)
TEXT = b"A file for one block after the other.\n" * 40


def get(one, name, first=0, count=65535):
    """The reply to `get`, and the file's bytes from the first frame on, which must be gapless."""
    begin = len(one.frames)
    reply = one.command(f"get {name} {first} {count}", timeout=60.0)
    data = bytearray()
    for frame in one.frames[begin:]:
        if frame.kind == "F":
            offset, piece = int.from_bytes(frame.payload[:4], "little"), frame.payload[4:]
            assert offset == 512 * first + len(data)
            assert 1 <= len(piece) <= PIECES[offset % 512 // 44] and offset % 512 % 44 == 0
            data += piece
    return reply, bytes(data)


def recorded(logger, card, seconds=2.0):
    """A logger with one session on its card."""
    one = logger(card, signals=sines([1, 2, 3, 4, 5, 6, 7, 8], seconds=30.0, rate_hz=1000.0))
    assert one.command("start").ok
    one.run(seconds)
    assert one.command("stop").ok
    return one


def test_a_session_comes_over_the_line_as_it_lies_on_the_card(logger, card):
    one = recorded(logger, card)
    data = card.read("HOP00001.HOP")
    assert one.command("list").lines == [f"HOP00001.HOP {len(data)}"]
    reply, got = get(one, "HOP00001.HOP")
    assert reply.ok and int(reply.text) == len(data)
    assert got == data
    assert one.broken == [] and one.board.counters().resets == 0
    assert one.command("start").text == "HOP00002.HOP"  # and the next session is no worse for it
    one.run(1.0)
    assert one.command("stop").ok
    assert len(one.log().scans) >= 99 and one.log().summary["lost"] == "0"
    assert card.read("HOP00001.HOP") == data and card.check() == ""


@pytest.mark.parametrize("seed", range(2))
def test_any_part_of_a_file_can_be_asked_for(logger, card, seed):
    card.write("HOP00007.HOP", BYTES)
    one = logger(card)
    rng = random.Random(seed)
    parts = [(rng.randrange(9), rng.randrange(1, 9)) for _ in range(6)]
    for first, count in [*parts, (7, 1), (8, 1), (8388607, 65535)]:
        reply, got = get(one, "HOP00007.HOP", first, count)
        assert reply.ok and int(reply.text) == len(BYTES)
        assert got == BYTES[512 * first : 512 * (first + count)]


def test_a_directory_of_many_files_is_listed_whole_and_without_what_is_no_log(logger, card):
    names = [f"HOP{number:05}.HOP" for number in (0, 1, 12, 65535, *range(100, 120))]
    for name in names:
        card.write(name, TEXT[: len(names) * 10])
    card.write(names[1], b"")
    for other in ("HOP1.HOP", "HOP00001.TXT", "HOPE0001.HOP", "XOP00001.HOP", "PHOTO.JPG"):
        card.write(other, b"x")
    subprocess.run(["mmd", "-i", str(card.path), "::HOP00777.HOP"], check=True)
    expected = [f"{name} {card.files()[name]}" for name in names]
    assert sorted(logger(card).command("list").lines) == sorted(expected)


def test_a_card_without_sessions_has_an_empty_list(logger, card):
    reply = logger(card).command("list")
    assert reply.ok and reply.lines == [] and reply.text == ""


@pytest.mark.parametrize("kind", ["fat16", "in pieces"])
def test_files_in_pieces_and_on_other_file_systems_are_followed(logger, tmp_path, kind):
    path = tmp_path / "card.img"
    if kind == "fat16":
        card = CardImage.fat16(path, partitioned=True)
    else:
        card = CardImage.fat32(path)
        card.fragment(1)
    card.write("HOP00003.HOP", BYTES)
    one = logger(card)
    assert get(one, "HOP00003.HOP")[1] == BYTES
    assert get(one, "HOP00003.HOP", 3, 2)[1] == BYTES[1536:2560]


@pytest.mark.parametrize(
    "words",
    [
        *("", "HOP00001.HOP", "HOP00001.HOP 0", "HOP00001.HOP 0 0", "HOP00001.HOP 0 65536"),
        *("HOP00001.HOP 8388608 1", "HOP00001.HOP -1 1", "HOP00001.HOP x 1", "HOP00001.HOP 0 1 1"),
        *("HOP00001.HOP  0 1", "HOP00002.HOP 0 1", "NONE/HOP00001.HOP 0 1", "???????????? 0 1"),
    ],
)
def test_what_cannot_be_had_is_refused(logger, card, words):
    card.write("HOP00001.HOP", TEXT)
    one = logger(card)
    reply, got = get_line(one, f"get {words}")
    assert not reply.ok and reply.text and got == []
    assert one.command("list").ok  # it is no trouble of the card's


def get_line(one, line):
    begin = len(one.frames)
    reply = one.command(line)
    return reply, [frame for frame in one.frames[begin:] if frame.kind in "FL"]


def test_both_are_refused_during_a_session(logger, card):
    one = logger(card)
    assert one.command("start").ok
    for line in ("list", "get HOP00001.HOP 0 1"):
        reply, frames = get_line(one, line)
        assert (reply.ok, reply.text, frames) == (False, "not during a session", [])
    one.run(1.0)
    assert one.command("stop").ok
    assert one.log().summary["lost"] == "0"


@pytest.mark.parametrize(
    ("make", "text"), [(lambda _: None, "no card"), (CardImage.unformatted, "no FAT file system")]
)
def test_trouble_with_the_card_is_told(logger, tmp_path, make, text):
    one = logger(make(tmp_path / "card.img"))
    for line in ("list", "get HOP00001.HOP 0 1"):
        reply, frames = get_line(one, line)
        assert not reply.ok and reply.text.startswith(text) and frames == []


def test_a_card_that_is_pulled_on_the_way_is_told_and_can_come_back(logger, card):
    data = random.Random(5).randbytes(200 * 512)
    card.write("HOP00001.HOP", data)
    one = logger(card)
    one.board.serial.write(b"get HOP00001.HOP 0 200\n")
    one.run(1.0)
    one.board.insert(None)
    begin = len(one.frames)
    one.until(lambda: any(frame.kind == "E" for frame in one.frames[begin:]))
    pieces = [frame.payload[4:] for frame in one.frames if frame.kind == "F"]
    assert one.texts("E")[-1].startswith("no card")
    assert len(pieces) > 200 and data.startswith(b"".join(pieces))
    one.board.insert(card)
    one.run(0.3)
    assert get(one, "HOP00001.HOP", 150, 2)[1] == data[150 * 512 : 152 * 512]
    assert one.board.counters().resets == 0


def test_noise_on_the_line_does_not_disturb_it(logger, card):
    data = random.Random(6).randbytes(150 * 512)
    card.write("HOP00001.HOP", data)
    one = logger(card)
    one.board.serial.write(b"get HOP00001.HOP 0 150\n" + random.Random(7).randbytes(20_000))
    one.until(lambda: any(frame.kind == "K" for frame in one.frames))
    one.run(0.5)
    assert b"".join(frame.payload[4:] for frame in one.frames if frame.kind == "F") == data
    one.board.serial.write(b"\n")  # as SPEC.md says: what came too early ends here
    one.run(0.1)
    assert one.command("list").lines == [f"HOP00001.HOP {len(data)}"]
    assert one.board.counters().resets == 0


def test_a_long_file_neither_trips_the_watchdog_nor_stops_a_stream_that_is_on(logger, card):
    data = bytes(150 * 512)  # zeros are the worst for the frames' stuffing
    card.write("HOP00001.HOP", data)
    one = logger(card)
    assert one.command("stream on").ok
    started, begin = one.board.time, len(one.frames)
    assert get(one, "HOP00001.HOP")[1] == data
    assert one.board.time - started > 2.5 and one.board.counters().resets == 0
    scans = [frame for frame in one.frames[begin:] if frame.kind == "D"]
    assert len(scans) > 90 * (one.board.time - started)


def test_a_session_that_a_reset_has_ended_is_closed_before_it_is_listed(logger, card):
    configure(card, "size_mb = 1\n")
    one = logger(card)
    assert one.command("start").ok
    one.run(2.5)
    one.board.insert(None)
    one.board.cut_power()
    one.board.power_on()
    one.boot()
    one.board.insert(card)
    one.run(0.3)
    (line,) = one.command("list").lines
    assert line == f"HOP00001.HOP {card.files()['HOP00001.HOP']}"
    assert get(one, "HOP00001.HOP")[1] == card.read("HOP00001.HOP")
    assert one.log().summary["end"] == "recovered"
