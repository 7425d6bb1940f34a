"""Faults by the hundred: the logger's firmware on the simulated board, held against its inputs.

    python -m benchmarks.logger_faults --seeds 500

A trial is a session at 100, 200 or 400 Hz, with or without streaming, behind one boot loader or
another, with an EEPROM that may be full of noise. The card is of either addressing; it may have a
thousand logs, be large, full and slow, or have something under the next name; the file may be as
long as it can be on the card's clusters, mostly of 512 bytes. There are faults of
one cause, or of three, at random moments. `start` may take 5 s, and after the faults the logger
must be recording again within 10 s, unless the power was off. The files are decoded as
firmware/SPEC.md says, and every scan compared by its number with what the converter's inputs were.
Every scan that the logger has acknowledged must be on a card, in its file or for `wheelhop recover`
to find, or among what was taken off it before it was edited; what is not the logger's must be as it
was. Exit code 1 if anything is wrong.
"""

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.logger_causes import (
    CARDS,
    CAUSES,
    IN_SMALL_FILES,
    PHOTO,
    PRECIOUS,
    SLOW_READ_S,
    THREE,
    Rng,
    Subject,
    eeprom,
    in_the_way,
    large,
    three,
)
from tests.firmware.promises.boot_loaders import LOADERS
from tests.firmware.promises.logger import configure, faults_of
from tests.firmware.promises.reader import Log, acknowledgement, read_log
from wheelhop.hil_sim import CardImage, Event, Faults, Trace, from_array
from wheelhop.logger.recovery import recover

ROOT = Path(__file__).parents[1]
ELF = ROOT / "build/firmware/nano/firmware.elf"
SMALL = ROOT / "build/firmware/nano-small-files/firmware.elf"  # files of 64 blocks
TABLE_HZ, TABLE_S = 400.0, 30.0
START_S, GO_ON_S = 5.0, 10.0
PAUSE_CYCLES = 10_000  # between conversions: two runs of the converter


@dataclass
class Outcome:
    """Of one trial: counts, and in words what is wrong."""

    cause: str
    chosen: list[str] = field(default_factory=list)
    pause_s: float = 0.0  # until it was recording again, asked from 2.5 s on
    decoded: int = 0
    acknowledged: int = 0
    lost: int = 0
    rescued: int = 0  # sessions that are in no file whole, and that `wheelhop recover` brings back
    wrong: list[str] = field(default_factory=list)


def inputs(rng: Rng) -> NDArray[np.float64]:
    """Eight inputs that look alike in no two scans."""
    walk = np.cumsum(rng.normal(0, 14, (int(TABLE_HZ * TABLE_S), 8)), axis=0)
    return 512 + 450 * np.sin(walk / 300 + rng.uniform(0, 6, 8))


def runs_of(trace: Trace) -> list[NDArray[np.void]]:
    """The conversions that Timer1 has triggered, each run without a pause."""
    events = trace.of(Event.CONVERSION)
    events = events[events["which"] < 8]  # the supply's aside
    steps = np.diff(events["cycle"].astype(np.int64))
    runs = np.split(events, np.flatnonzero(steps > PAUSE_CYCLES) + 1)
    return [run[_by_hand(run) :] for run in runs if len(run) > 16]


def _by_hand(run: NDArray[np.void]) -> int:
    """Conversions at the beginning of a run that the timer has not started."""
    steps = np.diff(run["cycle"][:17].astype(np.int64))
    return int(np.flatnonzero(steps != 2500)[-1]) + 1 if (steps != 2500).any() else 0


def expected(run: NDArray[np.void], conversions: int) -> NDArray[np.int64]:
    """(n, 8) sums of the scans of a run, from the codes that stood at the pins."""
    length = 8 * conversions
    count = len(run) // length
    codes = run["value"][: count * length].reshape(count, length).astype(np.int64)
    which = run["which"][: count * length].reshape(count, length)
    return np.stack([(codes * (which == k)).sum(axis=1) for k in range(8)], axis=1)


