"""Frames and command lines on the serial line (`firmware/SPEC.md`, "Serial line")."""

import struct
from dataclasses import dataclass

from wheelhop.logger.block import crc

MOST_CONTENT = 52  # bytes of type, counter, payload and CRC
LEAST_CONTENT = 4
LONGEST_COMMAND = 59
CHECK_CHARACTERS = 5  # `*` and four hexadecimal digits
_ACKNOWLEDGEMENT = struct.Struct("<IIIIIHHBB")
_SCAN = struct.Struct("<II")


@dataclass(frozen=True)
class Frame:
    """A frame with a right CRC; `kind` is its type, `at_s` the host's clock when it came."""

    kind: str
    counter: int
    payload: bytes
    at_s: float = 0.0

    @property
    def text(self) -> str:
        """The payload of a frame that carries text."""
        return self.payload.decode("ascii", errors="replace")


@dataclass(frozen=True)
class StreamedScan:
    """A `D` frame; `session` 0: streamed without a session. `stored` is the scan as in blocks."""

    session: int
    number: int
    stored: bytes


@dataclass(frozen=True)
class Acknowledgement:
    """A `B` frame: so much of the session is safe on the card."""

    session: int
    blocks: int
    due: int
    written: int
    lost: int
    late: int
    stall_ms: int
    deepest: int
    card_errors: int


def streamed_scan(frame: Frame) -> StreamedScan | None:
    """What a `D` frame carries; None if it is too short to carry anything."""
    if len(frame.payload) <= _SCAN.size:
        return None
    session, number = _SCAN.unpack_from(frame.payload)
    return StreamedScan(session, number, frame.payload[_SCAN.size :])


def acknowledgement(frame: Frame) -> Acknowledgement | None:
    """What a `B` frame says; None if it is too short. A later version may append to it."""
    if len(frame.payload) < _ACKNOWLEDGEMENT.size:
        return None
    return Acknowledgement(*_ACKNOWLEDGEMENT.unpack_from(frame.payload))


def pack_acknowledgement(told: Acknowledgement) -> bytes:
    """Return the payload of a `B` frame, with counters that stay at the most they can say."""
    late, stall_ms = min(told.late, 0xFFFF), min(told.stall_ms, 0xFFFF)
    counts = (told.session, told.blocks, told.due, told.written, told.lost)
    return _ACKNOWLEDGEMENT.pack(
        *counts, late, stall_ms, min(told.deepest, 0xFF), min(told.card_errors, 0xFF)
    )


def pack_scan_frame(session: int, number: int, stored: bytes) -> bytes:
    """Return the payload of a `D` frame."""
    return _SCAN.pack(session, number) + stored


def stuff(content: bytes) -> bytes:
    """COBS: return `content` without zeros, at most 254 bytes longer by one."""
    out = bytearray()
    for run in content.split(b"\0"):
        while len(run) > 253:
            out += b"\xff" + run[:254]
            run = run[254:]
        out.append(len(run) + 1)
        out += run
    return bytes(out)


def unstuff(piece: bytes) -> bytes | None:
    """The reverse of `stuff`; None if `piece` is no result of it."""
    out = bytearray()
    at = 0
    while at < len(piece):
        code = piece[at]
        if code == 0 or at + code > len(piece):
            return None
        out += piece[at + 1 : at + code]
        at += code
        if code < 0xFF and at < len(piece):
            out.append(0)
    return bytes(out)


def pack_frame(kind: str, counter: int, payload: bytes = b"") -> bytes:
    """Return the bytes of a frame, delimiters included; `counter` is taken modulo 256."""
    body = kind.encode("ascii") + bytes([counter & 0xFF]) + payload
    if len(body) + 2 > MOST_CONTENT:
        raise ValueError(f"{len(body) + 2} bytes, a frame takes {MOST_CONTENT}")
    return b"\0" + stuff(body + crc(body).to_bytes(2, "little")) + b"\0"


def pack_command(command: str) -> bytes:
    """Return a command line with its check sum. Raises ValueError for one too long or not ASCII."""
    if len(command) + CHECK_CHARACTERS > LONGEST_COMMAND:
        raise ValueError(f"command of {len(command)} characters, at most 54")
    plain = command.encode("ascii")
    return plain + b"*%04X\n" % crc(plain)


class FrameReader:
    """Splits what comes over the line into frames; whatever comes, it keeps little of it.

    Counts: `bytes` that came, `frames` that were good, `broken` pieces that were none, and frames
    `lost` as the gaps in their counter tell (modulo 256).
    """

    def __init__(self) -> None:
        self.bytes = self.frames = self.broken = self.lost = 0
        self._rest = b""
        self._counter: int | None = None

    def feed(self, data: bytes, at_s: float = 0.0) -> list[Frame]:
        """Return the frames that `data`, the next bytes of the line, completes."""
        self.bytes += len(data)
        *pieces, rest = (self._rest + data).split(b"\0")
        self._rest = rest[: MOST_CONTENT + 2]  # enough to know that it is too long
        return [frame for piece in pieces if piece and (frame := self._parse(piece, at_s))]

    def _parse(self, piece: bytes, at_s: float) -> Frame | None:
        content = unstuff(piece) if len(piece) <= MOST_CONTENT + 1 else None
        if content is None or not _is_checked(content):
            self.broken += 1
            return None
        frame = Frame(chr(content[0]), content[1], content[2:-2], at_s)
        if self._counter is not None and not is_ready(frame):  # which begins to count anew
            self.lost += (frame.counter - self._counter - 1) & 0xFF
        self._counter = frame.counter
        self.frames += 1
        return frame


def _is_checked(content: bytes) -> bool:
    if not LEAST_CONTENT <= len(content) <= MOST_CONTENT:
        return False
    if content[0] == 0:  # a 0x01 before a frame adds a zero that the CRC, begun at 0, does not see
        return False
    return crc(content[:-2]) == int.from_bytes(content[-2:], "little")


def is_ready(frame: Frame) -> bool:
    """Whether the logger says that it has just started."""
    return frame.kind == "M" and frame.payload.startswith(b"ready")
