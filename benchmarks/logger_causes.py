"""What goes wrong in the trials of `benchmarks.logger_faults`: causes, cards, EEPROMs."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from tests.firmware.promises.logger import Logger, configure
from tests.firmware.promises.reader import Log, read_log
from wheelhop.hil_sim import BadReply, CardImage, Faults, PowerCut

WATCHDOG_S = 2.2  # it bites after 2 s
REPLIES = (0xFF, 0x00, 0x01, 0x04, 0x08, 0x40, 0x7F)
COMMANDS = (0, 8, 9, 10, 13, 16, 24, 41, 55, 58, 59)
PHOTO, PRECIOUS = "PHOTO.JPG", b"precious"
SLOW_READ_S = 2.4e-3

Rng = np.random.Generator


class Subject(Logger):
    """A logger, the settings of its cards, what was taken off them, and what is not its own."""

    def __init__(self, elf: Path, card: CardImage, settings: str, **options: object) -> None:
        super().__init__(elf, card, **options)
        self.settings = settings
        self.cards = [card]
        self.taken: list[Log] = []
        self.photos: dict[Path, bytes] = {}

    def take_logs(self) -> list[str]:
        """Copy the sessions on the card in use to the PC; return their names."""
        card = self.cards[-1]
        names = [
            name for name, size in card.files().items() if name.endswith(".HOP") and size > 512
        ]
        logs = {name: log for name in names if (log := read_log(card.read(name))) is not None}
        self.taken += logs.values()
        return list(logs)

    def put_photo(self, rng: Rng) -> None:
        """Copy a photo onto the card in use, longer than what was recorded."""
        card = self.cards[-1]
        self.photos[card.path] = rng.bytes(int(rng.integers(1, 2_000_000)))
        card.write(PHOTO, self.photos[card.path])


def bounces(rng: Rng, now: float) -> list[tuple[float, float]]:
    """Bursts of open contacts, 0.2 to 30 ms each."""
    gaps = []
    for burst in now + np.sort(rng.uniform(0.1, 2.5, rng.integers(1, 4))):
        for start in burst + np.cumsum(rng.exponential(0.02, rng.integers(1, 6))):
            gaps.append((float(start), float(start + rng.uniform(0.2e-3, 30e-3))))
    return gaps


def bounce(rng: Rng, one: Subject) -> Faults:
    """Contacts open for moments; the card loses its power."""
    return Faults(bounces=bounces(rng, one.board.time))


def slow_sheets(rng: Rng, one: Subject) -> Faults:
    """The same, and the card is slow to identify itself."""
    latency = float(rng.uniform(1e-3, 0.15))
    return Faults(bounces=bounces(rng, one.board.time), sheet_latency=latency)


def bad_replies(rng: Rng, one: Subject) -> Faults:
    """The same, and commands fail."""
    bad = [
        BadReply(int(rng.choice(COMMANDS)), int(rng.integers(0, 6)), int(rng.choice(REPLIES)))
        for _ in range(rng.integers(1, 6))
    ]
    return Faults(bounces=bounces(rng, one.board.time), bad_replies=bad)


def loosens(rng: Rng, one: Subject) -> Faults:
    """The card goes and comes, and its CSD cannot be read at once: scans find no room."""
    start = one.board.time + float(rng.uniform(0.1, 1.5))
    gap = (start, start + float(rng.uniform(2e-3, 30e-3)))
    bad = [BadReply(9, nth, 0xFF) for nth in range(int(rng.integers(1, 3)))]
    return Faults(bounces=[gap], bad_replies=bad)


def no_checks(rng: Rng, one: Subject) -> Faults:
    """The same, with a card that checks nothing."""
    return Faults(bounces=bounces(rng, one.board.time), ignores_crc=True)


def stalls(rng: Rng, one: Subject) -> Faults:
    """The card is busy for long."""
    first = one.board.counters().card_writes
    writes = first + rng.integers(0, 12, rng.integers(1, 5))
    return Faults(stalls={int(write): float(rng.uniform(0.05, 0.9)) for write in writes})


def waits(rng: Rng, one: Subject) -> Faults:
    """The same, and the program waits for something meanwhile: scans are skipped."""
    starts = one.board.time + rng.uniform(0.0, 3.0, rng.integers(10, 40))
    holds = [(float(start), float(start + rng.uniform(2e-3, 60e-3))) for start in starts]
    return replace(stalls(rng, one), holds=holds)


def sags(rng: Rng, one: Subject) -> Faults:
    """The sensors' supply sags and recovers, and the card is busy for long."""
    faults = stalls(rng, one)
    for volts in rng.uniform(2.6, 3.6, rng.integers(1, 5)):
        one.board.reference_volts = float(volts)
        one.run(float(rng.uniform(0.05, 0.5)))
    one.board.reference_volts = 3.3
    return faults


def rejects(rng: Rng, one: Subject) -> Faults:
    """Writes are refused."""
    first = one.board.counters().card_writes
    writes = first + rng.integers(0, 12, rng.integers(1, 6))
    return Faults(rejects={int(w): "crc" if rng.random() < 0.5 else "write" for w in writes})


def cut(rng: Rng, one: Subject) -> Faults:
    """The power fails inside a write."""
    write = one.board.counters().card_writes + int(rng.integers(0, 10))
    tails: tuple[Literal["old", "ones", "noise"], ...] = ("old", "ones", "noise")
    tail = tails[rng.integers(3)]
    return Faults(power_cut=PowerCut(write, int(rng.integers(0, 513)), tail))