def check(outcome: Outcome, log: Log, run: NDArray[np.void]) -> None:
    """Compare every scan of a file with the inputs, by number."""
    truth = expected(run, int(log.header["conversions"]))
    numbers = np.array(sorted(log.scans), dtype=np.int64)
    outcome.decoded += len(numbers)
    if not len(numbers):
        return
    if numbers[-1] >= len(truth):
        outcome.wrong.append(f"scan {numbers[-1]} was never taken: {len(truth)} were")
        numbers = numbers[numbers < len(truth)]
    sums = np.array([log.scans[int(n)] for n in numbers])
    differ = np.flatnonzero((sums != truth[numbers]).any(axis=1))
    if len(differ):
        outcome.wrong.append(f"{len(differ)} scans from {numbers[differ[0]]} on are not their own")
    seen = 0
    for block in log.blocks:
        if block.kind == b"D" and block.first_scan != seen + block.lost:
            outcome.wrong.append(f"block {block.number}: first_scan is not written + lost")
        seen += block.count
    if log.summary is not None:
        due, written, lost = (int(log.summary[key]) for key in ("due", "written", "lost"))
        outcome.lost += lost
        if due != written + lost or written != len(log.scans):
            outcome.wrong.append(f"summary: due {due}, written {written}, lost {lost}")


def begin(outcome: Outcome, one: Subject) -> bool:
    """Start a session, in time."""
    one.boot()
    asked_s = one.board.time
    if not one.command("start", 60.0).ok:
        outcome.wrong.append("does not start")
        return False
    if (took_s := one.board.time - asked_s) > START_S:
        outcome.wrong.append(f"starts after {took_s:.1f} s")
    return True


def go_on(outcome: Outcome, one: Subject) -> None:
    """The faults have ended: it records again in time, unless the power was off."""
    one.board.faults = Faults()
    ended_s = one.board.time
    was_off = one.board.state != "running"
    if was_off:
        one.board.power_on()
    one.run(2.5)

    def records() -> bool:
        return bool(one.command("status", 30.0).values["state"] == "recording")

    while not (recording := records()) and not was_off and one.board.time - ended_s < GO_ON_S:
        one.run(0.5)
    if recording == was_off:
        outcome.wrong.append("goes on by itself" if recording else "does not go on")
    outcome.pause_s = 0.0 if was_off else one.board.time - ended_s


def trial(seed: int, folder: Path, elf: Path = ELF, small: Path = SMALL) -> Outcome:
    """One session with one cause of faults, or three; the seed chooses everything."""
    rng = np.random.default_rng(seed)
    cause = (*CAUSES, *[THREE] * len(CAUSES))[seed % (2 * len(CAUSES))]
    chosen = [cause] if cause in CAUSES else [str(c) for c in rng.choice(list(CAUSES), 3, False)]
    outcome = Outcome(cause, chosen)
    rate = (100, 200, 400)[rng.integers(3)]
    stream = "on" if rng.random() < 0.5 else "off"
    make = CARDS[rng.integers(len(CARDS))]
    program = small if {*IN_SMALL_FILES} & {*chosen} else elf
    size_mb = 128 if program is elf and rng.random() < 0.3 else 1
    settings = f"size_mb = {size_mb}\nrate = {rate}\nstream = {stream}\n"
    card = configure(make(rng, folder / f"{seed}.img"), settings)
    options = {
        "signals": from_array(inputs(rng), TABLE_HZ, repeat=True),
        "boot_loader": (None, *LOADERS.values())[rng.integers(1 + len(LOADERS))],
        "eeprom": eeprom(rng),
        "faults": Faults(read_latency=SLOW_READ_S if make is large else 100e-6),
        "trace": True,
    }
    with Subject(program, card, settings, **options) as one:
        if not begin(outcome, one):
            return outcome
        one.run(float(rng.uniform(0.2, 1.0)))
        one.board.faults = three(rng, one, chosen)
        one.run(3.0)
        go_on(outcome, one)
        one.command("stop", 30.0)
        if not one.command("start", 30.0).ok:  # closes what is open
            outcome.wrong.append("does not start again")
        one.command("stop", 30.0)
        judge(outcome, one, in_the_way_of(make))
    for used in one.cards:
        used.path.unlink()
    return outcome


def in_the_way_of(make: object) -> dict[str, bytes]:
    """What a card held before, and must hold still."""
    return {"HOP00001.HOP": PRECIOUS} if make is in_the_way else {}


