"""Cards as they come: each kind works, or says by message and light what is wrong with it."""

import dataclasses

import pytest

from tests.firmware.promises.logger import configure
from tests.firmware.promises.test_stalls import check_totals
from wheelhop.hil_sim import CardImage, Faults, Signals, constant, sines

SMALL = "size_mb = 1\nstream = on\n"


def waves() -> Signals:
    return sines([1, 2, 3, 4, 5, 6, 7, 8], seconds=30.0, rate_hz=1000.0)


GOOD = {
    "FAT32": lambda path: CardImage.fat32(path),
    "FAT32 in a partition": lambda path: CardImage.fat32(path, partitioned=True),
    "FAT32, 8 GB": lambda path: CardImage.fat32(path, 8192, partitioned=True),
    "FAT16": lambda path: CardImage.fat16(path, kind="sdhc"),
    "FAT16 on a card addressed by bytes": lambda path: CardImage.fat16(path, partitioned=True),
    "FAT16 on a card of version 1": lambda path: CardImage.fat16(path, kind="sd-v1"),
    "in pieces of 3000 clusters": lambda path: fragmented(path, 3000),
    "nearly full": lambda path: filled(path, 5 << 20),
}


def fragmented(path, free_run):
    card = CardImage.fat32(path)
    card.fragment(free_run)
    return card


def filled(path, leave):
    card = CardImage.fat32(path)
    card.fill(leave)
    return card


@pytest.mark.parametrize("make", GOOD.values(), ids=GOOD.keys())
def test_cards_that_work(logger, tmp_path, make):
    card = make(tmp_path / "card.img")
    large = card.path.stat().st_size > 1 << 30
    configure(card, "stream = on\n" + "size_mb = 4\n" * (not large))
    one = logger(card, signals=waves())
    reply = one.command("start")
    assert reply.ok, reply
    one.run(2.0)
    reply = one.command("stop")
    log = one.log()
    assert check_totals(one, log, reply)[2] == 0
    streamed = {n: sums for (session, n), sums in one.streamed().items() if session == log.session}
    assert streamed == log.scans
    assert card.check() == ""
    assert one.board.counters().card_violations == 0, one.board.last_violation()


def no_card(_):
    return None


BAD = {
    "no card": (no_card, {}, 2, "no card"),
    "unformatted": (CardImage.unformatted, {}, 3, "no FAT file system"),
    "GPT": (CardImage.gpt, {}, 3, "no FAT file system: format FAT32 with MBR"),
    "exFAT": (CardImage.exfat, {}, 3, ("no FAT file system", "card is exFAT")),
    "full": (lambda path: filled(path, 0), {}, 4, "no room"),
    "in pieces": (lambda path: fragmented(path, 100), {}, 4, "no room"),
    "write-protected": (CardImage.fat32, {"write_protected": True}, 5, "card is write-protected"),
    "refuses all writes": (
        CardImage.fat32,
        {"rejects": dict.fromkeys(range(400), "write")},
        6,
        "card error",
    ),
}


@pytest.mark.parametrize(("make", "faults", "flashes", "text"), BAD.values(), ids=BAD.keys())
def test_cards_that_do_not_work_say_why(logger, tmp_path, make, faults, flashes, text):
    card = make(tmp_path / "card.img")
    one = logger(card, faults=Faults(**faults), trace=True)
    assert one.command("set size_mb=1").ok
    reply = one.command("start")
    assert not reply.ok and reply.text.startswith(text), reply
    assert one.flashes() == flashes
    assert any(message.startswith(text) for message in one.texts("M"))
    assert one.command("status").values["state"] == "ready"
    if card is not None and card.start == 0 and faults:
        assert card.files() == {} and card.check() == ""


def test_a_full_card_is_refused_in_time(logger, tmp_path):
    """The specification gives `start` 15 seconds; the size is the default, 256 MiB."""
    card = CardImage.fat32(tmp_path / "card.img", 8192, partitioned=True)
    card.reserve(leave=300_000)
    one = logger(card)
    reply = one.command("start", timeout=15.0)
    assert not reply.ok and reply.text.startswith("no room")


