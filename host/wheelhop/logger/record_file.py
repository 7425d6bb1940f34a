"""A log file written by the host, from what the logger streams (`firmware/SPEC.md`, "Log file").

The file is good at any moment: whole blocks, one after the other. A block is written when it is
full or half a second old, and the disk is told to keep it once a second: whoever kills the process
loses less than a second.
"""

import contextlib
import os
import time
from collections.abc import Mapping
from pathlib import Path

from wheelhop.logger.block import (
    BLOCK_BYTES,
    DATA,
    HEADER,
    PAYLOAD_BYTES,
    SUMMARY,
    pack_block,
    pack_text,
    scan_bytes,
    scans_per_block,
)
from wheelhop.logger.error import LoggerError

OLDEST_SCAN_S = 0.5  # in memory alone
SYNC_S = 1.0


class LogWriter:
    """Writes one session. Raises LoggerError when the disk does not take it; then the file ends
    with the last whole block, and nothing more is written."""

    def __init__(self, path: Path, session: int, header: Mapping[str, str], channels: int) -> None:
        self.path, self.session = path, session
        self.written = 0  # scans taken; those of the last half second may not be in the file yet
        self.due = 0
        self._scan_bytes, self._fit = scan_bytes(channels), scans_per_block(channels)
        self._blocks = 0
        self._scans: list[bytes] = []
        self._first = self._lost_before = self._late = 0
        self._begun_s = self._synced_s = 0.0
        try:
            self._file = os.open(path, os.O_CREAT | os.O_EXCL | os.O_RDWR | _BINARY, 0o644)
        except FileExistsError:
            raise LoggerError(f"{path}: is there already; it will not be overwritten") from None
        except OSError as error:
            raise LoggerError(f"{path}: {error.strerror}") from None
        self._put(pack_block(HEADER, session, 0, payload=fitting_text(header)))

    @property
    def lost(self) -> int:
        """Scans up to the last one that did not come."""
        return self.due - self.written

    def add(self, number: int, stored: bytes, late: int = 0) -> bool:
        """Take a scan; one that is no newer than the last, or of a wrong size, is left out."""
        if number < self.due or len(stored) != self._scan_bytes:
            return False
        if self._scans and (number != self.due or len(self._scans) == self._fit):
            self._seal()
        if not self._scans:
            self._first, self._lost_before = number, number - self.written
            self._begun_s = time.monotonic()
        self._scans.append(stored)
        self._late = late
        self.written += 1
        self.due = number + 1
        if len(self._scans) == self._fit:
            self._seal()
        return True

    def tick(self) -> None:
        """To be called a few times a second: bring to the disk what has waited long enough."""
        now_s = time.monotonic()
        if self._scans and now_s - self._begun_s >= OLDEST_SCAN_S:
            self._seal()
        if now_s - self._synced_s >= SYNC_S:
            self._sync()
            self._synced_s = now_s

    def close(self, summary: Mapping[str, object] | None = None) -> None:
        """End the file, with a summary if there is anything to say; `due` in it is kept."""
        try:
            if self._file < 0:
                return
            if self._scans:
                self._seal()
            if summary is not None:
                self._put_summary(summary)
            self._sync()
        finally:
            self._give_up()

    def _put_summary(self, summary: Mapping[str, object]) -> None:
        due = int(str(summary.get("due", self.due)))
        lost = due - self.written
        text = {**summary, "due": due, "written": self.written, "lost": lost}
        block = pack_block(
            SUMMARY,
            self.session,
            self._blocks,
            first_scan=due,
            lost=lost,
            late=self._late,
            payload=fitting_text(text),
        )
        self._put(block)

    def _seal(self) -> None:
        scans, self._scans = self._scans, []
        block = pack_block(
            DATA,
            self.session,
            self._blocks,
            first_scan=self._first,
            lost=self._lost_before,
            late=self._late,
            count=len(scans),
            payload=b"".join(scans),
        )
        try:
            self._put(block)
        except LoggerError:
            self.written -= len(scans)
            raise

    def _put(self, block: bytes) -> None:
        size = self._blocks * BLOCK_BYTES
        left = block
        try:
            while left:
                left = left[os.write(self._file, left) :]
        except OSError as error:
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, size)
            self._give_up()
            raise LoggerError(
                f"{self.path}: {error.strerror}; it is whole up to here, {size} bytes, and the"
                " logger's card goes on: wheelhop download"
            ) from None
        self._blocks += 1

    def _sync(self) -> None:
        if self._file >= 0:
            with contextlib.suppress(OSError):  # some places cannot; writing will tell
                os.fsync(self._file)

    def _give_up(self) -> None:
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


def fitting_text(values: Mapping[str, object]) -> bytes:
    """As many lines as a block takes, in their order."""
    kept: dict[str, object] = {}
    for key, value in values.items():
        if len(pack_text({**kept, key: value})) <= PAYLOAD_BYTES:
            kept[key] = value
    return pack_text(kept)


_BINARY = getattr(os, "O_BINARY", 0)
