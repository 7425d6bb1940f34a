"""Print what the firmware uses of the ATmega328P, its memory on the ATmega2560, and fail if it is
more than it may.

    python tools/firmware_budget.py

Flash, static RAM and the deepest chain of calls are read from the ELF; the rest is measured on
the simulated board (hil_sim/README.md), in a life with everything that goes deep: no card, a card
with a HOP.CFG and a session to be closed, streaming, commands, a stall, a download.
"""

import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import firmware_stack

from wheelhop.hil_sim import Board, CardImage, Faults, SimulationError, ramp

ROOT = Path(__file__).resolve().parents[1]
ELF = ROOT / "build/firmware/nano/firmware.elf"
MEGA_ELF = ROOT / "build/firmware/mega/firmware.elf"
CPU_HZ = 16_000_000
ADC_VECTOR = 21
CONFIG = b"# budget\nname = budget\nsize_mb = 1\nstream = on\nnonsense\n"


@dataclass(frozen=True)
class Line:
    """One line of the table; `within` says whether the budget is kept."""

    name: str
    value: str
    budget: str
    within: bool


@dataclass(frozen=True)
class Limits:
    """What a board may use, in bytes, and what its lines begin with."""

    name: str
    chip: firmware_stack.Chip
    flash: int
    ram: int


# Of the Nano's flash the old boot loader leaves 30720 B: a kilobyte is kept for what comes next.
NANO = Limits("", firmware_stack.ATMEGA328P, 30720 - 1024, 1510)
MEGA = Limits("Mega: ", firmware_stack.ATMEGA2560, 253952, 7500)
STACK = 300  # bytes that the deepest calls and the largest interrupt leave


def sections(elf: Path) -> dict[str, int]:
    """Return the sizes of the ELF's sections in bytes."""
    done = subprocess.run(["avr-size", "-A", str(elf)], capture_output=True, text=True, check=True)
    rows = [line.split() for line in done.stdout.splitlines() if line.startswith(".")]
    return {row[0]: int(row[1]) for row in rows}


def memory(elf: Path, limits: Limits) -> list[Line]:
    """Flash, static RAM and stack."""
    size = sections(elf)
    flash = size[".text"] + size[".data"]
    static = size[".data"] + size[".bss"] + size.get(".noinit", 0)
    left, _ = firmware_stack.bound(elf, limits.chip)
    name, most, ram = limits.name, limits.flash, limits.ram
    return [
        Line(f"{name}flash", f"{flash} B", f"≤ {most} B", flash <= most),
        Line(f"{name}static RAM", f"{static} B", f"≤ {ram} B", static <= ram),
        Line(f"{name}RAM left by the deepest calls", f"{left} B", f"≥ {STACK} B", left >= STACK),
    ]


def command(board: Board, line: bytes, seconds: float) -> bytes:
    """Send a command, let time pass, return what the board has sent."""
    board.serial.write(line + b"\n")
    board.run(seconds)
    return board.serial.read()


def download(board: Board, name: str, size: int) -> float:
    """Bytes per second that `get` brings to the host of a file of `size` bytes."""
    command(board, b"stream off", 1)
    board.serial.write(f"get {name} 0 65535\n".encode())
    board.run(2)
    times, _ = board.serial.read_timed()
    return size / (times[-1] - times[0])


def life(folder: Path) -> list[Line]:
    """Stack, time and throughput on the simulated board."""
    card = CardImage.fat32(folder / "card.img", partitioned=True)
    card.write("HOP.CFG", CONFIG)
    with Board(ELF, card, ramp(100, 10)) as board:
        board.run(1)
        command(board, b"start", 2)
        left = board.stack_left()
        board.cut_power()
        board.insert(None)
        board.power_on()
        command(board, b"start", 3)
        board.insert(card)
        command(board, b"start", 4)
        command(board, b"status", 1)
        command(board, b"stop", 2)
        left = min(left, board.stack_left())
    card = CardImage.fat32(folder / "again.img")
    card.write("HOP.CFG", CONFIG)
    with Board(ELF, card, ramp(100, 10), trace=True) as board:
        board.run(1)
        command(board, b"start", 2)
        board.trace()
        before, since = board.counters(), board.time
        sent = len(command(board, b"status", 10))
        after, seconds = board.counters(), board.time - since
        trace = board.trace()
        board.faults = Faults(stalls={after.card_writes: 0.6})
        survived = b"lost=0" in command(board, b"stop", 4)
        fetched = download(board, "HOP00001.HOP", card.files()["HOP00001.HOP"])
    spans = trace.interrupts(ADC_VECTOR)
    longest = int((spans[:, 1] - spans[:, 0]).max())
    idle = (after.idle_cycles - before.idle_cycles) / (seconds * CPU_HZ)
    written = 512 * (after.card_writes - before.card_writes) / seconds
    return [
        Line("RAM never touched", f"{left} B", f"≥ {STACK} B", left >= STACK),
        Line(
            "sampling jitter",
            f"{trace.conversion_jitter()} cycles",
            "0",
            not trace.conversion_jitter(),
        ),
        Line("converter's interrupt", f"≤ {longest} cycles", "≤ 600", longest <= 600),
        Line("CPU idle, recording and streaming", f"{idle:.0%}", "≥ 30%", idle >= 0.3),
        Line("to the card", f"{written:.0f} B/s", "", True),
        Line(
            "to the serial line", f"{sent / seconds:.0f} B/s", "≤ 50000 B/s", sent / seconds < 5e4
        ),
        Line("download", f"{fetched:.0f} B/s", "", True),
        Line("stall of 600 ms", "nothing lost" if survived else "scans lost", "", survived),
    ]


def main() -> int:
    """Print the table; return 1 if a budget is exceeded."""
    subprocess.run(
        [ROOT / "tools/build_firmware.sh", "nano", "mega"], check=True, stdout=sys.stderr
    )
    lines = memory(ELF, NANO) + memory(MEGA_ELF, MEGA)
    try:
        with tempfile.TemporaryDirectory() as folder:
            lines += life(Path(folder))
    except SimulationError as error:
        print(f"firmware_budget: not measured on the simulated board: {error}", file=sys.stderr)
    for line in lines:
        mark = "" if line.within else "  EXCEEDED"
        print(f"{line.name:36}{line.value:20}{line.budget:14}{mark}".rstrip())
    return 0 if all(line.within for line in lines) else 1


if __name__ == "__main__":
    sys.exit(main())
