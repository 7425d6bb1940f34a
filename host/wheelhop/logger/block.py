"""The 512-byte block, of which log files are made (`firmware/SPEC.md`, "Log file").

`pack_…` and `unpack_…`, `parse_…` are each other's reverse. Nothing here looks at a whole file.
"""

import binascii
import struct
from collections.abc import Mapping
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

BLOCK_BYTES = 512
PAYLOAD_AT = 24
PAYLOAD_BYTES = 486
CRC_AT = 510
MAGIC, MAGIC_2 = b"HOP1", b"HOP2"
MAGICS = (MAGIC, MAGIC_2)
HEADER, DATA, SUMMARY, SUPPLY, BESIDE = b"H", b"D", b"S", b"V", b"I"

SUM_BITS = 13
LARGEST_SUM = 8 * 1023
MOST_CHANNELS = 8
MOST_SCANS = 127  # in one block

PRINTABLE = bytes(byte if 0x20 <= byte < 0x7F or byte == 0x0A else 0x3F for byte in range(256))

FIELDS = np.dtype(
    [
        ("magic", "<u4"),
        ("kind", "u1"),
        ("count", "u1"),
        ("late", "<u2"),
        ("session", "<u4"),
        ("sequence", "<u4"),
        ("first_scan", "<u4"),
        ("lost", "<u4"),
        ("payload", "u1", PAYLOAD_BYTES),
        ("crc", "<u2"),
    ]
)
"""A block as numpy sees it: ``np.frombuffer(data, FIELDS)``."""
_HEAD = struct.Struct("<4scBHIIII")


FEW = 256  # blocks; for more of them numpy is the faster


def crc(data: bytes | memoryview) -> int:
    """CRC-16/XMODEM."""
    return binascii.crc_hqx(data, 0)


@cache
def _table() -> NDArray[np.uint16]:
    """CRC of every pair of bytes, the first byte being the high one."""
    words = (number.to_bytes(2, "big") for number in range(1 << 16))
    return np.array([crc(word) for word in words], np.uint16)


def crcs(blocks: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """Return the (n,) CRCs that (n, 512) blocks should carry, many at a time.

    Two bytes a step for all blocks at once: c ← table[c ⊕ pair], as the CRC of a message starts
    with what its beginning has left (Sarwate, CACM 31 (1988) 1008, with 16 bits for 8).
    """
    if len(blocks) < FEW:
        return np.array([crc(block[:CRC_AT].data) for block in blocks], np.uint16)
    pairs = np.ascontiguousarray(blocks[:, :CRC_AT].view(">u2").T.astype(np.uint16))
    table, remainder = _table(), np.zeros(len(blocks), np.uint16)
    for pair in pairs:
        remainder = table[remainder ^ pair]
    return remainder


def scan_bytes(channels: int, bits: int = SUM_BITS) -> int:
    """Bytes of a stored scan of so many channels, 1 … 8, with sums of so many bits."""
    return (bits * channels + 7) // 8


def scans_per_block(channels: int, bits: int = SUM_BITS) -> int:
    """Most scans of so many channels that a block holds: 37 of eight channels, with 13 bits."""
    return min(PAYLOAD_BYTES // scan_bytes(channels, bits), MOST_SCANS)


def pack_block(
    kind: bytes,
    session: int,
    sequence: int,
    *,
    first_scan: int = 0,
    lost: int = 0,
    late: int = 0,
    count: int = 0,
    payload: bytes = b"",
    magic: bytes = MAGIC,
) -> bytes:
    """Return a whole block with its CRC; the payload is filled up with zeros."""
    if len(payload) > PAYLOAD_BYTES:
        raise ValueError(f"payload of {len(payload)} bytes, a block takes {PAYLOAD_BYTES}")
    late = min(late, 0xFFFF)
    head = _HEAD.pack(magic, kind, count, late, session, sequence, first_scan, lost)
    body = head + payload.ljust(PAYLOAD_BYTES, b"\0")
    return body + crc(body).to_bytes(2, "little")


def pack_scans(sums: ArrayLike, bits: int = SUM_BITS) -> bytes:
    """Return scans as they are stored; `sums` is (n, channels) of 0 … 2^`bits` − 1, 32 at most."""
    rows = np.asarray(sums)
    count, channels = rows.shape
    each = (rows[:, :, None].astype(np.uint32) >> np.arange(bits, dtype=np.uint32)) & 1
    packed = np.packbits(each.astype(np.uint8).reshape(count, -1), axis=1, bitorder="little")
    assert packed.shape[1] == scan_bytes(channels, bits)
    return packed.tobytes()


def unpack_scans(
    stored: bytes | memoryview | NDArray[np.uint8], channels: int, bits: int = SUM_BITS
) -> NDArray[np.uint16] | NDArray[np.uint32]:
    """Return the (n, channels) sums of n stored scans, n = len(stored) / `scan_bytes`."""
    size = scan_bytes(channels, bits)
    data = np.frombuffer(stored, np.uint8) if not isinstance(stored, np.ndarray) else stored
    rows = data.reshape(-1, size)
    if bits != SUM_BITS:
        return _unpack_wide(rows, channels, bits)
    sums = np.empty((len(rows), channels), np.uint16)
    for k in range(channels):
        first, shift = divmod(SUM_BITS * k, 8)
        # 13 bits from any bit on lie in two bytes, or three if they begin late in the first.
        value = rows[:, first] >> shift | rows[:, first + 1].astype(np.uint16) << (8 - shift)
        if shift > 3:
            value |= rows[:, first + 2].astype(np.uint16) << (16 - shift)
        sums[:, k] = value & 0x1FFF
    return sums


def _unpack_wide(rows: NDArray[np.uint8], channels: int, bits: int) -> NDArray[np.uint32]:
    sums = np.empty((len(rows), channels), np.uint32)
    for k in range(channels):
        first, shift = divmod(bits * k, 8)
        value = np.zeros(len(rows), np.uint64)
        for at in range((shift + bits + 7) // 8):
            value |= rows[:, first + at].astype(np.uint64) << np.uint64(8 * at)
        sums[:, k] = value >> np.uint64(shift) & np.uint64((1 << bits) - 1)
    return sums


def pack_text(values: Mapping[str, object]) -> bytes:
    """Return the payload of a header or a summary: lines `key=value`."""
    text = "".join(f"{key}={value}\n" for key, value in values.items())
    return text.encode("ascii", errors="replace")


def fitting_text(values: Mapping[str, object]) -> bytes:
    """As many lines as a block takes, in their order."""
    kept: dict[str, object] = {}
    for key, value in values.items():
        if len(pack_text({**kept, key: value})) <= PAYLOAD_BYTES:
            kept[key] = value
    return pack_text(kept)


def parse_text(payload: bytes) -> dict[str, str]:
    """Return the values of a header or a summary by key.

    What is no line `key=value` is left out, and so is a key with an empty value: it is as good
    as missing. Bytes that are not printable ASCII become `?`: they would reach a terminal.
    """
    text = payload.split(b"\0", 1)[0].translate(PRINTABLE).decode("ascii")
    pairs = (line.partition("=") for line in text.split("\n"))
    return {key: value for key, _, value in pairs if key and value}
