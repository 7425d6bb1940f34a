"""A decoder of files and frames, written from `firmware/SPEC.md` alone (format version 1)."""

import binascii
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field

BLOCK_SIZE = 512
PAYLOAD = slice(24, 510)
HEADER, DATA, SUMMARY = b"H", b"D", b"S"
GIVE_UP_AFTER = 64  # blocks in a row that are not good


@dataclass(frozen=True)
class Block:
    number: int
    kind: bytes
    count: int
    late: int
    session: int
    first_scan: int
    lost: int
    payload: bytes


@dataclass
class Log:
    """What a file holds. `scans` maps scan numbers to the sums of the recorded channels."""

    session: int
    header: dict[str, str] = field(default_factory=dict)
    summary: dict[str, str] | None = None
    blocks: list[Block] = field(default_factory=list)
    bad: list[int] = field(default_factory=list)
    scans: dict[int, tuple[int, ...]] = field(default_factory=dict)

    @property
    def channels(self) -> list[str]:
        return [name for name in self.header["channels"].split() if name != "-"]


def parse_block(data: bytes, number: int) -> Block | None:
    """A block with the right magic, check sum and place; nothing else is one."""
    magic, kind, count, late, session, sequence, first, lost = struct.unpack_from(
        "<4scBHIIII", data
    )
    (crc,) = struct.unpack_from("<H", data, 510)
    if magic != b"HOP1" or crc != binascii.crc_hqx(data[:510], 0) or sequence != number:
        return None
    return Block(number, kind, count, late, session, first, lost, data[PAYLOAD])


def parse_text(payload: bytes) -> dict[str, str]:
    lines = payload.rstrip(b"\0").decode("ascii").splitlines()
    return dict(line.split("=", 1) for line in lines)


def unpack(stored: bytes, channels: int) -> tuple[int, ...]:
    """The 13-bit sums of one scan."""
    bits = int.from_bytes(stored, "little")
    return tuple(bits >> (13 * k) & 0x1FFF for k in range(channels))


def stored_size(channels: int) -> int:
    return -(-13 * channels // 8)


def read_log(data: bytes, channels: int | None = None) -> Log | None:
    """Everything in a file that belongs to its session; None if there is no session in it.

    `channels` is their number, for a file whose header is damaged.
    """
    session = _session_of(_parse_blocks(data))
    if session is None:
        return None
    log = Log(session)
    bad: list[int] = []
    for number, block in enumerate(_parse_blocks(data)):
        if block is None or block.session != log.session:
            bad.append(number)
            if len(bad) >= GIVE_UP_AFTER and number - bad[-GIVE_UP_AFTER] == GIVE_UP_AFTER - 1:
                break
            continue
        log.blocks.append(block)
        if block.kind == HEADER:
            log.header = parse_text(block.payload)
        elif block.kind == DATA:
            _take_scans(log, block, channels or len(log.channels))
        elif block.kind == SUMMARY:
            log.summary = parse_text(block.payload)
            break
    last = log.blocks[-1].number
    log.bad = [number for number in bad if number < last]
    return log


def _parse_blocks(data: bytes) -> Iterator[Block | None]:
    for number in range(len(data) // BLOCK_SIZE):
        yield parse_block(data[number * BLOCK_SIZE : (number + 1) * BLOCK_SIZE], number)


def _session_of(blocks: Iterator[Block | None]) -> int | None:
    """That of block 0, or else that of the first two good blocks that agree."""
    seen = set()
    for block in blocks:
        if block is not None:
            if block.session in seen or (block.number == 0 and block.kind == HEADER):
                return block.session
            seen.add(block.session)
    return None


def _take_scans(log: Log, block: Block, channels: int) -> None:
    size = stored_size(channels)
    for i in range(block.count):
        number = block.first_scan + i
        assert number not in log.scans, f"scan {number} is in the file twice"
        log.scans[number] = unpack(block.payload[i * size : (i + 1) * size], channels)


@dataclass(frozen=True)
class Frame:
    time_s: float  # when its last byte was sent
    kind: str
    counter: int
    payload: bytes

    @property
    def text(self) -> str:
        return self.payload.decode("ascii")


@dataclass(frozen=True)
class Acknowledgement:
    """The payload of a `B` frame."""

    session: int
    blocks: int
    due: int
    written: int
    lost: int
    late: int
    stall_ms: int
    deepest: int
    card_errors: int


def acknowledgement(frame: Frame) -> Acknowledgement:
    return Acknowledgement(*struct.unpack("<IIIIIHHBB", frame.payload))


def streamed(frame: Frame, channels: int) -> tuple[int, int, tuple[int, ...]]:
    """Session, scan number and sums of a `D` frame."""
    session, number = struct.unpack_from("<II", frame.payload)
    assert len(frame.payload) == 8 + stored_size(channels)
    return session, number, unpack(frame.payload[8:], channels)


def unstuff(piece: bytes) -> bytes | None:
    """The reverse of consistent overhead byte stuffing; None if it is none."""
    out = bytearray()
    i = 0
    while i < len(piece):
        code = piece[i]
        if code == 0 or i + code > len(piece):
            return None
        out += piece[i + 1 : i + code]
        i += code
        if code < 0xFF and i < len(piece):
            out.append(0)
    return bytes(out)


def parse_frame(piece: bytes, time_s: float = 0.0) -> Frame | None:
    content = unstuff(piece)
    if content is None or len(content) < 4:
        return None
    body, crc = content[:-2], int.from_bytes(content[-2:], "little")
    if crc != binascii.crc_hqx(body, 0):
        return None
    return Frame(time_s, chr(body[0]), body[1], body[2:])


def checked(command: str) -> bytes:
    """A command line with its check sum."""
    return f"{command}*{binascii.crc_hqx(command.encode(), 0):04X}\n".encode()
