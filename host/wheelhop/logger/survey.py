"""Which blocks of a file are good, and what the others are (SPEC.md, "What a reader does").

A file is read in pieces and every block is looked at once; of a good block its numbers are kept,
of any other one byte. Nothing that a block says is believed before its CRC, its place and its
neighbours agree with it.
"""

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.block import BLOCK_BYTES, DATA, FIELDS, HEADER, MAGIC, SUMMARY, SUPPLY, crcs
from wheelhop.logger.error import LoggerError

PIECE = 2048  # blocks read at a time, 1 MiB
MAGIC_NUMBER = int.from_bytes(MAGIC, "little")

FACTS = np.dtype(
    [
        ("block", "<i8"),
        ("first_scan", "<i8"),
        ("lost", "<i8"),
        ("late", "<i4"),
        ("count", "<i2"),
        ("kind", "u1"),
    ]
)
"""What is kept of a good block: its number in the file, and its fields as SPEC names them."""

Progress = Callable[[float], None]


class Verdict(IntEnum):
    """What a block is."""

    GOOD = 0
    DAMAGED = 1  # torn by a power failure, or changed since
    STALE = 2  # of another session, or of another place: never written in this session
    EMPTY = 3  # all bytes alike, as a card has been erased: never written
    CONTRADICTS = 4  # whole, but its scan numbers cannot stand between those of its neighbours


@dataclass(frozen=True, eq=False)
class Survey:
    """A file block by block: `verdicts` (n,) of all, `facts` of the good H, D, V and S blocks."""

    session: int
    verdicts: NDArray[np.uint8]
    facts: NDArray[np.void]
    spare_bytes: int  # behind the last whole block


def open_source(source: Path | bytes) -> BinaryIO:
    """Return what a log is read from. Raises LoggerError where it cannot be read twice."""
    if isinstance(source, bytes):
        return io.BytesIO(source)
    file = source.open("rb", buffering=0)
    if not file.seekable():
        file.close()
        raise LoggerError(f"{source}: is a stream: save it in a file first")
    return file


def read_bytes(file: BinaryIO, size: int) -> bytearray:
    """Read so many bytes, fewer at the end. Raises LoggerError where the medium is broken."""
    data = bytearray()
    try:
        # A raw file may give less than it has.
        while len(data) < size and (more := file.read(size - len(data))):
            data += more
    except OSError as error:
        raise LoggerError(
            f"{getattr(file, 'name', 'log')}: byte {file.tell() + len(data)}: {error.strerror}:"
            " copy what can be read with ddrescue, then wheelhop recover the copy"
        ) from None
    return data


def pieces(file: BinaryIO, first: int = 0) -> Iterator[tuple[int, NDArray[np.uint8]]]:
    """Yield number of the first block and the (n, 512) blocks of each piece, from `first` on."""
    file.seek(first * BLOCK_BYTES)
    while whole := len(data := read_bytes(file, PIECE * BLOCK_BYTES)) // BLOCK_BYTES:
        yield first, np.frombuffer(data, np.uint8, whole * BLOCK_BYTES).reshape(-1, BLOCK_BYTES)
        first += whole


def whole(blocks: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Return which of the (n, 512) blocks have the magic and a right CRC, whatever they hold."""
    fields = blocks.view(FIELDS)[:, 0]
    right = fields["magic"] == MAGIC_NUMBER
    if right.all():
        return np.asarray(crcs(blocks) == fields["crc"])
    right[right] = crcs(blocks[right]) == fields["crc"][right]
    return np.asarray(right)


def survey(source: Path | bytes, name: str, progress: Progress) -> Survey:
    """Look at all blocks of a log. Raises LoggerError if there is no session in it."""
    with open_source(source) as file:
        size = file.seek(0, io.SEEK_END)
        session = _session(file, name, size)
        verdicts, facts = [], []
        for first, blocks in pieces(file):
            verdict, fact = _judge(first, blocks, session)
            verdicts.append(verdict)
            facts.append(fact)
            progress(min((first + len(blocks)) * BLOCK_BYTES / size, 1.0))
    return Survey(session, np.concatenate(verdicts), np.concatenate(facts), size % BLOCK_BYTES)


def _judge(
    first: int, blocks: NDArray[np.uint8], session: int
) -> tuple[NDArray[np.uint8], NDArray[np.void]]:
    fields = blocks.view(FIELDS)[:, 0]
    number = first + np.arange(len(blocks))
    right = whole(blocks)
    good = right & (fields["session"] == session) & (fields["sequence"] == number)
    verdict = np.where(good, Verdict.GOOD, Verdict.DAMAGED).astype(np.uint8)
    verdict[right & ~good] = Verdict.STALE
    odd = np.flatnonzero(~right)
    words = blocks.view(np.uint64)[odd]
    alike = (words == words[:, :1]).all(axis=1) & (blocks[odd, :8] == blocks[odd, :1]).all(axis=1)
    verdict[odd[alike]] = Verdict.EMPTY
    known = good & np.isin(fields["kind"], [kind[0] for kind in (HEADER, DATA, SUPPLY, SUMMARY)])
    facts = np.empty(int(known.sum()), FACTS)
    facts["block"] = number[known]
    for field in ("first_scan", "lost", "late", "count", "kind"):
        facts[field] = fields[field][known]
    return verdict, facts


def _session(file: BinaryIO, name: str, size: int) -> int:
    """That of a good header at the start, or else of the first two good blocks that agree."""
    if not size:
        raise LoggerError(f"{name}: is empty: a session that never began")
    if size < BLOCK_BYTES:
        raise LoggerError(f"{name}: is no log: {size} bytes, less than one block of {BLOCK_BYTES}")
    seen: set[int] = set()
    for first, blocks in pieces(file):
        fields = blocks.view(FIELDS)[:, 0]
        if first == 0 and _is_header(blocks[:1]):
            return int(fields["session"][0])
        placed = whole(blocks) & (fields["sequence"] == first + np.arange(len(blocks)))
        for session in fields["session"][placed]:
            if int(session) in seen:
                return int(session)
            seen.add(int(session))
        if first == 0 and not placed.any():
            _refuse_other_versions(bytes(blocks[0, :4]), name)
    raise LoggerError(
        f"{name}: no session found: no two whole blocks at their places; if it was cut out of a"
        " card or shifted, try: wheelhop recover"
    )


def _is_header(block: NDArray[np.uint8]) -> bool:
    fields = block.view(FIELDS)[0, 0]
    return bool(fields["kind"] == HEADER[0] and fields["sequence"] == 0 and whole(block)[0])


def _refuse_other_versions(magic: bytes, name: str) -> None:
    if magic[:3] == MAGIC[:3] and magic != MAGIC and magic[3:].isdigit():
        raise LoggerError(
            f"{name}: byte 3: format version {magic[3:].decode()}, this wheelhop reads version 1:"
            " install a newer one"
        )
