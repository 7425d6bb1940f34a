"""Save what can be saved of a damaged log, or of all logs on a card, into healthy files.

A recovered file follows SPEC.md from its first block to its last. What was damaged becomes lost:
blocks are numbered anew without holes, `lost` counts the scans of those left out as well, and the
summary says how many in a key of its own, `damaged`. The scans keep their numbers and bits.
"""

import hashlib
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import made_folder, replacing
from wheelhop.logger.block import (
    BESIDE,
    BLOCK_BYTES,
    DATA,
    HEADER,
    MAGIC,
    MAGICS,
    PAYLOAD_AT,
    PAYLOAD_BYTES,
    SUMMARY,
    SUPPLY,
    pack_block,
    pack_text,
    parse_text,
)
from wheelhop.logger.card import Find, find_sessions
from wheelhop.logger.error import LoggerError
from wheelhop.logger.log import Log
from wheelhop.logger.read import borrowed_header, read_log
from wheelhop.logger.settings import block_capacity, number
from wheelhop.logger.survey import ROUND, Progress, agreeing, unroll

PAYLOAD = slice(PAYLOAD_AT, PAYLOAD_AT + PAYLOAD_BYTES)


@dataclass(frozen=True)
class Recovered:
    """A session that was saved in `path`: scans due, written in it, lost by the logger, damaged
    since; blocks left out as contradicting the others; whether it had its header and summary."""

    session: int
    path: Path
    due: int
    written: int
    lost: int
    damaged: int
    contradictions: int
    header: bool
    closed: bool

    @property
    def troubles(self) -> tuple[str, ...]:
        """What of that which the logger has written is gone, or may be."""
        found = {
            "header lost": not self.header,
            "not closed": not self.closed,
            f"{self.damaged} scans damaged": self.damaged,
            f"{self.contradictions} blocks contradict the others": self.contradictions,
        }
        return tuple(trouble for trouble, there in found.items() if there)

    @property
    def complete(self) -> bool:
        """Whether all that the logger has written is there."""
        return not self.troubles


def recover(
    source: Path,
    folder: Path,
    *,
    header_from: Log | None = None,
    progress: Progress = lambda done: None,
) -> Iterator[Recovered]:
    """Save every session of a file or a card's image in a file of its own, and yield what it is.

    Each has been read back and compared before it gets its name; `progress` is told of the search,
    and then of each file. A header that is lost is taken from `header_from`, or else left empty.
    Raises LoggerError where no session is found, a file would be overwritten, or one reads back
    differently.
    """
    finds = find_sessions(source, progress)
    if not finds:
        raise LoggerError(f"{source}: not a session in it, not even two whole blocks of one")
    numbers = [find.session >> 16 for find in finds]
    with made_folder(folder):
        for find in finds:
            alone = numbers.count(find.session >> 16) == 1
            twin = "" if alone else f"-{find.session & 0xFFFF:04x}"
            path = folder / f"HOP{find.session >> 16:05d}{twin}.HOP"
            if path.exists():
                raise LoggerError(f"{path}: is there already: give another folder with --into")
            yield _save(source, find, path, header_from, progress)


@dataclass(frozen=True, eq=False)
class _Plan:
    """What a recovered file is made of: its first and last block, and the data between."""

    header: bytes
    data: NDArray[np.void]
    summary: bytes


def _save(
    source: Path, find: Find, path: Path, header_from: Log | None, progress: Progress
) -> Recovered:
    with replacing(path, LoggerError) as draft, source.open("rb") as file:
        plan, result = _plan(file, find, path, header_from)
        with draft.open("wb") as out:
            said = _write(plan, file, out, progress)
            os.fsync(out.fileno())
        if _reread(draft, result) != said:
            raise LoggerError(f"{path}: reads back differently from what was written: disk trouble")
    return result


