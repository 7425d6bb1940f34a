"""Promise 4: power may fail at any moment.

One session is simulated with a journal of every write. What the card holds after a cut inside write
n is then known exactly: the writes before n, and a part of n. Some cuts are simulated to show it.
"""

import contextlib
import itertools
from dataclasses import dataclass

import pytest

from tests.firmware.promises.logger import Logger, configure, faults_of, last_session
from tests.firmware.promises.reader import (
    Acknowledgement,
    Log,
    acknowledgement,
    parse_block,
    read_log,
)
from wheelhop.hil_sim import CardImage, Faults, PowerCut, Write, constant, ramp

CONFIGURATION = "size_mb = 1\nstream = on\n"
SECONDS = 5.0
OLD, NEW = constant(100.5), ramp(200.5, [20 + k for k in range(8)], seconds=30.0)
STORED = (0, 3, 24, 200, 510, 511, 512)
TAILS = ("old", "ones", "noise")


@dataclass(frozen=True)
class Session:
    base: CardImage  # before power-on
    journal: list[Write]
    frames: list[tuple[float, Acknowledgement]]  # acknowledgements and when they were sent
    truth: Log  # the session as it was closed
    started_s: float  # when `start` was answered
    eeprom_before: bytes
    eeprom_after: bytes

    @property
    def log_block(self) -> int:
        """Where on the card the log begins."""
        return first_block(self.journal)

    @property
    def header_write(self) -> int:
        """The write that stores the first block of the log."""
        return [write.block for write in self.journal].index(self.log_block)


def start_late(one: Logger) -> None:
    """Session ids are drawn from the clock: two sessions must not start at the same microsecond."""
    one.run(0.0371)
    assert one.command("start").ok


def record(one: Logger) -> tuple[float, bytes]:
    """A whole session; returns the moment at which it had been started, and the EEPROM then."""
    one.boot()
    start_late(one)
    started = one.board.time, one.board.eeprom()
    one.run(SECONDS)
    assert one.command("stop").ok
    return started


def first_block(journal: list[Write]) -> int:
    """Where on the card the log begins."""
    return next(write.block for write in journal if parse_block(write.data, 0))


