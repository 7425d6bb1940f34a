"""Find whole blocks wherever they lie: in a damaged or shifted file, or in the image of a card.

File system and directory are not looked at: they may be what is broken.
"""

import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.block import BLOCK_BYTES, FIELDS, HEADER, MAGIC
from wheelhop.logger.survey import KINDS, Progress, open_source, read_bytes, whole

PIECE_BYTES = 4 << 20
START = re.compile(b"HOP[12][" + bytes(KINDS) + b"]")

PLACES = np.dtype(
    [
        ("offset", "<i8"),
        ("session", "<u4"),
        ("block", "<i8"),
        ("first_scan", "<i8"),
        ("lost", "<i8"),
        ("late", "<i4"),
        ("count", "<i2"),
        ("kind", "u1"),
    ]
)
"""Where a whole block lies, and what it says of itself."""


@dataclass(frozen=True, eq=False)
class Find:
    """The whole blocks of one session, in the order of their sequence numbers; where several that
    differ claim the same number, all of them."""

    session: int
    places: NDArray[np.void]


def find_sessions(path: Path, progress: Progress = lambda done: None) -> list[Find]:
    """Return what there is of each session in a file of any kind, by session id.

    A block on its own, without a header, is no session: a CRC of 16 bits is not proof enough.
    Reads 4 MiB at a time. Raises OSError where the file cannot be read.
    """
    places = _find_blocks(path, progress)
    places = places[places["session"] != 0]
    places = places[np.lexsort((places["offset"], places["block"], places["session"]))]
    # A copy of a file has the same blocks again: one is enough.
    said = places[[name for name in PLACES.names or () if name != "offset"]]
    places = places[np.append(True, said[1:] != said[:-1])[: len(places)]]
    parts = np.split(places, np.flatnonzero(np.diff(places["session"])) + 1)
    return [
        Find(int(own["session"][0]), own)
        for own in parts
        if len(own) > 1 or (len(own) == 1 and own["kind"][0] == HEADER[0])
    ]


def _find_blocks(path: Path, progress: Progress) -> NDArray[np.void]:
    found = []
    with open_source(path) as file:
        size = max(file.seek(0, os.SEEK_END), 1)
        file.seek(0)
        rest, offset = bytearray(), 0  # of the file at which `rest` begins
        while more := read_bytes(file, PIECE_BYTES):
            data = rest + more
            # A block that begins nearer to the end than its length comes in the next piece.
            keep = max(len(data) - BLOCK_BYTES + 1, 0)
            starts = [match.start() for match in START.finditer(data, 0, keep + len(MAGIC))]
            found.append(_places(data, np.array([s for s in starts if s < keep], int), offset))
            rest, offset = data[keep:], offset + keep
            progress(min(offset / size, 1.0))
    return np.concatenate(found) if found else np.empty(0, PLACES)


def _places(data: bytearray, starts: NDArray[np.int64], offset: int) -> NDArray[np.void]:
    raw = np.frombuffer(data, np.uint8)
    blocks = raw[starts[:, None] + np.arange(BLOCK_BYTES)]
    right = whole(blocks)
    fields = blocks[right].view(FIELDS)[:, 0]
    places = np.empty(len(fields), PLACES)
    places["offset"] = offset + starts[right]
    places["block"] = fields["sequence"]
    for field in ("session", "first_scan", "lost", "late", "count", "kind"):
        places[field] = fields[field]
    return places
