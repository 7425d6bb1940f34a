"""Fetch log files from the logger's card over the serial line.

A file grows as `NAME.part`, in whole blocks, and gets its name when it is complete and was read
back. Whatever ends a download, the next one goes on behind the last good block.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from wheelhop.files import check_target, sync_folder
from wheelhop.logger.block import (
    BLOCK_BYTES,
    CRC_AT,
    MAGICS,
    PAYLOAD_AT,
    SUMMARY,
    crc,
    parse_text,
)
from wheelhop.logger.error import LoggerError
from wheelhop.logger.link import Link, Silent, reconnect
from wheelhop.logger.port import BAUD, PortLost
from wheelhop.logger.read import read_log

CHUNK = 64  # blocks asked for at a time: 0.8 s of the line
ROUNDS = 20  # in which something must come
GIVE_UP_AFTER = 64  # blocks in a row that are not good: behind a session that was not closed
PATIENCE_S = 60.0  # for a line that was lost

Progress = Callable[[int, int], None]
"""Takes bytes that are here, and all there are."""


@dataclass(frozen=True)
class Downloaded:
    """A file that is here. `damaged` blocks are so on the card; `fresh`: it was not here before."""

    path: Path
    size: int
    damaged: int
    fresh: bool


class Downloader:
    """Downloads over a link, and over a new one when that is lost. Close it at the end."""

    def __init__(self, link: Link, *, baud: int = BAUD, patience_s: float = PATIENCE_S) -> None:
        self.link = link
        self._baud, self._patience_s = baud, patience_s

    def download(
        self,
        name: str,
        size: int,
        folder: Path,
        progress: Progress = lambda done, all_: None,
        recorded_will_do: bool = False,
    ) -> Downloaded:
        """Fetch a file of `size` bytes into `folder`, under its name; under NAME-2 if there is
        another file of that name, under none if the same is there already, or, if
        `recorded_will_do`, all its scans are, as they were recorded over the line.

        Raises LoggerError where the logger refuses, does not come back, or the disk takes no more;
        what has come is kept for the next time.
        """
        blocks = size // BLOCK_BYTES
        first = self._blocks(name, 0, 1) if blocks else b""
        session = _session(first)
        path, number = folder / name, 1
        while path.exists():
            recorded = recorded_will_do and self._is_recorded(path, name, blocks, session)
            if recorded or self._is_here(path, name, size):
                return Downloaded(path, path.stat().st_size, _damaged(path, session), fresh=False)
            number += 1
            path = folder / f"{Path(name).stem}-{number}{Path(name).suffix}"
        part = path.with_name(path.name + ".part")
        check_target(part, LoggerError)
        try:
            with part.open("r+b" if part.exists() else "w+b") as file:
                here = _sound_blocks(file, first, session)
                file.truncate(here * BLOCK_BYTES)
                file.seek(here * BLOCK_BYTES)
                bad = 0
                while here < blocks and bad < GIVE_UP_AFTER:
                    data = self._blocks(name, here, min(CHUNK, blocks - here))
                    file.write(data)
                    file.flush()
                    for at in range(0, len(data), BLOCK_BYTES):
                        good = is_good(data[at : at + BLOCK_BYTES], session, here)
                        bad = 0 if good else bad + 1
                        here += 1
                    progress(here * BLOCK_BYTES, size)
                if bad >= GIVE_UP_AFTER:  # what follows is not of this session
                    here -= bad
                    file.truncate(here * BLOCK_BYTES)
                os.fsync(file.fileno())
            if part.stat().st_size != here * BLOCK_BYTES:
                raise LoggerError(f"{part}: the disk has not kept it; try again")
            part.replace(path)
            sync_folder(folder)
        except OSError as error:
            raise LoggerError(
                f"{part}: {error.strerror}; what has come is kept, the next download goes on there"
            ) from None
        return Downloaded(path, here * BLOCK_BYTES, _damaged(path, session), fresh=True)

    def close(self) -> None:
        """Close the link."""
        self.link.close()

    def _is_here(self, path: Path, name: str, size: int) -> bool:
        """Whether a file is the card's: it begins and ends as that, and nothing good follows."""
        session: int | None = None
        here = path.stat().st_size
        if here > size or here % BLOCK_BYTES or (size and not here):
            return False
        count = here // BLOCK_BYTES
        with path.open("rb") as file:
            for block in {0, count - 1} if count else ():
                file.seek(block * BLOCK_BYTES)
                told = self._blocks(name, block, 1)
                if told != file.read(BLOCK_BYTES):
                    return False
                session = _session(told) if block == 0 else session
        behind = self._blocks(name, count, 1) if here < size else b""
        return not is_good(behind, session, count)

    def _is_recorded(self, path: Path, name: str, blocks: int, session: int | None) -> bool:
        """Whether a file holds every scan that was due in the card's, a closed session."""
        if session is None:
            return False
        last = self._blocks(name, blocks - 1, 1)
        if not is_good(last, session, blocks - 1) or last[4:5] != SUMMARY:
            return False
        try:
            here = read_log(path)
            due = int(parse_text(last[PAYLOAD_AT:CRC_AT])["due"])
        except (LoggerError, KeyError, ValueError):
            return False
        whole = not here.missing and not here.damage
        return whole and here.session == session and here.due >= due

    def _blocks(self, name: str, block: int, count: int) -> bytes:
        """Whole blocks. One that is not good is asked for twice: so it is on the card."""
        data = self._fetch(name, block, count)
        session = None  # any: what was lost on the line does not fit any
        for k in range(count):
            place = slice(k * BLOCK_BYTES, (k + 1) * BLOCK_BYTES)
            if not is_good(bytes(data[place]), session, block + k):
                data[place] = self._fetch(name, block + k, 1)
        return bytes(data)

    def _fetch(self, name: str, block: int, count: int) -> bytearray:
        data = bytearray(count * BLOCK_BYTES)
        missing = [True] * len(data)
        left = ROUNDS
        while any(missing):
            first = missing.index(True) // BLOCK_BYTES
            last = (len(data) - 1 - missing[::-1].index(True)) // BLOCK_BYTES
            came = 0
            for offset, piece in self._ask(name, block + first, last - first + 1).items():
                at = offset - block * BLOCK_BYTES
                if at >= 0 and at + len(piece) <= len(data):
                    data[at : at + len(piece)] = piece
                    came += sum(missing[at : at + len(piece)])
                    missing[at : at + len(piece)] = [False] * len(piece)
            left = ROUNDS if came else left - 1
            if not left:
                raise LoggerError(
                    f"{self.link.port.name}: {name}: block {block + first} never comes"
                )
        return data

    def _ask(self, name: str, block: int, count: int) -> dict[int, bytes]:
        """What comes, over a new connection if need be."""
        try:
            return self.link.get(name, block, count)[0]
        except (PortLost, Silent) as error:
            url = self.link.port.name
            self.link.close()
            link = reconnect(url, baud=self._baud, wait_s=self._patience_s)
            if link is None:
                raise LoggerError(f"{error}; the next download goes on there") from None
            self.link = link
            return {}


