"""The double as one object: a device, its clock, and the line to it."""

import time
from collections.abc import Sequence
from math import inf
from pathlib import Path
from threading import Event, Lock, Thread

from wheelhop.files.closing import Closing
from wheelhop.hil_sim.double.card import Card
from wheelhop.hil_sim.double.device import Device
from wheelhop.hil_sim.double.doors import Door, PtyDoor, TcpDoor
from wheelhop.hil_sim.double.faults import DoubleFaults
from wheelhop.hil_sim.double.kind import IN_TURN, Kind
from wheelhop.hil_sim.double.wire import Wire
from wheelhop.hil_sim.signals import Signals, sines

POLL_S = 2e-3  # of the computer's time
LONGEST_TURN_S = 5 * POLL_S  # of the computer's time that one turn lasts where time may stand still


class SerialDouble(Closing):
    """A logger in Python, to be used in a `with` statement; a program opens its `url`.

    `signals` are the sensors (sines of 1 to 8 Hz if not given), `acts` those of the first session,
    the second and so on where they differ, `card` a folder for log files,
    None: no card. Its time is real time, or `factor` times faster; `clock_ppm` is the error of its
    clock: positive, its seconds are too long. It is on a pseudo-terminal, under the name `link` if
    given, or on TCP if `port` is given (0: any that is free).

    In real time it makes up for what a busy computer has kept from it. At any other `factor` it
    does not: its time stands still then, so that a slow computer slows it down, too.
    """

    def __init__(
        self,
        signals: Signals | None = None,
        card: Path | str | None = None,
        faults: DoubleFaults | None = None,
        *,
        factor: float = 1.0,
        clock_ppm: float = 0.0,
        port: int | None = None,
        link: Path | None = None,
        acts: Sequence[Signals] = (),
        kind: Kind = IN_TURN,
    ) -> None:
        self._faults = faults or DoubleFaults()
        one_to_eight = sines(range(1, 9), seconds=1.0, rate_hz=3200.0)
        folder = None if card is None else Card(Path(card))
        shown = signals or _repeated(one_to_eight)
        self._device = Device(shown, folder, self._faults, acts, kind)
        self._door: Door = PtyDoor(link) if port is None else TcpDoor(port)
        self._speed = factor / (1 + clock_ppm * 1e-6)
        self._longest_turn_s = inf if factor == 1.0 else LONGEST_TURN_S
        self._to_host, self._from_host = Wire(self._faults, 0), Wire(self._faults, 1)
        self._torn_until_s = 0.0
        self._closing = Event()
        self._lock = Lock()
        self._thread = Thread(target=self._serve, daemon=True, name="serial double")
        self._thread.start()

    @property
    def url(self) -> str:
        """The port to open."""
        return self._door.url

    @property
    def time_s(self) -> float:
        """The double's own time since its start."""
        return self._device.time_s

    @property
    def totals(self) -> dict[str, int]:
        """Scans due, written and lost of the running or the last session, as on the card."""
        with self._lock:
            session = self._device.session
            if session is None:
                return {}
            memory = session.memory
            return {"due": memory.due, "written": session.written, "lost": memory.lost}

    def press_button(self) -> None:
        """Start or stop a session."""
        with self._lock:
            self._device.press_button()

    def reset(self, cause: str = "external") -> None:
        """Restart the logger."""
        with self._lock:
            self._device.reset(cause)

    def tear(self, seconds: float) -> None:
        """Take the line away for so much of the double's time."""
        with self._lock:
            self._torn_until_s = self._device.time_s + seconds

    def close(self) -> None:
        """Switch it off."""
        self._closing.set()
        self._thread.join()
        self._door.close()

    def _serve(self) -> None:
        looked_s, now_s = time.monotonic(), 0.0
        joined = True
        while not self._closing.is_set():
            turn_s = time.monotonic() - looked_s
            looked_s += turn_s
            now_s += min(turn_s, self._longest_turn_s) * self._speed
            torn = now_s < self._torn_until_s or any(
                at <= now_s < at + for_s for at, for_s in self._faults.disconnects
            )
            if joined == torn:
                self._door.tear() if torn else self._door.join()
                joined = not torn
            came = b""
            if joined:
                came = self._door.read(POLL_S)
            else:
                time.sleep(POLL_S)
            with self._lock:
                self._device.receive(self._from_host.carry(came))
                sent = self._device.run(now_s)
            if joined:
                self._door.write(self._to_host.carry(sent))


def _repeated(signals: Signals) -> Signals:
    return Signals(signals.codes[:-1], signals.rate_hz, repeat=True)