@pytest.fixture(scope="module")
def session(elf, tmp_path_factory):
    """A session on a card that holds the blocks of another one at the very same place.

    Both are the first of their logger, so that file name and session number are the same.
    """
    folder = tmp_path_factory.mktemp("cut")
    base = configure(CardImage.fat32(folder / "base.img"), CONFIGURATION)
    old = base.copy(folder / "old.img")
    with Logger(elf, old, signals=OLD, journal=True) as one:
        one.boot()
        assert one.command("start").ok
        place = first_block(one.board.journal())
        one.run(2 * SECONDS)
        assert one.command("stop").ok
    stale = old.read(last_session(old.files()))
    for number in range(len(stale) // 512):
        base.write_block(place + number, stale[512 * number : 512 * (number + 1)])

    work = base.copy(folder / "work.img")
    with Logger(elf, work, signals=NEW, journal=True) as one:
        before = one.board.eeprom()
        started, after = record(one)
        truth, journal = one.log(), one.board.journal()
        frames = [(f.time_s, acknowledgement(f)) for f in one.frames if f.kind == "B"]
    assert first_block(journal) == place
    other = read_log(stale)
    assert other.session != truth.session and len(other.blocks) > len(truth.blocks)
    assert other.session >> 16 == truth.session >> 16  # only the drawn half tells them apart
    return Session(base, journal, frames, truth, started, before, after)


def torn(old: bytes, new: bytes, stored: int, tail: str) -> bytes:
    rest = {
        "old": old,
        "ones": b"\xff" * 512,
        "noise": bytes((37 * i + 11) % 251 for i in range(512)),
    }
    return new[:stored] + rest[tail][stored:]


def sound(card: CardImage) -> None:
    """The card can be mounted and what is on it is in order."""
    assert faults_of(card) == []
    assert "HOP.CFG" in card.listing()
    assert card.read("HOP.CFG") == CONFIGURATION.encode()


def complete(
    card: CardImage, session: Session, cut_s: float, recovered: bool = False
) -> Log | None:
    """All that was acknowledged is there, nothing stale is, and what is there is right."""
    acknowledged = [a for sent, a in session.frames if sent < cut_s]
    names = [name for name in card.files() if name.endswith(".HOP")]
    log = read_log(card.read(names[-1])) if names else None
    if log is None or log.session != session.truth.session:
        assert not acknowledged and cut_s < session.started_s
        assert log is None, "a stale session was taken for a new one"
        return None
    assert [block.number for block in log.blocks] == list(range(len(log.blocks)))
    if acknowledged:
        assert len(log.blocks) >= acknowledged[-1].blocks
        assert len(log.scans) >= acknowledged[-1].written
    for number, sums in log.scans.items():
        assert session.truth.scans[number] == sums
    assert list(log.scans) == list(range(len(log.scans)))
    if recovered:
        assert log.summary is not None and log.summary["end"] in ("recovered", "command")
        assert int(log.summary["due"]) == int(log.summary["written"]) == len(log.scans)
    return log


def possible_tails(session: Session, write: Write) -> tuple[str, ...]:
    """A torn sector of the log may be anything; one of the file system is half new, half old.

    No FAT survives garbage in its tables: that is the card's part of the promise.
    """
    return TAILS if write.block >= session.log_block else TAILS[:1]


def test_at_every_write_and_inside_it(session, tmp_path):
    """Cuts after 0 … 512 bytes of every write."""
    card = session.base.copy(tmp_path / "card.img")
    most = 0
    for write in session.journal:
        old = card.read_block(write.block)
        for stored, tail in itertools.product(STORED, possible_tails(session, write)):
            card.write_block(write.block, torn(old, write.data, stored, tail))
            if write.block < session.log_block or stored == STORED[0]:
                sound(card)  # what is inside the log is no matter of the file system's
            log = complete(card, session, write.time_s)
            most = max(most, len(log.scans) if log else 0)
        card.write_block(write.block, write.data)
    assert most == len(session.truth.scans)


def test_the_next_start_recovers_the_session(session, elf, tmp_path):
    """After a cut inside any write the logger starts, closes the file, and records again."""
    card = session.base.copy(tmp_path / "card.img")
    recovered = 0
    for index, write in enumerate(session.journal):
        old = card.read_block(write.block)
        tails = possible_tails(session, write)
        tail = tails[index % len(tails)]
        card.write_block(write.block, torn(old, write.data, 200 * (index % 3), tail))
        again = card.copy(tmp_path / "again.img")
        eeprom = session.eeprom_after if index >= session.header_write else session.eeprom_before
        with Logger(elf, again, eeprom=eeprom, signals=OLD) as one:
            one.boot()
            one.command("info")  # the card has been met by then
            closed = complete(again, session, write.time_s, recovered=index > session.header_write)
            sound(again)
            if index % 8 == 0:
                start_late(one)
                one.run(0.8)
                assert one.command("stop").ok
                assert len(one.log().scans) >= 79
                sound(again)
                if closed:
                    names = sorted(name for name in again.files() if name.endswith(".HOP"))
                    assert len(names) == 2
                    earlier = read_log(again.read(names[0]))
                    assert earlier is not None and earlier.scans == closed.scans
        recovered += closed is not None and index > session.header_write
        card.write_block(write.block, write.data)
    assert recovered > 15


@pytest.mark.parametrize("share", [0.05, 0.3, 0.6, 0.85, 0.99])
def test_a_simulated_cut_leaves_exactly_what_the_journal_says(session, elf, tmp_path, share):
    number = int(share * len(session.journal))
    expected = session.base.copy(tmp_path / "expected.img")
    for write in session.journal[:number]:
        expected.write_block(write.block, write.data)
    last = session.journal[number]
    expected.write_block(last.block, torn(expected.read_block(last.block), last.data, 100, "ones"))

    card = session.base.copy(tmp_path / "card.img")
    faults = Faults(power_cut=PowerCut(number, stored=100, tail="ones"))
    with Logger(elf, card, signals=NEW, faults=faults) as one:
        with contextlib.suppress(AssertionError):  # the command that the cut leaves unanswered
            record(one)
        assert one.board.state == "off"
        assert one.board.counters().card_writes == number + 1
    assert card.path.read_bytes() == expected.path.read_bytes()


@pytest.mark.parametrize("block", [2, 11])
def test_a_second_cut_during_recovery_loses_nothing_either(session, elf, tmp_path, block):
    number = [write.block for write in session.journal].index(session.log_block + block)
    first = session.base.copy(tmp_path / "first.img")
    for write in session.journal[:number]:
        first.write_block(write.block, write.data)
    cut_s = session.journal[number].time_s
    work = first.copy(tmp_path / "work.img")
    with Logger(elf, work, eeprom=session.eeprom_after, journal=True) as one:
        one.boot()
        one.command("info")
        journal = one.board.journal()
    assert len(journal) > 3
    for index, write in enumerate(journal):
        first.write_block(write.block, torn(first.read_block(write.block), write.data, 300, "old"))
        sound(first)
        complete(first, session, cut_s)
        if index % 4 == 0:
            again = first.copy(tmp_path / "again.img")
            with Logger(elf, again, eeprom=session.eeprom_after) as one:
                one.boot()
                one.command("info")
            sound(again)
            complete(again, session, cut_s, recovered=True)
        first.write_block(write.block, write.data)
