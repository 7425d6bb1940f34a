"""The real firmware on a simulated board: AVR, eight inputs, SD card, button, serial line.

    with Board("firmware.elf", card=CardImage.fat32("card.img"), signals=ramp(0, 10)) as board:
        board.press_button()
        board.run(10.0)
        print(board.serial.read(), board.stack_left())

Time is virtual and the same inputs give the same bytes. `python -m wheelhop.hil_sim` offers the
board on a pseudo-terminal. It runs on Linux and macOS, needs a C compiler, simavr and libelf, and
is part of the source tree only: the wheel does not contain it.
"""

from wheelhop.hil_sim.board import Board, Counters, Serial, Write
from wheelhop.hil_sim.card import CardImage
from wheelhop.hil_sim.faults import BadReply, Faults, PowerCut
from wheelhop.hil_sim.program import SimulationError
from wheelhop.hil_sim.signals import Signals, constant, from_array, from_volts, ramp, sines
from wheelhop.hil_sim.trace import Event, Trace

__all__ = [
    "BadReply",
    "Board",
    "CardImage",
    "Counters",
    "Event",
    "Faults",
    "PowerCut",
    "Serial",
    "Signals",
    "SimulationError",
    "Trace",
    "Write",
    "constant",
    "from_array",
    "from_volts",
    "ramp",
    "sines",
]