def test_a_good_card_can_take_the_place_of_a_bad_one(logger, tmp_path):
    bad = CardImage.unformatted(tmp_path / "bad.img")
    good = dataclasses.replace(CardImage.fat32(tmp_path / "good.img"), serial=2)
    one = logger(bad)
    assert not one.command("start").ok
    one.board.insert(None)
    one.run(0.5)
    one.board.insert(configure(good, SMALL))
    one.card = good
    one.run(0.5)
    assert one.command("start").ok
    one.run(1.0)
    assert one.command("stop").ok
    assert len(one.log().scans) >= 99


def pulled(logger, card, back_after):
    """A session in which the card leaves its socket for a while, or for good."""
    one = logger(card, signals=waves(), trace=True)
    assert one.command("start").ok
    one.run(1.5)
    one.board.insert(None)
    one.run(back_after)
    return one


@pytest.mark.parametrize("away_s", [0.2, 1.5, 4.0])
def test_a_card_that_is_shaken_loose_and_comes_back_is_used_again(logger, card, away_s):
    one = pulled(logger, card, away_s)
    one.board.insert(card)
    one.run(3.0)
    reply = one.command("stop")
    log = one.log()
    due, _, lost = check_totals(one, log, reply)
    assert lost <= 100 * (away_s + 1.3)  # 0.5 s between attempts, and the card's start
    assert due >= 100 * (4.5 + away_s) - 2
    streamed = {n: sums for (session, n), sums in one.streamed().items() if session == log.session}
    assert sorted(streamed) == list(range(due))
    assert all(streamed[n] == sums for n, sums in log.scans.items())
    assert card.check() == ""


def test_a_card_that_is_pulled_for_good_keeps_what_was_acknowledged(logger, card):
    one = pulled(logger, card, 1.0)
    rises = [on for _, on in one.board.trace().led()]
    one.run(2.0)
    assert len(one.board.trace().led()) >= 15 > len(rises)  # it flickers, 5 a second
    reply = one.command("stop")
    assert not reply.ok and reply.text.startswith("no card")
    summary = one.summary()
    assert int(summary["due"]) == int(summary["written"]) + int(summary["lost"])
    last = one.acknowledgements()[-1]
    log = one.log()
    assert len(log.blocks) >= last.blocks and len(log.scans) >= last.written >= 100
    assert log.summary is None
    one.board.insert(card)
    one.run(0.5)
    assert one.command("start").ok  # meets the card, and closes the file of before
    names = sorted(name for name in card.files() if name.endswith(".HOP"))
    closed = one.log(names[0])
    assert closed.summary["end"] == "recovered" and closed.scans == log.scans


def test_another_card_is_not_written_into(logger, card, tmp_path):
    other = dataclasses.replace(CardImage.fat32(tmp_path / "other.img"), serial=99)
    other.write("PHOTO.JPG", bytes(range(256)) * 400)
    before = other.path.read_bytes()
    one = pulled(logger, card, 0.3)
    one.board.insert(other)
    one.run(3.0)
    assert not one.command("stop").ok
    assert other.path.read_bytes() == before


@pytest.mark.parametrize("error", ["crc", "write"])
@pytest.mark.parametrize("count", [1, 3])
def test_refused_writes_are_repeated_and_counted(logger, card, error, count):
    one = logger(card, signals=waves())
    assert one.command("start").ok
    first = one.board.counters().card_writes
    one.board.faults = Faults(rejects={first + 2 + k: error for k in range(count)})
    one.run(4.0)
    reply = one.command("stop")
    log = one.log()
    assert check_totals(one, log, reply)[2] == 0
    assert int(log.summary["card_errors"]) == count
    assert log.bad == []


def test_a_card_that_refuses_for_ever_loses_what_it_refuses_and_no_more(logger, card):
    one = logger(card, signals=constant(300.5))
    assert one.command("start").ok
    first = one.board.counters().card_writes
    one.board.faults = Faults(rejects={first + 4 + k: "write" for k in range(3000)})
    one.run(5.0)
    one.command("stop")
    summary = one.summary()
    assert int(summary["due"]) == int(summary["written"]) + int(summary["lost"])
    assert int(summary["written"]) == len(one.log().scans) == one.acknowledgements()[-1].written
    assert int(summary["lost"]) > 200 and int(summary["card_errors"]) > 3


def test_an_existing_file_is_never_overwritten(logger, card):
    card.write("HOP00001.HOP", b"precious" * 1000)
    one = logger(card)
    assert one.command("start").text == "HOP00002.HOP"
    one.run(0.5)
    one.command("stop")
    assert card.read("HOP00001.HOP") == b"precious" * 1000
