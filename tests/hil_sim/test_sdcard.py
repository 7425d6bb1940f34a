"""The card answers as the specification says, and its faults happen where they are configured."""

import binascii
import random

import pytest

from tests.hil_sim.probe import FAST, CardHost
from wheelhop.hil_sim import CardImage, Faults, PowerCut

ACCEPTED, CRC_ERROR, WRITE_ERROR = 0x05, 0x0B, 0x0D
NOISE = random.Random(4).randbytes


@pytest.fixture
def socket(probe, tmp_path):
    """Make a board with a blank card that is ready: (host, card)."""

    def make(kind="sdhc", size_mib=4, **faults):
        blank = CardImage.unformatted(tmp_path / "card.img", size_mib)
        card = CardImage(blank.path, kind)
        host = CardHost(probe(card=card, faults=Faults(**faults), journal=True))
        host.start_up()
        return host, card

    return make


def test_start_up_identifies_a_high_capacity_card(probe, tmp_path):
    card = CardImage.unformatted(tmp_path / "card.img", 4)
    one = probe(card=card, faults=Faults(start_up=0.05))
    host = CardHost(one)
    one.select(False)
    one.exchange(b"\xff" * 10)
    assert host.command(0) == b"\x01"
    assert host.command(8, 0x1AA, 5) == b"\x01\x00\x00\x01\xaa"
    assert host.command(58, 0, 5)[1] & 0x80 == 0  # not powered up yet
    assert host.command(17) == b"\x05"  # illegal while idle
    begin = one.board.time
    while host.app_command(41, 0x40000000):
        assert one.board.time - begin < 0.1
    assert one.board.time - begin >= 0.05
    assert host.command(58, 0, 5) == b"\x00\xc0\xff\x80\x00"
    assert one.board.counters().card_violations == 0


def test_a_high_capacity_card_waits_for_a_host_that_knows_of_it(probe, tmp_path):
    one = probe(card=CardImage.unformatted(tmp_path / "card.img", 4))
    host = CardHost(one)
    one.exchange(b"\xff" * 10)
    host.command(0)
    host.command(8, 0x1AA, 5)
    for _ in range(50):
        assert host.app_command(41, 0) == 1


@pytest.mark.parametrize(("kind", "ocr", "unit"), [("sdsc", 0x80, 512), ("sdhc", 0xC0, 1)])
def test_blocks_are_addressed_in_the_units_of_the_kind(socket, kind, ocr, unit):
    host, card = socket(kind)
    assert host.command(58, 0, 5)[1] == ocr
    data = NOISE(512)
    assert host.write(7 * unit, data) == ACCEPTED
    assert card.read_block(7) == data
    assert host.read(7 * unit)[:512] == data


def test_a_card_of_version_1_does_not_know_command_8(probe, tmp_path):
    blank = CardImage.unformatted(tmp_path / "card.img", 4)
    one = probe(card=CardImage(blank.path, "sd-v1"))
    host = CardHost(one)
    one.exchange(b"\xff" * 10)
    host.command(0)
    assert host.command(8, 0x1AA) == b"\x05"


def test_commands_and_data_carry_check_sums(socket):
    host, card = socket()
    card.write_block(3, NOISE(512))
    answer = host.read(3)
    assert int.from_bytes(answer[512:]) == binascii.crc_hqx(answer[:512], 0)
    assert host.command(59, 1) == b"\x00"
    data = NOISE(512)
    host.command(24, 5)
    assert host.send_block(data, crc=b"\0\0") == CRC_ERROR
    assert card.read_block(5) == bytes(512)
    host.command(24, 5)
    assert host.send_block(data, crc=binascii.crc_hqx(data, 0).to_bytes(2)) == ACCEPTED
    host.await_ready()
    host.probe.select(True)
    assert b"\x08" in host.probe.exchange(
        b"\x4d\0\0\0\0\x55" + b"\xff" * 4
    )  # CRC of CMD13 is wrong
    assert host.probe.board.counters().card_violations == 1


def test_many_blocks_in_one_write_and_one_read(socket):
    host, card = socket()
    blocks = [NOISE(512) for _ in range(4)]
    assert host.app_command(23, 4) == 0
    host.command(25, 100)
    for block in blocks:
        assert host.send_block(block, token=0xFC) == ACCEPTED
        host.await_ready()
    host.probe.exchange(b"\xfd\xff")
    host.await_ready()
    assert [card.read_block(100 + i) for i in range(4)] == blocks
    host.begin_read(18, 100)
    assert [host.data()[:512] for _ in range(3)] == blocks[:3]
    assert host.command(12)[0] == 0
    assert host.command(13, 0, 2) == b"\x00\x00"


def test_registers_tell_the_capacity(socket):
    for kind in ("sdhc", "sdsc"):
        host, _ = socket(kind, size_mib=16)
        host.begin_read(9, 0)
        csd = int.from_bytes(host.data(16)[:16])

        def field(high, low, csd=csd):
            return csd >> low & ((1 << (high - low + 1)) - 1)

        if kind == "sdhc":
            size = (field(69, 48) + 1) * 512 * 1024
        else:
            size = (field(73, 62) + 1) << (field(49, 47) + 2 + field(83, 80))
        assert size == 16 << 20


