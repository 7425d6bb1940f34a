"""What the double answers, and what it says unasked (SPEC.md, "Serial line")."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping
from typing import TYPE_CHECKING

from wheelhop.hil_sim.double.card import Card, log_name
from wheelhop.hil_sim.double.commands import checked_command
from wheelhop.hil_sim.double.session import Session
from wheelhop.hil_sim.double.settings import LARGEST_TIME, WRONG_VALUE, Refusal, number
from wheelhop.logger.block import BLOCK_BYTES

if TYPE_CHECKING:
    from wheelhop.hil_sim.double.device import Device

PIECE = 44  # bytes of a file in a frame
LARGEST_BLOCK = 8_388_607
NOT_NOW = "not during a session"
NO_CARD = "no card, or it does not answer"
SAMPLED = ("stream", "rate_hz", "channels")  # settings that make sampling begin anew
NO_SUMMARY = (
    *("end", "due", "written", "lost", "late", "stall_ms", "deepest", "room"),
    *("card_errors", "unsent"),
)

Payload = tuple[str, bytes]
"""Type and payload of a frame."""
Answer = Iterator[Payload | None]
"""The frames of a reply, None while there is something to wait for; raises Refusal."""


class Console:
    """The conversation since the last restart."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._epoch_s = 0  # when it was switched on, as a host has told
        self._met = False
        self._continues = 0  # id of the session that the last one goes on with

    def greet(self) -> Answer:
        """Say `ready`; meet the card."""
        yield ("M", b"ready")
        self._meet()
        if self._device.interrupted and self._device.settings.resume:
            yield from self.start(self._device.interrupted)

    def answer(self, line: bytes) -> Answer:
        """Carry out a command."""
        command = checked_command(line)
        done = None
        if command in ("start", "stop"):
            if self._device.running != (command == "start"):
                yield ("L", b"wait")
            yield from self.start() if command == "start" else self.stop("command")
        elif command in ("status", "info"):
            yield from _lines("L", self._status() if command == "status" else self._header())
        elif command in ("stream on", "stream off"):
            self._set(f"stream={command[7:]}", running=False)
        elif command.startswith("test o"):
            if self._device.running:
                raise Refusal(NOT_NOW)
            self._device.self_test = command[6:7] == "n"
        elif command.startswith("set "):
            self._set(command[4:], self._device.running)
        elif command.startswith("time "):
            self._set_time(command[5:])
        elif command == "list":
            files = self._idle_card().files()
            yield from (("L", f"{name} {size}".encode()) for name, size in files.items())
        elif command.startswith("get "):
            done = yield from self._get(command[4:])
        elif command == "reset":
            self._device.bite()
        else:
            raise Refusal("unknown command")
        yield ("K", self._name() if done is None else done)

    def roll_over(self) -> Answer:
        """End a session whose file is full, and go on in the next one."""
        session = self._device.session
        yield from self.stop("full")
        if session and self._device.settings.resume:
            yield from self.start(session.id)

    def start(self, continues: int = 0) -> Answer:
        """Start a session, unless one runs; it may go on with another."""
        device = self._device
        if device.running:
            return
        card = self._meet()
        device.session_number = card.next_number(device.session_number)
        dice = int(device.random.integers(0, 0x10000))
        identity = device.session_number << 16 | dice
        session = Session(card, identity, device.settings, device.faults.stalls)
        self._continues = continues
        header = self._header()
        session.begin(header)
        device.session = session
        device.sample()
        yield ("H", f"session={identity:08X}".encode())
        yield from _lines("H", header)

    def stop(self, end: str) -> Answer:
        """End the session, if one runs, when the card has all of it."""
        device = self._device
        session = device.session
        if session is None or not session.running:
            return
        device.stop_sampling()
        session.memory.finish(device.due)
        while not session.idle:
            session.memory.finish(device.due)
            yield None
        rest = self._rest()
        session.close(end, rest)
        self._continues = 0
        device.sample()
        yield from _lines("S", {**session.summary(), **rest})

    def _set(self, line: str, running: bool) -> None:
        device = self._device
        before, device.settings = device.settings, device.settings.apply(line, running)
        changed = any(getattr(before, key) != getattr(device.settings, key) for key in SAMPLED)
        if changed and not device.running:
            device.sample()

    def _set_time(self, text: str) -> None:
        unix_s = number(text, LARGEST_TIME)
        if unix_s is None:
            raise Refusal(WRONG_VALUE)
        self._epoch_s = unix_s - self._up_s()

    def _get(self, words: str) -> Generator[Payload, None, bytes]:
        """Pieces of a file; returns its size."""
        parts = words.split(" ")
        first = number(parts[1], LARGEST_BLOCK) if len(parts) == 3 else None
        count = number(parts[2], 0xFFFF) if len(parts) == 3 else None
        if first is None or not count:
            raise Refusal(WRONG_VALUE)
        path = self._idle_card().find(parts[0])
        if path is None:
            raise Refusal("no such file")
        data = path.read_bytes()
        for block in range(first, min(first + count, -(-len(data) // BLOCK_BYTES))):
            end = min((block + 1) * BLOCK_BYTES, len(data))
            for at in range(block * BLOCK_BYTES, end, PIECE):
                yield ("F", at.to_bytes(4, "little") + data[at : min(at + PIECE, end)])
        return str(len(data)).encode()

    def _idle_card(self) -> Card:
        if self._device.running:
            raise Refusal(NOT_NOW)
        return self._meet()

    def _meet(self) -> Card:
        """The card; a session that a restart has left open is closed first."""
        device = self._device
        if device.card is None:
            raise Refusal(NO_CARD)
        if not self._met:
            device.card.recover(device.session_number, device.cause)
            self._met = True
        return device.card

    def _name(self) -> bytes:
        session = self._device.session
        return log_name(session.number).encode() if session and session.running else b""

    def _up_s(self) -> int:
        return int(self._device.time_s - self._device.started_s)

    def _header(self) -> dict[str, object]:
        settings = self._device.settings
        return {
            "firmware": "1.4.0",
            "device": settings.device,
            "calibration": settings.calibration,
            "name": settings.name,
            "rate_hz": settings.rate_hz,
            "conversions": settings.conversions,
            "channels": " ".join(settings.channels),
            "clock_ppm": "" if settings.clock_ppm is None else settings.clock_ppm,
            "unix_s": self._epoch_s + self._up_s() if self._epoch_s else 0,
            "supply_mv": self._device.faults.supply_mv(self._device.time_s),
            "reset": self._device.cause,
            "config_errors": 0,
            **settings.kind.header,
            "continues": f"{self._continues:08X}" if self._continues else "",
        }

    def _rest(self) -> dict[str, object]:
        """The end of a summary."""
        header, session = self._header(), self._device.session
        values = {key: header[key] for key in ("supply_mv", "clock_ppm", "unix_s")}
        return values | {"lowest_mv": session.lowest_mv if session else 0}

    def _status(self) -> dict[str, object]:
        device = self._device
        summary: dict[str, object] = dict.fromkeys(NO_SUMMARY, 0) | {"end": "command"}
        if device.session:
            summary = device.session.summary()
        state = "recording" if device.running else "ready"
        card = "ok" if device.card else NO_CARD
        return {"state": state, "card": card, **summary, **self._rest()}


def _lines(kind: str, values: Mapping[str, object]) -> Answer:
    for key, value in values.items():
        yield (kind, f"{key}={value}".encode())
