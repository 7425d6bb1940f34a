"""Faults by the hundred: the logger's firmware on the simulated board, held against its inputs.

    python -m benchmarks.logger_faults --seeds 500

A trial is a session at 100, 200 or 400 Hz, with or without streaming, on a card of either
addressing and behind one boot loader or another, and a fault of one cause at random moments.
Afterwards it must still be recording, unless the power was off. The file is decoded as
firmware/SPEC.md says, and every scan compared by its number with what the converter's inputs were;
every block that the logger has acknowledged must be there. Exit code 1 if anything is wrong.
"""

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tests.firmware.promises.boot_loaders import LOADERS
from tests.firmware.promises.logger import Logger, configure, faults_of
from tests.firmware.promises.reader import Log, acknowledgement, read_log
from wheelhop.hil_sim import BadReply, CardImage, Event, Faults, PowerCut, Trace, from_array

ROOT = Path(__file__).parents[1]
ELF = ROOT / "build/firmware/nano/firmware.elf"
SMALL = ROOT / "build/firmware/nano-small-files/firmware.elf"  # files of 64 blocks
TABLE_HZ, TABLE_S = 400.0, 30.0
WATCHDOG_S = 2.2  # it bites after 2 s
PAUSE_CYCLES = 10_000  # between conversions: two runs of the converter
REPLIES = (0xFF, 0x00, 0x01, 0x04, 0x08, 0x40, 0x7F)
COMMANDS = (0, 8, 9, 10, 13, 16, 24, 41, 55, 58, 59)

Rng = np.random.Generator


@dataclass
class Outcome:
    """Of one trial: counts, and in words what is wrong."""

    cause: str
    decoded: int = 0
    acknowledged: int = 0
    lost: int = 0
    wrong: list[str] = field(default_factory=list)


def bounces(rng: Rng, now: float) -> list[tuple[float, float]]:
    """Bursts of open contacts, 0.2 to 30 ms each."""
    gaps = []
    for burst in now + np.sort(rng.uniform(0.1, 2.5, rng.integers(1, 4))):
        for start in burst + np.cumsum(rng.exponential(0.02, rng.integers(1, 6))):
            gaps.append((float(start), float(start + rng.uniform(0.2e-3, 30e-3))))
    return gaps


def bounce(rng: Rng, one: Logger) -> Faults:
    """Contacts open for moments; the card loses its power."""
    return Faults(bounces=bounces(rng, one.board.time))


def slow_sheets(rng: Rng, one: Logger) -> Faults:
    """The same, and the card is slow to identify itself."""
    latency = float(rng.uniform(1e-3, 0.15))
    return Faults(bounces=bounces(rng, one.board.time), sheet_latency=latency)


def bad_replies(rng: Rng, one: Logger) -> Faults:
    """The same, and commands fail."""
    bad = [
        BadReply(int(rng.choice(COMMANDS)), int(rng.integers(0, 6)), int(rng.choice(REPLIES)))
        for _ in range(rng.integers(1, 6))
    ]
    return Faults(bounces=bounces(rng, one.board.time), bad_replies=bad)


def loosens(rng: Rng, one: Logger) -> Faults:
    """The card goes and comes, and its CSD cannot be read at once: scans find no room."""
    start = one.board.time + float(rng.uniform(0.1, 1.5))
    gap = (start, start + float(rng.uniform(2e-3, 30e-3)))
    bad = [BadReply(9, nth, 0xFF) for nth in range(int(rng.integers(1, 3)))]
    return Faults(bounces=[gap], bad_replies=bad)


def no_checks(rng: Rng, one: Logger) -> Faults:
    """The same, with a card that checks nothing."""
    return Faults(bounces=bounces(rng, one.board.time), ignores_crc=True)


def stalls(rng: Rng, one: Logger) -> Faults:
    """The card is busy for long."""
    first = one.board.counters().card_writes
    writes = first + rng.integers(0, 12, rng.integers(1, 5))
    return Faults(stalls={int(write): float(rng.uniform(0.05, 0.9)) for write in writes})


def waits(rng: Rng, one: Logger) -> Faults:
    """The same, and the program waits for something meanwhile: scans are skipped."""
    starts = one.board.time + rng.uniform(0.0, 3.0, rng.integers(10, 40))
    holds = [(float(start), float(start + rng.uniform(2e-3, 60e-3))) for start in starts]
    return replace(stalls(rng, one), holds=holds)


def sags(rng: Rng, one: Logger) -> Faults:
    """The sensors' supply sags and recovers, and the card is busy for long."""
    faults = stalls(rng, one)
    for volts in rng.uniform(2.6, 3.6, rng.integers(1, 5)):
        one.board.reference_volts = float(volts)
        one.run(float(rng.uniform(0.05, 0.5)))
    one.board.reference_volts = 3.3
    return faults


def rejects(rng: Rng, one: Logger) -> Faults:
    """Writes are refused."""
    first = one.board.counters().card_writes
    writes = first + rng.integers(0, 12, rng.integers(1, 6))
    return Faults(rejects={int(w): "crc" if rng.random() < 0.5 else "write" for w in writes})


