"""The serial line: noise, nonsense and floods are answered or ignored, and never do harm."""

import random

import numpy as np
import pytest

from tests.firmware.promises.reader import checked
from tests.firmware.promises.test_stalls import check_totals
from wheelhop.hil_sim import Faults, sines


def ends(frames):
    return [frame for frame in frames if frame.kind in "KE"]


def send_line(one, line, wait_s=0.3):
    """Raw bytes and what is answered within a while."""
    begin = len(one.frames)
    one.board.serial.write(line)
    one.run(wait_s)
    return ends(one.frames[begin:])


NONSENSE = [
    b"\xff\xfe\x80stop\n",
    b"start\x00\n",
    b"set\n",
    b"set =\n",
    b"set rate\n",
    b"set rate=\n",
    b"set rate=99999999999999999999\n",
    b"set rate=-100\n",
    b"set name=" + b"x" * 16 + b"\n",
    b"set channels=A A A A A A A A\n",
    b"set channels=- - - - - - - -\n",
    b"set channels=A1 A2\n",
    b"set device=70000\n",
    b"set clock_ppm=99999\n",
    b"set clock_ppm=x\n",
    b"time\n",
    b"time -1\n",
    b"time 99999999999\n",
    b"x" * 63 + b"\n",
    b"x" * 64 + b"\n",
    b"x" * 1000 + b"\n",
    b"START\n",
    b"stop*0000\n",
    b"stop*\n",
    b"*\n",
    b"stream maybe\n",
    b"%s%n%x\n",
]


@pytest.mark.parametrize("line", NONSENSE, ids=lambda line: repr(line[:24]))
def test_nonsense_is_refused_once_with_a_reason(logger, card, line):
    one = logger(card)
    before = one.command("info").lines
    (answer,) = send_line(one, line)
    assert answer.kind == "E" and answer.payload
    assert one.command("info").lines == before
    assert one.board.counters().resets == 0


def test_random_lines_get_one_answer_each(logger, card):
    one = logger(card)
    rng = random.Random(7)
    words = [
        b"set ",
        b"rate=",
        b"channels=",
        b"time ",
        b"status",
        b"info",
        b"stream on",
        b"*",
        b" ",
    ]
    for _ in range(60):
        pieces = [
            rng.choice([rng.choice(words), rng.randbytes(rng.randrange(6))]) for _ in range(4)
        ]
        line = b"".join(pieces).translate(None, b"\n\r")
        if not line.strip(b" \t") or line.strip(b" \t").startswith(b"#"):
            continue
        answers = send_line(one, line + b"\n", 0.1)
        assert len(answers) == 1, line
    assert one.board.counters().resets == 0
    assert one.command("start").ok and one.command("stop").ok