def judge(outcome: Outcome, one: Subject, held: dict[str, bytes]) -> None:
    """Compare all that was recorded with the inputs, and the cards with what was on them."""
    runs = runs_of(one.board.trace())
    starts = np.array([run["cycle"][0] for run in runs]) / 16e6
    began, safe = {}, {}
    for frame in one.frames:
        if frame.kind == "H" and frame.text.startswith("session="):
            began[int(frame.text[8:], 16)] = frame.time_s
        elif frame.kind == "B":
            told = acknowledgement(frame)
            safe[told.session] = told
    logs = {log.session: log for log in one.taken}
    for card in one.cards:
        files = {name: card.read(name) for name, size in card.files().items() if size != 512}
        found = [log for name in files if name[-4:] == ".HOP" and (log := read_log(files[name]))]
        logs.update({log.session: log for log in found})
        photo = one.photos.get(card.path)
        if photo is not None and files.get(PHOTO) != photo:
            outcome.wrong.append("a photo was written into")
        if any(files[name] != held[name] for name in held.keys() & files.keys()):
            outcome.wrong.append("a file of before was written into")
        if damage := faults_of(card):
            outcome.wrong.append(f"file system: {damage[0]}")
    for log in logs.values():
        if log.session in began:
            check(outcome, log, runs[int(np.searchsorted(starts, began[log.session])) - 1])
    for session, told in safe.items():
        outcome.acknowledged += told.written
        there = {block.number for block in logs[session].blocks} if session in logs else set()
        missing = set(range(told.blocks)) - there
        if not missing and len(logs[session].scans) >= told.written:
            continue
        if (log := rescued(one.cards, session)) is None or len(log.scans) < told.written:
            outcome.wrong.append(f"of {told.written} scans acknowledged some are gone")
        else:
            outcome.rescued += 1
            check(outcome, log, runs[int(np.searchsorted(starts, began[session])) - 1])


def rescued(cards: Sequence[CardImage], session: int) -> Log | None:
    """What `wheelhop recover` saves of a session that is in no file whole."""
    with tempfile.TemporaryDirectory() as folder:
        for number, card in enumerate(cards):
            for saved in recover(card.path, Path(folder) / str(number)):
                if saved.session == session:
                    return read_log(saved.path.read_bytes())
    return None


def table(outcomes: list[Outcome]) -> str:
    """Figures by cause, and of all."""
    rows = [f"{'cause':18}{'trials':>8}{'decoded':>10}{'acknowledged':>14}{'lost':>8}{'wrong':>7}"]
    for cause in (*CAUSES, THREE, "all"):
        mine = [outcome for outcome in outcomes if cause in (outcome.cause, "all")]
        decoded, safe, lost = (
            sum(getattr(outcome, key) for outcome in mine)
            for key in ("decoded", "acknowledged", "lost")
        )
        wrong = sum(bool(outcome.wrong) for outcome in mine)
        rows.append(f"{cause:18}{len(mine):>8}{decoded:>10}{safe:>14}{lost:>8}{wrong:>7}")
    saved = sum(outcome.rescued for outcome in outcomes)
    pause_s = max((outcome.pause_s for outcome in outcomes), default=0.0)
    rows.append(f"sessions that only `wheelhop recover` brings back: {saved}")
    return "\n".join([*rows, f"recording again after {pause_s:.1f} s at the latest"])


def main() -> int:
    """Run the trials and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, default=500, help="how many trials (default 500)")
    parser.add_argument("--first", type=int, default=0, help="seed of the first (default 0)")
    options = parser.parse_args()
    subprocess.run(
        [ROOT / "tools/build_firmware.sh", "nano", "nano-small-files"],
        check=True,
        stdout=sys.stderr,
    )
    outcomes: list[Outcome] = []
    with tempfile.TemporaryDirectory() as folder, suppress(KeyboardInterrupt):
        for seed in range(options.first, options.first + options.seeds):
            outcomes.append(trial(seed, Path(folder)))
            for text in outcomes[-1].wrong:
                print(f"seed {seed}, {', '.join(outcomes[-1].chosen)}: {text}", flush=True)
            print(f"\r{len(outcomes)} of {options.seeds}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    print(table(outcomes))
    return 1 if any(outcome.wrong for outcome in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