def reset(rng: Rng, one: Subject) -> Faults:
    """The controller starts anew, once or twice, the card does not; it may be away, or busy."""
    one.run(float(rng.uniform(0.0, 2.0)))
    kind = rng.integers(3)
    away = one.board.time + rng.uniform(0.0, 0.6) + (kind == 2) * WATCHDOG_S
    write = one.board.counters().card_writes
    faults = (
        Faults(),
        Faults(bounces=[(float(away), float(away + rng.uniform(0.0, 2.0)))]),
        Faults(stalls={write: float(rng.uniform(0.5, 1.9))}),
    )[rng.integers(3)]
    one.board.faults = faults
    one.run(float(rng.uniform(0.0, 0.6)))
    if kind == 2:
        one.board.serial.write(b"reset\n")
        one.run(WATCHDOG_S)
    else:
        one.board.reset("external" if kind else "brown-out")
    if rng.random() < 0.5:
        one.run(float(rng.uniform(0.0, 1.8)))
        one.board.reset("brown-out")
    return faults


def fills(rng: Rng, one: Subject) -> Faults:
    """A file is full, and the controller may start anew before the next one is there."""
    one.until(lambda: bool(told := one.acknowledgements()) and told[-1].blocks >= 58, 30.0)
    one.run(float(rng.uniform(0.0, 0.7)))
    if rng.random() < 0.7:
        one.board.reset("external" if rng.random() < 0.5 else "brown-out")
    return Faults()


def edited(rng: Rng, one: Subject) -> Faults:
    """The card is taken out of the running session, edited on a PC, and put back; or a twin is, a
    card with the same identification."""
    one.board.insert(None)
    one.run(float(rng.uniform(0.05, 2.0)))
    card = one.cards[-1]
    names = one.take_logs()
    kind = rng.integers(3)
    if kind == 0:
        for name in names:
            card.delete(name)
    else:
        path = card.path if kind == 1 else card.path.with_suffix(f".{len(one.cards)}.img")
        make = CardImage.fat32 if card.kind == "sdhc" else CardImage.fat16
        card = make(path)
        configure(card, one.settings)
        one.photos.pop(path, None)
        one.cards = [*(other for other in one.cards if other.path != path), card]
    one.put_photo(rng)
    one.board.insert(card)  # whose writes count from 0 now
    return Faults()


def late_busy(rng: Rng, one: Subject) -> Faults:
    """The card shows a byte late that it is busy, and is, for long."""
    return replace(stalls(rng, one), late_busy=1)


def refused_beginnings(rng: Rng, one: Subject) -> Faults:
    """Writes are refused and reads fail while the next file is made, after a reset or at the end of
    one that is full."""
    if rng.random() < 0.5:
        one.board.reset("external" if rng.random() < 0.5 else "brown-out")
    else:
        fills(rng, one)
    first = one.board.counters().card_writes + int(rng.integers(0, 12))
    some = int(rng.integers(1, 8))
    bad = [BadReply(17, int(nth)) for nth in rng.integers(0, 200, 2)]
    return Faults(rejects={first + k: "write" for k in range(some)}, bad_replies=bad)


CAUSES: dict[str, Callable[[Rng, Subject], Faults]] = {
    "contact bounce": bounce,
    "slow CSD and CID": slow_sheets,
    "bad replies": bad_replies,
    "CSD fails once": loosens,
    "CMD59 ignored": no_checks,
    "stalls to 0.9 s": stalls,
    "program waits": waits,
    "refused writes": rejects,
    "power cuts": cut,
    "resets": reset,
    "full files": fills,
    "supply sags": sags,
    "edited card, twin": edited,
    "late busy": late_busy,
    "files not begun": refused_beginnings,
}
THREE = "three of these"
IN_SMALL_FILES = ("full files", "files not begun")


def three(rng: Rng, one: Subject, chosen: list[str]) -> Faults:
    """Several causes, one begun after another."""
    faults = Faults()
    for cause in chosen:
        more = CAUSES[cause](rng, one)
        faults = replace(
            faults,
            stalls={**faults.stalls, **more.stalls},
            rejects={**faults.rejects, **more.rejects},
            bounces=[*faults.bounces, *more.bounces],
            holds=[*faults.holds, *more.holds],
            bad_replies=[*faults.bad_replies, *more.bad_replies],
            power_cut=faults.power_cut or more.power_cut,
            ignores_crc=faults.ignores_crc or more.ignores_crc,
            late_busy=max(faults.late_busy, more.late_busy),
            sheet_latency=max(faults.sheet_latency, more.sheet_latency),
        )
        if one.board.state != "running":
            break
    return faults


def plain_card(rng: Rng, path: Path) -> CardImage:
    """An empty card of either addressing."""
    return CardImage.fat16(path) if rng.random() < 0.3 else CardImage.fat32(path)


def many_logs(rng: Rng, path: Path) -> CardImage:
    """Up to a thousand logs."""
    card = CardImage.fat32(path)
    some = int(rng.integers(1, 1001))
    card.write_all({f"HOP{k:05}.HOP": b"x" * 512 for k in range(1, some + 1)})
    return card


def in_the_way(rng: Rng, path: Path) -> CardImage:
    """Under the next names a read-only file and a folder."""
    card = plain_card(rng, path)
    card.write("HOP00001.HOP", PRECIOUS)
    card.protect("HOP00001.HOP")
    card.make_folder("HOP00002.HOP")
    return card


def large(rng: Rng, path: Path) -> CardImage:
    """32 GB, with room for a file at the end."""
    card = CardImage.fat32(path, 32 * 1024, cluster_blocks=64, partitioned=True)
    card.reserve(int(rng.integers(70, 400)) << 20)
    return card


CARDS = (*[plain_card] * 8, many_logs, in_the_way, large)


def eeprom(rng: Rng) -> bytes | None:
    """Erased as a rule; or zeros, or noise."""
    kind = rng.integers(8)
    if kind == 0:
        return bytes(1024)
    if kind == 1:
        return rng.bytes(1024)
    return None