def test_a_command_with_a_flipped_bit_is_not_carried_out(logger, card):
    one = logger(card)
    assert one.command("info").ok  # it has met its card
    command = checked("start")[:-1]
    for bit in range(8 * len(command)):
        damaged = bytearray(command)
        damaged[bit // 8] ^= 1 << bit % 8
        if bytes(damaged).isascii() and b"*" not in damaged:
            continue  # it has lost its check sum: what a person might have typed
        if damaged[:6] == command[:6] and damaged.upper() == command.upper():
            continue  # the same hexadecimal number
        answers = send_line(one, bytes(damaged) + b"\n", 0.03)
        assert answers and all(answer.kind == "E" for answer in answers)
    assert one.command("status").values["state"] == "ready"
    assert one.texts("H") == []


def test_noise_on_the_line_does_not_touch_a_session(logger, card):
    one = logger(card, signals=sines(3.0, seconds=20.0))
    assert one.command("start").ok
    rng = random.Random(8)
    for _ in range(40):
        one.board.serial.write(rng.randbytes(rng.randrange(1, 60)))
        one.run(0.1)
    one.board.serial.write(b"\n")
    one.run(0.5)
    reply = one.command("stop")
    log = one.log()
    assert check_totals(one, log, reply)[2] == 0
    assert log.summary["late"] == "0" and log.summary["unsent"] == "0"


def test_a_flood_at_full_rate_costs_nothing_that_is_not_counted(logger, card):
    """50000 bytes a second of noise, more than the processor can take."""
    one = logger(card, signals=sines(3.0, seconds=20.0))
    assert one.command("start").ok
    missed = one.board.counters().missed
    one.board.serial.write(random.Random(9).randbytes(100_000))
    one.run(3.0)
    one.board.serial.write(b"\n")
    one.run(0.5)
    reply = one.command("stop")
    log = one.log()
    check_totals(one, log, reply)
    assert int(log.summary["late"]) == one.board.counters().missed - missed
    assert one.board.counters().resets == 0


def test_the_line_carries_all_that_the_file_has(logger, card):
    one = logger(card, signals=sines(3.0, seconds=20.0))
    assert one.command("start").ok
    one.run(2.0)
    assert one.command("stop").ok
    log = one.log()
    session, *header = one.texts("H")
    assert session == f"session={log.session:08X}"
    assert dict(text.split("=", 1) for text in header) == log.header
    assert one.summary() == log.summary
    streamed = {n: sums for (number, n), sums in one.streamed().items() if number == log.session}
    assert streamed == log.scans
    last = one.acknowledgements()[-1]
    assert (last.session, last.lost) == (log.session, 0)
    assert last.blocks <= len(log.blocks) - 1


@pytest.mark.parametrize(("order", "kind"), [("start", "H"), ("stop", "S")])
def test_line_and_file_tell_the_same_second(logger, card, order, kind):
    """Even if the clock moves on between what the card is told and what the line is."""
    one = logger(card)
    other = "stop" if order == "start" else "start"

    def told(at_s):
        """A session with its order given at this moment: what line and file say, and when the line
        began to."""
        if other == "start":
            one.command("start")
        one.board.run(at_s - one.board.time)
        begin = len(one.frames)
        one.command(order)
        if other == "stop":
            one.command("stop")
        frames = [f for f in one.frames[begin:] if f.kind == kind]
        line = next(f for f in frames if f.text.startswith("unix_s="))
        log = one.log()
        kept = log.header if order == "start" else log.summary
        return line.text.removeprefix("unix_s="), kept["unix_s"], frames[0].time_s, line.time_s

    one.command("time 1800000000")
    _, _, first_s, last_s = told(at_s := one.board.time + 1.0)
    into = 0.5 * (first_s + last_s) - at_s  # between the file and the line, within milliseconds
    changed = False
    for late_s in np.arange(-8e-3, 9e-3, 2e-3):
        line, file, first_s, last_s = told(int(one.board.time) + 2.0 + late_s - into)
        changed |= int(first_s) < int(last_s)
        assert line == file
    assert changed, "no session met a second's end"


def test_commands_may_be_repeated_without_harm(logger, card):
    one = logger(card)
    assert one.command("stop").ok
    first, second = one.command("start"), one.command("start")
    assert first.ok and second.ok and first.text == second.text == "HOP00001.HOP"
    one.run(0.5)
    assert one.command("stop").ok and one.command("stop").ok
    assert [name for name in card.files() if name.endswith(".HOP")] == ["HOP00001.HOP"]


def test_what_takes_long_is_heard_at_once_and_done_once(logger, card):
    one = logger(card)
    one.board.faults = Faults(stalls={write: 0.05 for write in range(400)})
    for order, kinds in (("start", "H"), ("stop", "S")):
        begin, given_s = len(one.frames), one.board.time
        one.board.serial.write(checked(order))
        for _ in range(4):  # a program that did not hear that it was heard
            one.run(0.1)
            one.board.serial.write(checked(order))
        one.until(lambda begin=begin: ends(one.frames[begin:]))
        one.run(0.2)
        new = one.frames[begin:]
        assert (new[0].kind, new[0].text) == ("L", "wait") and new[0].time_s - given_s < 0.1
        assert ends(new)[0].time_s - given_s > 0.3 and all(f.kind == "K" for f in ends(new))
        told = [f.text for f in new if f.kind in kinds]
        assert len(told) == len({text.split("=")[0] for text in told})  # once
    assert [name for name in card.files() if name.endswith(".HOP")] == ["HOP00001.HOP"]


def test_streaming_without_a_session_has_session_number_0(logger, card):
    one = logger(card)
    assert one.command("stream on").ok
    one.run(1.0)
    assert one.command("stream off").ok
    numbers = [n for session, n in one.streamed() if session == 0]
    assert len(numbers) >= 95 and numbers[-50:] == list(range(numbers[-50], numbers[-1] + 1))
    begin = len(one.frames)
    one.run(0.5)
    assert all(frame.kind != "D" for frame in one.frames[begin:])
