"""The logger without its line: bytes in, bytes out, in time of its own."""

from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.hil_sim.double.card import Card
from wheelhop.hil_sim.double.commands import Line
from wheelhop.hil_sim.double.console import Answer, Console, Payload
from wheelhop.hil_sim.double.faults import DoubleFaults
from wheelhop.hil_sim.double.kind import IN_TURN, Kind
from wheelhop.hil_sim.double.scans import ScanSource
from wheelhop.hil_sim.double.session import Session
from wheelhop.hil_sim.double.settings import Refusal, Settings
from wheelhop.hil_sim.signals import Signals
from wheelhop.logger.block import pack_scans
from wheelhop.logger.frames import pack_acknowledgement, pack_frame, pack_scan_frame
from wheelhop.logger.settings import CODE_BITS

STEP_S = 2.5e-3  # a scan at the highest rate
BYTE_S = 10 / 500_000
WATCHDOG_S = 0.25
SUPPLY_EVERY = 32  # scans


class Device:
    """Firmware, converter and card. `time_s` is its own clock, `run` lets it go on.

    `acts`, if any, are what the sensors put out in the first session, the second and so on, each
    from its beginning; the last one also in all that follow.
    `card` None: there is none in the socket. The same arguments and bytes give the same bytes.
    `kind` says which board it is. `session` is the running or the last session since the logger
    has started.
    """

    def __init__(
        self,
        signals: Signals,
        card: Card | None,
        faults: DoubleFaults,
        acts: Sequence[Signals] = (),
        kind: Kind = IN_TURN,
    ) -> None:
        self.signals, self.card, self.faults, self.acts = signals, card, faults, acts
        self.random = np.random.default_rng([faults.seed, 2])
        self.time_s = 0.0
        self.settings = Settings(kind=kind)
        self.session_number = 0
        self._resets = deque(sorted(faults.resets))
        self._out = bytearray()
        self.reset("power")

    @property
    def running(self) -> bool:
        """Whether a session runs."""
        return self.session is not None and self.session.running

    def reset(self, cause: str = "external") -> None:
        """Restart, as a reset or a power failure does."""
        session = getattr(self, "session", None)
        self.interrupted = session.id if session and session.running and cause != "power" else 0
        self.settings = self.settings.after_reset()
        self.session: Session | None = None
        self.cause, self.started_s = cause, self.time_s
        self.self_test = False
        self.due = 0  # scans since sampling began
        self._source: ScanSource | None = None
        self._counter = 0
        self._free_s = self._ready_s = self.time_s  # when the line is, and when the reply
        self._scan: bytes | None = None  # a D frame that waits for the line
        self._acknowledge = self._pressed = self._hanging = False
        self._line = Line()
        self._command: bytes | None = None  # a line that waits, or is being answered
        self._asked = False  # whether the answer under way is to a command
        self._console = Console(self)
        self._answer: Answer | None = self._console.greet()

    def press_button(self) -> None:
        """Start or stop, when the reply under way is complete."""
        self._pressed = True

    def bite(self) -> None:
        """Let the watchdog restart it soon; until then it does nothing."""
        self._hanging = True
        self._resets.appendleft(self.time_s + WATCHDOG_S)

    def receive(self, data: bytes) -> None:
        """Take bytes from the host. Lines that come before a command is answered are lost."""
        for byte in data:
            line = self._line.push(byte)
            if line is not None and self._command is None and not self._hanging:
                self._command = line

    def run(self, until_s: float) -> bytes:
        """Go on to a moment; what was sent meanwhile."""
        self._out.clear()
        while self.time_s < until_s:
            self.time_s = min(self.time_s + STEP_S, until_s)
            if self._resets and self._resets[0] <= self.time_s:
                self._resets.popleft()
                self.reset("watchdog")
            self._sample()
            if self.running and self.session and self.session.poll(self.time_s):
                self._acknowledge = True
            if self._answer is None:
                self._answer = self._next_answer()
            self._send()
        return bytes(self._out)

    def sample(self) -> None:
        """Begin anew at scan 0, or stop, as session and settings want it."""
        self._source, self.due = None, 0
        self.self_test = False
        if self.running or self.settings.stream:
            signals, start_s = self.signals, self.time_s
            if self.running and self.acts:
                signals, start_s = self.acts[min(self.session_number, len(self.acts)) - 1], 0.0
            self._source = ScanSource(signals, self.settings, start_s)
            self._sampled_from_s = self.time_s

    def stop_sampling(self) -> None:
        """No more scans."""
        self._source = None

    def _next_answer(self) -> Answer | None:
        """What the firmware's main loop turns to."""
        self._asked = self._command is not None
        if self._command is not None:
            self._ready_s = self.time_s + self.faults.reply_delay_s
            return self._console.answer(self._command)
        if self.running and self.session and self.session.full:
            return self._console.roll_over()
        if self._pressed:
            self._pressed = False
            return self._console.stop("button") if self.running else self._console.start()
        return None

    def _sample(self) -> None:
        rate_hz = self.settings.rate_hz
        while self._source and self.time_s >= self._sampled_from_s + (self.due + 1) / rate_hz:
            scan, self.due = self.due, self.due + 1
            sums = self._sums(scan)[None, self.settings.recorded]
            stored = pack_scans(sums, self.settings.kind.sum_bits)
            session = self.session if self.running else None
            if session and not any(scan in gone for gone in self.faults.lost):
                session.memory.add(scan, stored)
            if session and scan % SUPPLY_EVERY == SUPPLY_EVERY // 2:
                session.read_supply(scan, self.faults.supply_mv(self.time_s))
            if self.settings.stream:
                if self._scan and session:
                    session.unsent += 1
                self._scan = pack_scan_frame(session.id if session else 0, scan, stored)

    def _sums(self, scan: int) -> NDArray[np.int64]:
        """The (8,) sums of a scan, the sensors' self-test among them."""
        assert self._source is not None
        sums = self._source.take(scan)
        if self.self_test:
            kind = self.settings.kind
            shift = np.array(self.faults.self_test) * 2 ** (kind.code_bits - CODE_BITS)
            moved = np.floor(sums + self.settings.conversions * shift).astype(np.int64)
            sums = np.clip(moved, 0, self.settings.conversions * (2**kind.code_bits - 1))
        return sums

    def _send(self) -> None:
        """Scans first, then acknowledgements, then the console's frames, while the line is free."""
        while self._free_s <= self.time_s and (payload := self._next_payload()):
            frame = pack_frame(payload[0], self._counter, payload[1])
            self._counter += 1
            self._free_s = max(self._free_s, self.time_s - STEP_S) + len(frame) * BYTE_S
            self._out += frame

    def _next_payload(self) -> Payload | None:
        if self._scan:
            scan, self._scan = self._scan, None
            return ("D", scan)
        if self._acknowledge and self.session:
            self._acknowledge = False
            return ("B", pack_acknowledgement(self.session.acknowledgement()))
        if self._answer is None or self.time_s < self._ready_s:
            return None
        try:
            payload = next(self._answer)
            if payload is None or payload[0] != "K":
                return payload
        except StopIteration:
            payload = None
        except Refusal as refusal:  # of what nobody has asked for: a message
            payload = ("E" if self._asked else "M", str(refusal).encode())
        self._answer = None
        if self._asked:
            self._command = None
        return payload
