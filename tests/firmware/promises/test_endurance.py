"""Long sessions: counters that wrap, files that fill, and, if asked for, a whole day."""

import binascii
import os

import pytest

from tests.firmware.promises.logger import configure
from tests.firmware.promises.reader import parse_block
from tests.firmware.promises.test_stalls import check_totals
from wheelhop.hil_sim import CardImage, Faults, from_array

HOURS = float(os.environ.get("WHEELHOP_HOURS", "0"))
MILLISECONDS = "_ZN12_GLOBAL__N_16now_msE"  # see avr.cpp
MILLISECONDS_WRAP_S = 2**32 / 1000  # 49.7 days
CONVERSION_S = 2500 / 16e6  # between triggers
SAMPLER, DUE, LATE = "_ZN5board7samplerE", 32, 42  # offsets of its counters, see sampler.h


def sawtooth():
    """Each channel another phase of a slow sawtooth, for ever."""
    return from_array(
        [[50 + 100 * ((k + i) % 8) for k in range(8)] for i in range(8)], 0.25, repeat=True
    )


def test_the_millisecond_counter_wraps_during_a_session(logger, card):
    """With a stall right across the wrap."""
    one = logger(card)
    assert one.command("start").ok
    one.board.set_memory(MILLISECONDS, (2**32 - 2000).to_bytes(4, "little"))
    first = one.board.counters().card_writes
    one.board.faults = Faults(stalls={first + 4: 0.6})
    one.run(5.0)
    assert int.from_bytes(one.board.memory(MILLISECONDS), "little") < 10_000
    reply = one.command("stop")
    assert check_totals(one, one.log(), reply)[2] == 0
    assert abs(int(one.summary()["stall_ms"]) - 600) <= 3
    assert one.command("start").ok and one.command("stop").ok


def set_counter(one, offset, value, size):
    """Let the sampler have counted up to a value."""
    memory = bytearray(one.board.memory(SAMPLER))
    memory[offset : offset + size] = value.to_bytes(size, "little")
    one.board.set_memory(SAMPLER, bytes(memory))


def test_after_scan_4294967295_comes_scan_0(logger, card):
    one = logger(card)
    assert one.command("stream on").ok
    set_counter(one, DUE, 2**32 - 50, 4)
    begin = len(one.streamed())
    one.run(1.0)
    numbers = [number for _, number in one.streamed()][begin + 1 :]
    assert numbers == [(numbers[0] + k) % 2**32 for k in range(len(numbers))]
    assert max(numbers) == 2**32 - 1 and 40 < numbers[-1] < 60


