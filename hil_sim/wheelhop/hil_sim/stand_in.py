"""A logger for programs that expect one at a port: the real firmware, or its double."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Thread

from wheelhop.hil_sim.board import Board
from wheelhop.hil_sim.card import CardImage
from wheelhop.hil_sim.double import SerialDouble
from wheelhop.hil_sim.program import SimulationError
from wheelhop.hil_sim.signals import Signals
from wheelhop.hil_sim.terminal import Terminal

FACTOR = 10.0  # the double's speed
TURN_S = 0.05  # of board time between two looks at how fast it is to run
POLL_S = 0.01
TCP = 0  # any free port: pseudo-terminals are not everywhere


@dataclass(frozen=True)
class StandIn:
    """A logger at `url`; `of` is what it lives in, and keeps its time.

    A board runs in real time, and as fast as it can while somebody waits; the double, `FACTOR`
    times as fast always.
    """

    url: str
    of: Board | SerialDouble
    hurry: Event
    stopped: Event

    def wait(self, seconds: float) -> None:
        """Let so much of its time pass. Raises SimulationError if it stops meanwhile."""
        end = self._now() + seconds
        self.hurry.set()
        while self._now() < end:
            if self.stopped.is_set():
                raise SimulationError("the simulated board has stopped")
            time.sleep(POLL_S)
        self.hurry.clear()

    def _now(self) -> float:
        return self.of.time if isinstance(self.of, Board) else self.of.time_s


@contextmanager
def stand_in(signals: Signals, folder: Path, elf: Path | None = None) -> Iterator[StandIn]:
    """Make a logger whose sensors put out `signals`, and whose card is kept in `folder`.

    With `elf` it is that firmware on the simulated board, else the double. Raises SimulationError.
    """
    hurry, stopped = Event(), Event()
    if elf is None:
        with SerialDouble(signals, folder, factor=FACTOR, port=TCP) as double:
            yield StandIn(double.url, double, hurry, stopped)
        return
    image = CardImage.fat32(folder / "card.img")
    with Board(elf, image, signals) as board, Terminal(board) as terminal:
        closing = Event()

        def serve() -> None:
            try:
                while not closing.is_set() and board.state == "running":
                    terminal.serve(TURN_S, paced=not hurry.is_set())
            finally:
                stopped.set()

        thread = Thread(target=serve, daemon=True, name="simulated board")
        thread.start()
        try:
            yield StandIn(terminal.path, board, hurry, stopped)
        finally:
            closing.set()
            thread.join()
