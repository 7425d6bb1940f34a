"""The board on a pseudo-terminal, for programs that expect a serial port."""

import os
import select
import time
import tty

from wheelhop.files.closing import Closing
from wheelhop.hil_sim.board import Board

STEP = 2e-3  # seconds of board time between two looks at the line


class Terminal(Closing):
    """A pseudo-terminal whose far end, at `path`, stands for the USB port of the board."""

    def __init__(self, board: Board):
        self._board = board
        self._near, self._far = os.openpty()
        tty.setraw(self._far)
        os.set_blocking(self._near, False)
        self.path = os.ttyname(self._far)

    def serve(self, seconds: float | None = None, *, paced: bool = True) -> None:
        """Run the board for `seconds` of its time, or until it stops; `paced`: not faster than so.

        What nobody reads is dropped, as with a real port.
        """
        start, origin = time.monotonic(), self._board.time
        while seconds is None or self._board.time - origin < seconds:
            if select.select([self._near], [], [], 0)[0]:
                self._board.serial.write(os.read(self._near, 4096))
            state = self._board.run(STEP)
            self._forward(self._board.serial.read())
            if state in ("halted", "crashed"):
                return
            if paced:
                ahead = (self._board.time - origin) - (time.monotonic() - start)
                time.sleep(max(ahead, 0.0))

    def _forward(self, data: bytes) -> None:
        try:
            os.write(self._near, data)
        except BlockingIOError:
            return

    def close(self) -> None:
        """Give the terminal back; the board goes on."""
        os.close(self._near)
        os.close(self._far)
