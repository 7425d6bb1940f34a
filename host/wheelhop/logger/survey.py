"""Which blocks of a file are good, and what the others are (SPEC.md, "What a reader does").

A file is read in pieces and every block is looked at once; of a good block its numbers are kept,
of any other one byte. Nothing that a block says is believed before its CRC, its place and its
neighbours agree with it.

A CRC of 16 bits lets one forgery in 65536 pass, so blocks are held against each other, too. In
every block first_scan = (scans in all data blocks before) + lost, so first_scan − lost counts the
scans that were written before it: exactly those of the blocks before, plus what the blocks
between that are not good have held, at most their capacity. `lost` and `late` only grow. Counts
of scans are modulo 2³²: one that falls by more than half a round has begun the next.
"""

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import check_plain
from wheelhop.logger.block import (
    BESIDE,
    BLOCK_BYTES,
    DATA,
    FIELDS,
    HEADER,
    MAGIC,
    MAGICS,
    SUMMARY,
    SUPPLY,
    crcs,
)
from wheelhop.logger.error import LoggerError

PIECE = 1 << 16
ROUND = 1 << 32  # of scan numbers
JURY = 8  # blocks ahead that say which of two that contradict each other is false
BLOCK, WRITTEN, LOST, LATE, COUNT = range(5)  # columns below; WRITTEN is before the block


def agreeing(facts: NDArray[np.void], capacity: int) -> NDArray[np.bool_]:
    """Return which of the (n,) good blocks, in file order, agree with those around them.

    `capacity` is the most scans a block holds. The first one is measured by the start of the
    session, at which nothing was written and nothing lost.
    """
    count = facts["count"]
    is_data = facts["kind"] == DATA[0]
    sane: NDArray[np.bool_] = np.where(is_data, (count >= 1) & (count <= capacity), count == 0)
    kept = facts if sane.all() else facts[sane]
    follows = np.empty(len(kept), bool)
    before = np.zeros((1, 5), np.int64)
    for begin in range(0, len(kept), PIECE):  # a long log has millions of blocks
        line = np.concatenate([before, _rows(kept[begin : begin + PIECE])])
        follows[begin : begin + PIECE] = _follow(line[:-1], line[1:], capacity)
        before = line[-1:]
    if not follows.all():
        line = np.concatenate([np.zeros((1, 5), np.int64), _rows(kept)])
        sane[sane] = _outvote(line, follows, capacity)[1:]
    return sane


def unroll(facts: NDArray[np.void]) -> None:
    """Turn counts modulo 2³² of (n,) agreeing blocks, in file order, into counts that only grow.

    `lost` grows, so where it falls a round is over. No file holds a round of scans, so how many
    are written before a block, first_scan − lost, is less than one.
    """
    written = (facts["first_scan"] - facts["lost"]) % ROUND
    facts["lost"] += ROUND * np.cumsum(np.diff(facts["lost"], prepend=0) < 0)
    facts["first_scan"] = written + facts["lost"]


def _nearest(difference: NDArray[np.int64]) -> NDArray[np.int64]:
    """Differences modulo 2³², the nearer way round."""
    return (difference + ROUND // 2) % ROUND - ROUND // 2


def _rows(facts: NDArray[np.void]) -> NDArray[np.int64]:
    written = facts["first_scan"] - facts["lost"]
    return np.column_stack(
        [facts["block"], written, facts["lost"], facts["late"], facts["count"]]
    ).astype(np.int64)


def _follow(
    before: NDArray[np.int64], after: NDArray[np.int64], capacity: int
) -> NDArray[np.bool_]:
    """Whether blocks can stand behind others."""
    room = np.maximum(after[..., BLOCK] - before[..., BLOCK] - 1, 0) * capacity
    more = _nearest(after[..., WRITTEN] - before[..., WRITTEN] - before[..., COUNT])
    more_lost = after[..., LOST] - before[..., LOST]
    grown = ((more_lost >= 0) | (_nearest(more_lost) >= 0)) & (
        after[..., LATE] >= before[..., LATE]
    )
    fits: NDArray[np.bool_] = grown & (more >= 0) & (more <= room)
    return fits


def _outvote(
    line: NDArray[np.int64], follows: NDArray[np.bool_], capacity: int
) -> NDArray[np.bool_]:
    """Walk along the line; where two contradict each other, drop one and go on with the other."""
    keep = np.ones(len(line), bool)
    before = np.arange(len(line)) - 1  # of each block, the one that it was found to follow
    breaks = np.append(np.flatnonzero(~follows) + 1, len(line))
    trusted, i = 0, 1
    while i < len(line):
        if trusted == i - 1 and follows[trusted]:
            i = int(breaks[np.searchsorted(breaks, i)])
            trusted = i - 1
            continue
        if _follow(line[trusted], line[i], capacity):
            before[i] = trusted
            trusted = i
        elif trusted > 0 and _is_better(line, i, trusted, before[trusted], capacity):
            keep[trusted] = False
            trusted = int(before[trusted])
            continue
        else:
            keep[i] = False
        i += 1
    return keep


def _is_better(line: NDArray[np.int64], i: int, trusted: int, before: int, capacity: int) -> bool:
    """Whether block i is right rather than the trusted one; both together cannot be."""
    if not _follow(line[before], line[i], capacity):
        return False
    jury = line[i + 1 : i + 1 + JURY]
    ours, theirs = (int(_follow(line[k], jury, capacity).sum()) for k in (i, trusted))
    # Undecided: the smaller loss is the smaller claim.
    return (ours, -int(line[i, LOST])) > (theirs, -int(line[trusted, LOST]))


PIECE = 2048  # blocks read at a time, 1 MiB
MAGIC_NUMBERS = [int.from_bytes(magic, "little") for magic in MAGICS]
KINDS = [kind[0] for kind in (HEADER, DATA, SUPPLY, BESIDE, SUMMARY)]

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
    """A file block by block: `verdicts` (n,) of all, `facts` of the good ones of a known kind."""

    session: int
    verdicts: NDArray[np.uint8]
    facts: NDArray[np.void]
    spare_bytes: int  # behind the last whole block


def open_source(source: Path | bytes) -> BinaryIO:
    """Return what a log is read from: a file or a medium. Raises LoggerError for all else."""
    if isinstance(source, bytes):
        return io.BytesIO(source)
    check_plain(source, LoggerError, medium=True)
    return source.open("rb", buffering=0)


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
    right = np.isin(fields["magic"], MAGIC_NUMBERS)
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
    known = good & np.isin(fields["kind"], KINDS)
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
    if magic[:3] == MAGIC[:3] and magic not in MAGICS and magic[3:].isdigit():
        raise LoggerError(
            f"{name}: byte 3: format version {magic[3:].decode()}, this wheelhop reads 1 and 2:"
            " install a newer one"
        )