def test_a_session_that_has_lost_more_than_there_are_numbers_keeps_its_totals(logger, card):
    """As if its card had been away for a year and a half."""
    one = logger(card)
    assert one.command("start").ok
    one.run(1.0)
    set_counter(one, DUE, 2**32 - 100, 4)
    one.run(3.0)
    assert one.command("stop").ok
    due, written, lost = (int(one.summary()[key]) for key in ("due", "written", "lost"))
    assert due == (written + lost) % 2**32 and lost > 2**32 - 500 and 150 < due < 250
    data = card.read("HOP00001.HOP")
    blocks = [parse_block(data[512 * k :][:512], k) for k in range(len(data) // 512)]
    seen = 0
    for block in blocks[1:]:
        assert block.first_scan == (seen + block.lost) % 2**32
        seen += block.count
    assert seen == written and blocks[-1].kind == b"S"


def test_scans_skipped_while_the_card_is_busy_leave_every_other_at_its_number(logger, card):
    """One block waits and one is half full: what follows the gap has no place in either."""
    one = logger(card, signals=sawtooth())
    assert one.command("start").ok
    first = one.board.counters().card_writes
    one.board.faults = Faults(stalls={first + 2: 0.7})
    one.until(lambda: one.board.counters().card_writes == first + 3)
    one.run(0.5)
    due = int(one.command("status").values["due"])
    set_counter(one, DUE, due + 5, 4)
    one.run(2.0)
    reply = one.command("stop")
    log = one.log()
    assert 4 <= check_totals(one, log, reply)[2] < 40
    streamed = {number: sums for (_, number), sums in one.streamed().items()}
    assert [n for n, sums in log.scans.items() if streamed.get(n) != sums] == []


def test_the_count_of_late_triggers_stays_at_its_end(logger, card):
    one = logger(card)
    assert one.command("start").ok
    one.run(0.5)
    set_counter(one, LATE, 65533, 2)
    missed = one.board.counters().missed
    for k in range(20):  # at every phase of a conversion, of which some cannot be late
        one.run(0.05 + k / 20 * CONVERSION_S)
        one.board.hold_cpu(2200)
    one.run(0.5)
    assert one.board.counters().missed > missed + 2
    assert one.command("stop").ok
    late = [block.late for block in one.log().blocks]
    assert late == sorted(late) and late[0] == 0 and late[-1] == 65535
    assert one.summary()["late"] == "65535" and one.summary()["lost"] == "0"


def eeprom_after_session(number):
    """As the firmware's identity.cpp keeps it: number and check sum, in one of two places."""
    word = number.to_bytes(2, "little")
    slot = word + binascii.crc_hqx(word, 0).to_bytes(2, "little")
    at = 4 * (number & 1)
    return (b"\xff" * at + slot).ljust(1024, b"\xff")


def test_after_session_65535_comes_session_1(logger, card):
    one = logger(card, eeprom=eeprom_after_session(65534))
    for name in ("HOP65535.HOP", "HOP00001.HOP", "HOP00002.HOP"):
        assert one.command("start").text == name
        one.run(0.3)
        assert one.command("stop").ok
        assert one.log(name).session >> 16 == int(name[3:8])
    one.board.cut_power()
    one.board.power_on()
    one.run(1.0)
    assert one.command("start").text == "HOP00003.HOP"


def test_a_file_that_is_full_rolls_over_to_the_next(logger, tmp_path):
    """1 MiB at 400 scans a second: more than 65536 scans, so 16-bit counters wrap, too."""
    card = CardImage.fat32(tmp_path / "card.img")
    one = logger(configure(card, "size_mb = 1\nrate = 400\n"), signals=sawtooth())
    assert one.command("start").ok
    one.until(lambda: "unix_s" in one.summary(), timeout=200.0, step=1.0)
    one.run(0.5)
    log = one.log("HOP00001.HOP")
    assert log.summary["end"] == "full"
    assert len(log.blocks) <= 2048
    scans = len(log.scans)
    assert scans > 65536 and int(log.summary["due"]) == scans + int(log.summary["lost"])
    assert int(log.summary["lost"]) <= int(log.summary["room"])
    assert list(log.scans) == list(range(scans))
    assert one.command("status").values["state"] == "recording"
    one.run(1.0)
    assert one.command("stop").ok and card.check() == ""
    assert one.log().header["continues"] == f"{log.session:08X}" and len(one.log().scans) > 390


@pytest.mark.skipif(
    HOURS == 0, reason="set WHEELHOP_HOURS=24 for a session of a day (an hour or two)"
)
def test_a_day(logger, tmp_path, capsys):
    """A stall of 250 to 600 ms every few minutes, as cards have them; nothing is lost."""
    card = CardImage.fat32(tmp_path / "card.img", 2048)
    one = logger(configure(card, "size_mb = 256\n"), signals=sawtooth())
    assert one.command("start").ok
    first = one.board.counters().card_writes
    stalls = {first + 500 * k: 0.25 + 0.35 * (k % 2) for k in range(1, int(HOURS * 20) + 1)}
    one.board.faults = Faults(stalls=stalls)
    for _ in range(round(HOURS * 360)):
        one.run(10.0)
        one.raw.clear()
        del one.frames[:-10]
    reply = one.command("stop")
    log = one.log()
    due, written, lost = check_totals(one, log, reply)
    with capsys.disabled():
        print(
            f"\nfirmware: {HOURS:g} h, {due} scans due, {written} written, {lost} lost, summary "
            f"{log.summary}"
        )
    assert lost == 0 and due >= HOURS * 360_000 - 1
    assert log.summary["late"] == "0"
    assert MILLISECONDS_WRAP_S > 3600 * HOURS
