"""How long may a card be busy before scans are lost, at each rate and on each board?

    python -m benchmarks.logger_room

Sessions of the real firmware on the simulated board (hil_sim/README.md), each with one stall of the
card; the longest without loss is found by halving, to 5 ms. Then what static data and stack leave
of each board's RAM, read from the machine code, and what more blocks of memory would hold. Last,
what a power cut at the end of a stall of 600 ms costs.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from wheelhop.hil_sim import Board, CardImage, Faults, constant
from wheelhop.logger import read_log
from wheelhop.logger.block import BLOCK_BYTES, scans_per_block

ROOT = Path(__file__).resolve().parents[1]
RAM = {"nano": 2048, "mega": 8192}
RING = {"nano": 2, "mega": 8}  # blocks that the firmware keeps: firmware/lib/ring
BUILDS = (("nano", 8), ("nano", 4), ("nano", 2), ("mega", 8))
RATES = (100, 200, 400)
NAMES = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
LONGEST_S, STEP_S = 3.2, 0.005
SRAM_23LC1024 = 131072  # bytes
STACK = {"nano": 292, "mega": 313}  # deepest chain of calls: tools/firmware_budget.py


def elf_of(board: str) -> Path:
    """The firmware that tools/build_firmware.sh makes."""
    return ROOT / f"build/firmware/{board}/firmware.elf"


def command(board: Board, line: str, done: bytes = b"K") -> None:
    """Send a line and wait for its reply."""
    board.serial.read()
    board.serial.write(line.encode() + b"\n")
    if not board.run_until(lambda: done in board.serial.read(), 20.0, 0.02):
        raise RuntimeError(f"{line}: no answer")


def session(
    folder: Path,
    build: str,
    channels: int,
    rate_hz: int,
    stall_s: float,
    cut_s: float | None = None,
) -> tuple[int, int]:
    """Record with one stall; return scans due and scans in the file.

    With `cut_s` the power fails so long after the stall began, and due is what was sampled by then.
    """
    card = CardImage.fat32(folder / "card.img")
    names = " ".join((*NAMES[:channels], *["-"] * (8 - channels)))
    settings = f"size_mb = 1\nstream = on\nrate = {rate_hz}\nchannels = {names}\n"
    card.write("HOP.CFG", settings.encode())
    with Board(elf_of(build), card, constant(512.5)) as board:
        board.run(1.0)
        command(board, "start")
        start_s, writes = board.time, board.counters().card_writes
        board.faults = Faults(stalls={writes + 2: stall_s})
        if cut_s is None:
            board.run(stall_s + 4 * scans_per_block(channels) / rate_hz)
            command(board, "stop")
            log = read_log(folder_file(card, folder))
            return log.due, log.written
        board.run_until(lambda: board.counters().card_writes == writes + 3, 10.0)
        board.run(cut_s)
        due = round((board.time - start_s) * rate_hz)
        board.cut_power()
    return due, read_log(folder_file(card, folder)).written


def folder_file(card: CardImage, folder: Path) -> Path:
    """The card's last log as a file of its own."""
    name = max(name for name in card.files() if name.endswith(".HOP"))
    (folder / name).write_bytes(card.read(name))
    return folder / name


def longest_stall(folder: Path, build: str, channels: int, rate_hz: int) -> float:
    """Seconds that one write may take without loss."""
    survived, lost = 0.0, LONGEST_S
    while lost - survived > STEP_S:
        stall = (survived + lost) / 2
        due, written = session(folder, build, channels, rate_hz, stall)
        survived, lost = (stall, lost) if due == written else (survived, stall)
    return survived


def static_ram(build: str) -> int:
    """Bytes of RAM with a fixed place."""
    sizes = subprocess.run(
        ["avr-size", "-A", str(elf_of(build))], capture_output=True, text=True, check=True
    ).stdout
    rows = [line.split() for line in sizes.splitlines()]
    return sum(int(row[1]) for row in rows if row and row[0] in {".data", ".bss", ".noinit"})


def main() -> None:
    """Measure and print."""
    subprocess.run(
        [ROOT / "tools/build_firmware.sh", "nano", "mega"], check=True, stdout=sys.stderr
    )
    print("longest stall of the card without loss, ms")
    print(f"{'board':<8}{'channels':>9}" + "".join(f"{rate:>8} Hz" for rate in RATES))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for build, channels in BUILDS:
            stalls = [longest_stall(folder, build, channels, rate) for rate in RATES]
            cells = "".join(f"{1000 * stall:>11.0f}" for stall in stalls)
            print(f"{build:<8}{channels:>9}{cells}", flush=True)
        print("\nmemory, and what it would hold of eight channels if the firmware used it")
        scans = scans_per_block(8)
        for build, size in RAM.items():
            free = size - static_ram(build) - STACK[build] - 300
            blocks = RING[build] + max(free, 0) // BLOCK_BYTES
            report(build, f"{static_ram(build)} B static", blocks, scans)
        report("23LC1024", f"{SRAM_23LC1024} B outside", 2 + SRAM_23LC1024 // BLOCK_BYTES, scans)
        print("\npower cut at the end of a stall of 600 ms, eight channels at 100 Hz")
        due, written = session(folder, "nano", 8, 100, 0.6, cut_s=0.595)
        print(f"sampled {due}, in the file {written}, gone {due - written} scans; and")
        print(f"{scans} more if the card had not yet kept the block that it was busy with")


def report(name: str, memory: str, blocks: int, scans: int) -> None:
    """One line of the table of memories."""
    held = "".join(f"{1000 * blocks * scans / rate:>11.0f}" for rate in RATES)
    print(f"{name:<10}{memory:<18}{blocks:>4} blocks{held} ms", flush=True)


if __name__ == "__main__":
    main()