def _plan(
    file: BinaryIO, find: Find, path: Path, header_from: Log | None
) -> tuple[_Plan, Recovered]:
    places = find.places
    heads = places[(places["kind"] == HEADER[0]) & (places["block"] == 0)]
    if len(heads):
        header = _block(file, heads[0])
    else:
        borrowed = borrowed_header(header_from) if header_from else {}
        header = pack_block(HEADER, find.session, 0, payload=pack_text(borrowed))
    agreed = agreeing(places, block_capacity(parse_text(header[PAYLOAD])))
    kept = places[agreed]
    ends = np.flatnonzero(kept["kind"] == SUMMARY[0])
    closed = len(ends) > 0
    kept = kept[: ends[0] + 1] if closed else kept
    unroll(kept)
    data = kept[np.isin(kept["kind"], [DATA[0], BESIDE[0]])]
    end = kept[-1] if len(kept) else np.zeros(1, places.dtype)[0]
    due, lost = int(end["first_scan"]) + int(end["count"]), int(end["lost"])
    written = int(data["count"].sum())
    result = Recovered(
        find.session,
        path,
        due,
        written,
        lost,
        damaged=due - written - lost,
        contradictions=int((~agreed).sum()),
        header=len(heads) > 0,
        closed=closed,
    )
    summary = _block(file, end) if closed else b""
    if not closed or result.damaged or end["block"] != len(data) + 1:
        said = parse_text(summary[PAYLOAD]) if closed else {"end": "recovered"}
        if low := _lowest_supply(file, kept):
            said = {"lowest_mv": f"{low:.0f}", **said}
        magic = header[:4] if header[:4] in MAGICS else MAGIC
        summary = _summary(said, result, int(end["late"]), len(data) + 1, magic)
    return _Plan(header, data, summary), result


def _lowest_supply(file: BinaryIO, kept: NDArray[np.void]) -> float:
    """Millivolts that blocks about the supply tell, which are not copied; 0: there are none."""
    texts = (parse_text(_block(file, p)[PAYLOAD]) for p in kept[kept["kind"] == SUPPLY[0]])
    return min((mv for text in texts if (mv := number(text, "supply_mv")) > 0), default=0.0)


def _summary(
    said: dict[str, str], result: Recovered, late: int, sequence: int, magic: bytes
) -> bytes:
    lost = result.due - result.written
    due, lost = result.due % ROUND, lost % ROUND
    counts = {"due": due, "written": result.written, "lost": lost, "late": late}
    damaged = result.damaged + int(number(said, "damaged"))  # by now, and when it was recovered
    if damaged:
        counts["damaged"] = damaged
    text = pack_text({**said, **counts})
    if len(text) > PAYLOAD_BYTES:  # no logger says so much
        text = pack_text({"end": "recovered", **counts})
    return pack_block(
        SUMMARY,
        result.session,
        sequence,
        first_scan=due,
        lost=lost,
        late=late,
        payload=text,
        magic=magic,
    )


def _write(plan: _Plan, file: BinaryIO, out: BinaryIO, progress: Progress) -> bytes:
    """Write a file, and return the digest of its scans as the source has them."""
    digest = hashlib.sha256()
    out.write(plan.header)
    written = 0
    for sequence, place in enumerate(plan.data, start=1):
        block = _block(file, place)
        first, count = int(place["first_scan"]), int(place["count"])
        if place["kind"] == DATA[0]:
            digest.update(_scans(first, count, block))
        if sequence != place["block"] or first - written != place["lost"]:
            block = pack_block(
                bytes([place["kind"]]),
                int(place["session"]),
                sequence,
                first_scan=first % ROUND,
                lost=(first - written) % ROUND,
                late=int(place["late"]),
                count=count,
                payload=block[PAYLOAD],
                magic=block[:4],
            )
        out.write(block)
        written += count
        if sequence % 4096 == 0:
            progress(sequence / len(plan.data))
    out.write(plan.summary)
    out.flush()
    return digest.digest()


def _reread(path: Path, result: Recovered) -> bytes | None:
    """Return the digest of the scans in a file; None if it is not the log that it should be."""
    log = read_log(path)
    right = log.session == result.session and log.summary is not None and not log.damage
    right &= (log.due, log.written, log.missing) == (result.due, result.written, log.lost)
    digest = hashlib.sha256()
    with path.open("rb") as file:
        for fact in log.blocks:
            file.seek(int(fact["block"]) * BLOCK_BYTES)
            block = file.read(BLOCK_BYTES)
            digest.update(_scans(int(fact["first_scan"]), int(fact["count"]), block))
    return digest.digest() if right else None


def _scans(first: int, count: int, block: bytes) -> bytes:
    return b"%d %d " % (first, count) + block[PAYLOAD]


def _block(file: BinaryIO, place: np.void) -> bytes:
    file.seek(int(place["offset"]))
    return file.read(BLOCK_BYTES)