def is_good(block: bytes, session: int | None, sequence: int) -> bool:
    """Whether it is block number `sequence` of a session, of any if that is None."""
    return (
        len(block) == BLOCK_BYTES
        and block.startswith(MAGICS)
        and int.from_bytes(block[12:16], "little") == sequence
        and (session is None or int.from_bytes(block[8:12], "little") == session)
        and int.from_bytes(block[CRC_AT:], "little") == crc(block[:CRC_AT])
    )


def _session(first: bytes) -> int | None:
    """The session of a good header, None of a damaged one."""
    return int.from_bytes(first[8:12], "little") if is_good(first, None, 0) else None


def _sound_blocks(file: BinaryIO, first: bytes, session: int | None) -> int:
    """How many blocks from the beginning on are surely right; 0 if it is another file's part."""
    count = 0
    for block in iter(lambda: file.read(BLOCK_BYTES), b""):
        if (count == 0 and block != first) or not is_good(block, session, count):
            break
        count += 1
    return count


def _damaged(path: Path, session: int | None) -> int:
    """How many blocks of a file are not good; it is read from the disk."""
    with path.open("rb") as file:
        blocks = enumerate(iter(lambda: file.read(BLOCK_BYTES), b""))
        return sum(not is_good(block, session, k) for k, block in blocks)