def cut(rng: Rng, one: Logger) -> Faults:
    """The power fails inside a write."""
    write = one.board.counters().card_writes + int(rng.integers(0, 10))
    tails: tuple[Literal["old", "ones", "noise"], ...] = ("old", "ones", "noise")
    tail = tails[rng.integers(3)]
    return Faults(power_cut=PowerCut(write, int(rng.integers(0, 513)), tail))


def reset(rng: Rng, one: Logger) -> Faults:
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


def fills(rng: Rng, one: Logger) -> Faults:
    """A file is full, and the controller may start anew before the next one is there."""
    one.until(lambda: bool(told := one.acknowledgements()) and told[-1].blocks >= 58, 30.0)
    one.run(float(rng.uniform(0.0, 0.7)))
    if rng.random() < 0.7:
        one.board.reset("external" if rng.random() < 0.5 else "brown-out")
    return Faults()


CAUSES: dict[str, Callable[[Rng, Logger], Faults]] = {
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
}


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


def trial(seed: int, folder: Path, elf: Path = ELF, small: Path = SMALL) -> Outcome:
    """One session with one fault; the seed chooses everything."""
    rng = np.random.default_rng(seed)
    cause = list(CAUSES)[seed % len(CAUSES)]
    outcome = Outcome(cause)
    rate = (100, 200, 400)[rng.integers(3)]
    stream = "on" if rng.random() < 0.5 else "off"
    path = folder / f"{seed}.img"
    card = CardImage.fat16(path) if rng.random() < 0.3 else CardImage.fat32(path)
    configure(card, f"size_mb = 1\nrate = {rate}\nstream = {stream}\n")
    signals = from_array(inputs(rng), TABLE_HZ, repeat=True)
    loader = (None, *LOADERS.values())[rng.integers(1 + len(LOADERS))]
    program = small if cause == "full files" else elf
    with Logger(program, card, signals=signals, trace=True, boot_loader=loader) as one:
        one.boot()
        if not one.command("start").ok:
            outcome.wrong.append("does not start")
            return outcome
        one.run(float(rng.uniform(0.2, 1.0)))
        faults = CAUSES[cause](rng, one)
        one.board.faults = faults
        one.run(3.0)
        one.board.faults = Faults()
        was_off = one.board.state != "running"
        if was_off:
            one.board.power_on()
        one.run(2.5)
        goes_on = one.command("status", 30.0).values["state"] == "recording"
        if goes_on == was_off:
            outcome.wrong.append("goes on by itself" if goes_on else "does not go on")
        one.command("stop", 30.0)
        if not one.command("start", 30.0).ok:  # closes what is open
            outcome.wrong.append("does not start again")
        one.command("stop", 30.0)
        runs = runs_of(one.board.trace())
        began = {
            int(frame.text[8:], 16): frame.time_s
            for frame in one.frames
            if frame.kind == "H" and frame.text.startswith("session=")
        }
        safe = {}
        for frame in one.frames:
            if frame.kind == "B":
                told = acknowledgement(frame)
                safe[told.session] = told
    starts = np.array([run["cycle"][0] for run in runs]) / 16e6
    logs = {}
    for name in card.files():
        if name.endswith(".HOP") and (log := read_log(card.read(name))) is not None:
            logs[log.session] = log
            check(outcome, log, runs[int(np.searchsorted(starts, began[log.session])) - 1])
    for session, told in safe.items():
        outcome.acknowledged += told.written
        there = {block.number for block in logs[session].blocks} if session in logs else set()
        if missing := set(range(told.blocks)) - there:
            outcome.wrong.append(f"{len(missing)} acknowledged blocks are not in the file")
        elif len(logs[session].scans) < told.written:
            outcome.wrong.append(f"{told.written} scans acknowledged, fewer in the file")
    if damage := faults_of(card):
        outcome.wrong.append(f"file system: {damage[0]}")
    path.unlink()
    return outcome


def table(outcomes: list[Outcome]) -> str:
    """Figures by cause, and of all."""
    rows = [f"{'cause':18}{'trials':>8}{'decoded':>10}{'acknowledged':>14}{'lost':>8}{'wrong':>7}"]
    for cause in (*CAUSES, "all"):
        mine = [outcome for outcome in outcomes if cause in (outcome.cause, "all")]
        decoded, safe, lost = (
            sum(getattr(outcome, key) for outcome in mine)
            for key in ("decoded", "acknowledged", "lost")
        )
        wrong = sum(bool(outcome.wrong) for outcome in mine)
        rows.append(f"{cause:18}{len(mine):>8}{decoded:>10}{safe:>14}{lost:>8}{wrong:>7}")
    return "\n".join(rows)


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
                print(f"seed {seed}, {outcomes[-1].cause}: {text}", flush=True)
            print(f"\r{len(outcomes)} of {options.seeds}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    print(table(outcomes))
    return 1 if any(outcome.wrong for outcome in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
