"""`python -m wheelhop.hil_sim firmware.elf`: the simulated board on a pseudo-terminal."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from wheelhop.hil_sim.board import Board
from wheelhop.hil_sim.card import CardImage
from wheelhop.hil_sim.faults import Faults
from wheelhop.hil_sim.program import SimulationError
from wheelhop.hil_sim.signals import CHANNELS, Signals, from_volts, sines
from wheelhop.hil_sim.terminal import Terminal

BAD_INPUT, INTERRUPTED, STOPPED = 2, 130, 1


def main(argv: Sequence[str] | None = None) -> int:
    """Run the board until it stops, the time is over, or Ctrl-C."""
    arguments = _parser().parse_args(argv)
    try:
        return _serve(arguments)
    except SimulationError as error:
        print(f"wheelhop.hil_sim: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m wheelhop.hil_sim", description=__doc__)
    add = parser.add_argument
    add("elf", type=Path, help="the firmware, build/firmware/nano/firmware.elf")
    add("--card", type=Path, help="image of the SD card; made, with FAT32, if there is none")
    add("--signals", type=Path, help="CSV: time in seconds in equal steps, and eight voltages")
    add("--reference", type=float, default=3.3, metavar="V", help="voltage at AREF (3.3)")
    add("--seconds", type=float, help="board time after which to end")
    add("--button", type=float, action="append", default=[], metavar="S", help="press at this time")
    add("--stall", action="append", default=[], metavar="WRITE:MS", help="let the card stall")
    add("--fast", action="store_true", help="as fast as possible instead of in real time")
    return parser


def _serve(arguments: argparse.Namespace) -> int:
    signals = _signals(arguments.signals, arguments.reference)
    if arguments.card and not arguments.card.exists():
        CardImage.fat32(arguments.card)
    faults = Faults(stalls=dict(_stall(text) for text in arguments.stall))
    with (
        Board(
            arguments.elf,
            arguments.card,
            signals,
            faults,
            reference_volts=arguments.reference,
        ) as board,
        Terminal(board) as terminal,
    ):
        print(f"serial port {terminal.path}", flush=True)
        for moment in sorted(arguments.button):
            terminal.serve(max(moment - board.time, 0.0), paced=not arguments.fast)
            board.press_button()
        rest = None if arguments.seconds is None else arguments.seconds - board.time
        terminal.serve(rest, paced=not arguments.fast)
        print(f"{board.state} at {board.time:.3f} s, {board.stack_left()} bytes of stack untouched")
        return 0 if board.state in ("running", "off") else STOPPED


def _stall(text: str) -> tuple[int, float]:
    try:
        write, milliseconds = text.split(":")
        return int(write), float(milliseconds) / 1000
    except ValueError:
        raise SimulationError(f"--stall {text}: write it as 120:250") from None


def _signals(path: Path | None, reference_volts: float) -> Signals:
    if path is None:
        return sines(np.arange(1, CHANNELS + 1), seconds=1.0)
    try:
        with path.open(encoding="utf-8") as file:
            table = np.loadtxt(file, delimiter=",", ndmin=2, comments="#")
    except OSError as error:
        raise SimulationError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise SimulationError(f"{path}: {str(error).splitlines()[0]}") from None
    if table.shape[1] != CHANNELS + 1 or len(table) < 2:
        raise SimulationError(
            f"{path}: {table.shape[1]} columns and {len(table)} rows; "
            f"it takes time and {CHANNELS} voltages, and two rows or more"
        )
    steps = np.diff(table[:, 0])
    if steps[0] <= 0 or not np.allclose(steps, steps[0], rtol=1e-3):
        raise SimulationError(f"{path}: the times in the first column are not in equal steps")
    return from_volts(table[:, 1:], 1 / steps.mean(), reference_volts=reference_volts)


if __name__ == "__main__":
    sys.exit(main())
