"""Two loggers to ask the same of: the double, and the firmware on a simulated board."""

from threading import Lock

import numpy as np

from tests.firmware.promises.conftest import SMALL
from tests.firmware.promises.logger import configure
from tests.patience import wait_until
from wheelhop.hil_sim import Board, CardImage, constant
from wheelhop.hil_sim.double import SerialDouble
from wheelhop.logger.link import Link
from wheelhop.logger.port import SerialPort

CODES = np.array([100.0, 200, 300, 400, 600, 700, 800, 1000])
FACTOR = 8.0


class DoubleBench:
    """The double on a pseudo-terminal, faster than real time."""

    def __init__(self, folder):
        self._card = folder / "card"
        self._double = SerialDouble(constant(CODES), self._card, factor=FACTOR)
        self.link = Link(SerialPort(self._double.url))

    def run(self, seconds):
        end = self._double.time_s + seconds
        wait_until(lambda: self._double.time_s >= end)

    def press_button(self):
        self._double.press_button()

    def read(self, name):
        return (self._card / name).read_bytes()

    def end(self):
        self.link.close()
        self._double.close()


class BoardBench:
    """The simulated board, as a port: reading lets its time go on."""

    name = "simulated board"

    def __init__(self, folder, elf):
        self._card = configure(CardImage.fat32(folder / "card.img"), SMALL.replace("on", "off"))
        self._board = Board(elf, self._card, constant(CODES))
        self._lock = Lock()
        self.link = Link(self)

    def read(self, name=None):
        if name:  # a file of the card's
            return self._card.read(name)
        with self._lock:
            self._board.run(20e-3)
            return self._board.serial.read()

    def write(self, data):
        with self._lock:
            self._board.serial.write(data)

    def run(self, seconds):
        end = self._board.time + seconds
        wait_until(lambda: self._board.time >= end)

    def press_button(self):
        with self._lock:
            self._board.press_button()

    def close(self):
        """As a port it has nothing to give back."""

    def end(self):
        self.link.close()
        self._board.close()