def test_a_block_beyond_the_end_is_refused(socket):
    host, _ = socket(size_mib=1)
    assert host.command(17, 2048) == b"\x40"
    assert host.command(13, 0, 2) == b"\x00\x80"
    assert host.command(13, 0, 2) == b"\x00\x00"  # reading it clears it


def test_the_host_is_watched(socket):
    host, _ = socket(write_busy=0.02)
    counters = host.probe.board.counters
    host.command(24, 5)
    host.send_block(bytes(512))
    assert host.probe.exchange(b"\x51\0\0\0\0\xff" + b"\xff" * 8) == bytes(14)  # busy, and deaf
    assert counters().card_violations == 1
    assert host.probe.board.last_violation() == "command while the card is busy"
    host.await_ready()
    host.command(0)
    host.probe.clock(FAST)
    host.command(8, 0x1AA, 5)
    assert host.probe.board.last_violation() == "clock above 400 kHz before the card is ready"


def test_an_empty_socket_answers_nothing(probe):
    one = probe()
    one.select(True)
    assert one.exchange(b"\x40\0\0\0\0\x95" + b"\xff" * 10) == b"\xff" * 16


def test_a_stall_lasts_as_long_as_configured_at_its_block_alone(socket):
    host, _ = socket(stalls={2: 0.25}, write_busy=0.002)
    took = []
    for i in range(4):
        host.command(24, i)
        host.send_block(NOISE(512))
        host.await_ready()
        took.append(host.probe.board.time - host.probe.board.journal()[0].time_s)
    assert took[2] == pytest.approx(0.252, abs=1e-3)
    assert max(took[:2] + took[3:]) < 0.03  # the answer over the serial line included


def test_refused_writes_store_nothing(socket):
    host, card = socket(rejects={1: "write", 2: "crc"})
    responses = [host.write(10 + i, b"\xaa" * 512) for i in range(4)]
    assert responses == [ACCEPTED, WRITE_ERROR, CRC_ERROR, ACCEPTED]
    stored = [card.read_block(10 + i) == b"\xaa" * 512 for i in range(4)]
    assert stored == [True, False, False, True]


def test_a_protected_card_says_so(socket):
    host, card = socket(write_protected=True)
    assert host.write(3, b"\xaa" * 512) == WRITE_ERROR
    assert host.command(13, 0, 2) == b"\x00\x20"
    assert card.read_block(3) == bytes(512)
    host.begin_read(9, 0)
    assert host.data(16)[14] & 0x10


def test_one_bit_is_stored_inverted(socket):
    host, card = socket(flips={1: 4095 - 8})
    for i in range(3):
        host.write(i, bytes(512))
    assert [card.read_block(i) for i in range(3)] == [
        bytes(512),
        bytes(510) + b"\x80\0",
        bytes(512),
    ]


@pytest.mark.parametrize("stored", [0, 1, 17, 511, 512])
@pytest.mark.parametrize("tail", ["old", "ones", "noise"])
def test_power_fails_inside_a_write(socket, stored, tail):
    host, card = socket(power_cut=PowerCut(2, stored, tail))
    card.write_block(6, b"\x11" * 512)
    host.write(4, b"\xaa" * 512)
    host.write(5, b"\xaa" * 512)
    board = host.probe.board
    host.command(24, 6)
    board.serial.write(b"x" + (516).to_bytes(2, "little") + b"\xff\xfe" + b"\xbb" * 512 + b"\0\0")
    board.serial.read()
    board.run(0.1)
    assert board.state == "off" and board.serial.read() == b""
    assert card.read_block(5) == b"\xaa" * 512
    block = card.read_block(6)
    assert block[:stored] == b"\xbb" * stored
    rest = block[stored:]
    if tail == "noise":
        assert len(rest) < 2 or rest not in (b"\x11" * len(rest), b"\xff" * len(rest))
    else:
        assert rest == {"old": b"\x11", "ones": b"\xff"}[tail] * len(rest)
    assert [entry.block for entry in board.journal()] == [4, 5, 6]


def test_a_pulled_card_is_silent_and_comes_back_idle(socket):
    host, card = socket(pulled_at=0.5)
    assert host.write(4, b"\xaa" * 512) == ACCEPTED
    board = host.probe.board
    board.run(0.5 - board.time)
    host.probe.select(True)
    assert host.probe.exchange(b"\x51\0\0\0\4\xff" + b"\xff" * 8) == b"\xff" * 14
    board.faults = Faults()
    board.insert(card)
    assert host.command(17) == b"\x05"
    host.start_up()
    assert host.read(4)[:512] == b"\xaa" * 512


def test_the_journal_tells_every_write_in_order(socket):
    host, card = socket(flips={1: 0})
    blank = card.read_block(9)
    for block in (9, 3, 9):
        host.write(block, bytes([block]) * 512)
    journal = host.probe.board.journal()
    assert [entry.block for entry in journal] == [9, 3, 9]
    assert journal[1].data == b"\x02" + b"\x03" * 511  # as stored, not as sent
    assert [entry.time_s for entry in journal] == sorted(entry.time_s for entry in journal)
    assert blank == bytes(512) and host.probe.board.journal() == []
