"""Promise 5: a corrupted byte costs at most one block or one frame, and is never taken for data."""

import itertools
import random

import pytest

from tests.firmware.promises.reader import parse_frame, read_log
from wheelhop.hil_sim import Faults, ramp

SCANS_PER_BLOCK = 37


@pytest.fixture(scope="module")
def recording(elf, tmp_path_factory):
    """File and line of one session: bytes of both."""
    from tests.firmware.promises.logger import Logger, configure
    from wheelhop.hil_sim import CardImage

    card = CardImage.fat32(tmp_path_factory.mktemp("damage") / "card.img")
    with Logger(elf, configure(card, "size_mb = 1\nstream = on\n"), signals=ramp(0, 90)) as one:
        one.boot()
        assert one.command("start").ok
        one.run(5.0)
        assert one.command("stop").ok
        return card.read("HOP00001.HOP"), bytes(one.raw)


def test_a_corrupt_byte_in_the_file_costs_one_block(recording):
    data, _ = recording
    truth = read_log(data)
    rng = random.Random(5)
    for _ in range(150):
        at = rng.randrange(512, len(data) - 512)  # the data blocks
        damaged = bytearray(data)
        damaged[at] ^= rng.randrange(1, 256)
        log = read_log(bytes(damaged))
        assert log.bad == [at // 512]
        missing = set(truth.scans) - set(log.scans)
        assert 0 < len(missing) <= SCANS_PER_BLOCK
        assert all(truth.scans[n] == sums for n, sums in log.scans.items())
        due = int(log.summary["due"])
        assert len(log.scans) + len(missing) == due  # and the reader can tell


def test_a_damaged_first_block_costs_the_settings_but_no_data(recording):
    data, _ = recording
    truth = read_log(data)
    damaged = bytearray(data)
    damaged[100] ^= 1
    log = read_log(bytes(damaged), channels=8)
    assert log.scans == truth.scans and log.session == truth.session and log.header == {}


def test_a_bit_flipped_by_the_card_costs_one_block(logger, card):
    one = logger(card, signals=ramp(0, 90))
    assert one.command("start").ok
    first = one.board.counters().card_writes
    one.board.faults = Faults(flips={first + 3: 2000})
    one.run(4.0)
    assert one.command("stop").ok
    log = one.log()
    assert len(log.bad) == 1
    missing = int(log.summary["due"]) - len(log.scans)
    assert missing == SCANS_PER_BLOCK and log.summary["lost"] == "0"


def frames_of(raw):
    frames = (parse_frame(piece) for piece in raw.split(b"\0") if piece)
    return [(f.kind, f.counter, f.payload) for f in frames if f is not None]


@pytest.mark.parametrize("harm", ["change", "drop", "insert"])
def test_a_corrupt_byte_on_the_line_costs_one_frame(recording, harm):
    _, raw = recording
    truth = frames_of(raw)
    rng = random.Random(6)
    for _ in range(60):
        at = rng.randrange(len(raw))
        damaged = bytearray(raw)
        if harm == "change":
            damaged[at] ^= rng.randrange(1, 256)
        elif harm == "drop":
            del damaged[at]
        else:
            damaged.insert(at, rng.randrange(256))
        frames = frames_of(bytes(damaged))
        assert len(truth) - 1 <= len(frames) <= len(truth)
        rest = iter(truth)
        assert all(frame in rest for frame in frames)  # in order, and none invented


def test_frames_are_numbered_without_gaps(recording):
    counters = [counter for _, counter, _ in frames_of(recording[1])]
    assert len(counters) > 400
    assert all((b - a) % 256 == 1 for a, b in itertools.pairwise(counters))
