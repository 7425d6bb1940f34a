"""Log files written by the host, from what the logger streams (`firmware/SPEC.md`, "Log file").

The file is good at any moment: whole blocks, one after the other. A block is written when it is
full or half a second old, and kept by the disk once a second: a kill loses less than a second.
Of each frame it is told which session it belongs to, and so when a file begins and ends.
"""

import contextlib
import os
import secrets
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from wheelhop.files import sync_folder
from wheelhop.logger.block import (
    BLOCK_BYTES,
    DATA,
    HEADER,
    MAGIC,
    MAGIC_2,
    SUM_BITS,
    SUMMARY,
    fitting_text,
    pack_block,
    scan_bytes,
    scans_per_block,
)
from wheelhop.logger.clock import ClockEstimate
from wheelhop.logger.error import LoggerError
from wheelhop.logger.frames import (
    Acknowledgement,
    Frame,
    StreamedScan,
    acknowledgement,
    is_ready,
    streamed_scan,
)
from wheelhop.logger.link import Refused, Silent
from wheelhop.logger.live import Live, number_or
from wheelhop.logger.port import PortLost
from wheelhop.logger.settings import find_settings

OLDEST_SCAN_S = 0.5  # in memory alone
SYNC_S = 1.0


class LogWriter:
    """Writes one session. Raises LoggerError when the disk does not take it; then the file ends
    with the last whole block, and nothing more is written."""

    def __init__(self, path: Path, session: int, header: Mapping[str, str], channels: int) -> None:
        settings = find_settings(header)
        bits = settings.sum_bits if settings else SUM_BITS
        self._magic = MAGIC_2 if settings and settings.together else MAGIC
        self.path, self.session = path, session
        self.written = 0  # scans taken; those of the last half second may not be in the file yet
        self.due = 0
        self._scan_bytes, self._fit = scan_bytes(channels, bits), scans_per_block(channels, bits)
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
        text = fitting_text(header)
        self._put(pack_block(HEADER, session, 0, payload=text, magic=self._magic))
        sync_folder(path.parent)

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
            late=number_or(str(summary.get("late")), self._late),
            payload=fitting_text(text),
            magic=self._magic,
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
            magic=self._magic,
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


_BINARY = getattr(os, "O_BINARY", 0)


NO_ANSWER = (PortLost, Silent, Refused)
LINES_S = 0.3  # header or summary are told when no line has come for so long
LARGEST_STEP = 1000  # scans; a longer gap must be confirmed by a second frame
HEADER_KEYS = (
    *("firmware", "device", "calibration", "name", "rate_hz", "conversions", "channels"),
    *("clock_ppm", "unix_s", "supply_mv", "reset", "config_errors", "continues"),
)
SUMMARY_KEYS = (
    *("end", "due", "written", "lost", "late", "stall_ms", "deepest", "room", "card_errors"),
    *("unsent", "supply_mv", "clock_ppm", "unix_s", "lowest_mv"),
)

Ask = Callable[[], dict[str, str]]


@dataclass(frozen=True)
class Recorded:
    """A file that was written: its scans, how many are missing from it, and what the logger says of
    its own file, if it was heard to the end: scans due, written, lost."""

    path: Path
    session: int
    written: int
    lost: int
    card: tuple[int, int, int] | None


class StreamRecorder:
    """Writes a file for every session that is streamed, and for the stream before the first.

    `new_path` gives a file for a session, `info` and `status` ask the logger for lines that were
    not heard. `feed` and `tick` raise LoggerError when the disk does not take what they write.
    """

    def __init__(self, new_path: Callable[[int], Path], info: Ask, status: Ask, live: Live) -> None:
        self._new_path, self.info, self.status = new_path, info, status
        self.live = live
        self.recorded: list[Recorded] = []
        self.sessionless = True  # whether a stream without a session is worth a file
        self.span = 0  # scans that were due while we listened
        self._reset()

    def _reset(self) -> None:
        self.session: int | None = None
        self.clock: ClockEstimate | None = None
        self._writer: LogWriter | None = None
        self._next = self._late = 0
        self._suspect: StreamedScan | None = None
        self._backlog: list[tuple[StreamedScan, float]] = []
        self._header: dict[str, str] = {}
        self._summary: dict[str, str] = {}
        self._told_s = time.monotonic()

    @property
    def due(self) -> int:
        """The number after the last scan's."""
        return self._next

    def feed(self, frame: Frame) -> None:
        """Take a frame."""
        if frame.kind == "D" and (scan := streamed_scan(frame)):
            self._take(scan, frame.at_s)
        elif frame.kind == "B" and (told := acknowledgement(frame)):
            self._take_acknowledgement(told)
        elif frame.kind in "HS":
            self._told_s = time.monotonic()
            self._take_line(frame.kind, frame.text)
        elif is_ready(frame):
            if self.session is not None:
                self.live.say("the logger has restarted")
            self.end("recovered")
        elif frame.kind == "M":
            self.live.say(f"logger: {frame.text}")

    def tick(self) -> None:
        """To be called a few times a second."""
        quiet = time.monotonic() - self._told_s > LINES_S
        told = quiet or all(key in self._header for key in HEADER_KEYS)
        if self._backlog and not self._writer and told:
            try:
                self._open()
            except NO_ANSWER as error:  # the scans wait until the logger says what they are
                self.live.say(str(error))
        if self._writer:
            self._writer.tick()
            self.live.written, self.live.lost = self._writer.written, self._writer.lost
        if self._summary and (quiet or all(key in self._summary for key in SUMMARY_KEYS)):
            self.end()
        if self.clock:
            self.live.clock = self.clock.result()

    def end(self, reason: str = "command") -> None:
        """Close the file of the session; `reason` is for one whose end was not told."""
        with suppress(*NO_ANSWER):
            if self._backlog and not self._writer:
                self._open()
            if self._summary and not all(key in self._summary for key in SUMMARY_KEYS):
                self._summary = {**self.status(), **self._summary}
        if (writer := self._writer) is not None:
            card = _totals(self._summary)
            if card and card[0] < writer.due:  # of another session
                card = None
            writer.close(self._own_summary(writer, card, reason))
            missing = (card[0] if card else writer.due) - writer.written
            self.recorded.append(
                Recorded(writer.path, writer.session, writer.written, missing, card)
            )
        self._reset()
        self.live.session = None

    def give_up(self) -> None:
        """Close the file as it is."""
        if self._writer:
            self._writer.close()

    def _own_summary(
        self, writer: LogWriter, card: tuple[int, int, int] | None, reason: str
    ) -> Mapping[str, object]:
        if card is None:
            return {"end": reason, "due": writer.due, "written": 0, "lost": 0, "late": self._late}
        own = {key: value for key, value in self._summary.items() if key not in ("state", "card")}
        return {**own, "card_written": card[1], "card_lost": card[2]}

    def _take_line(self, kind: str, text: str) -> None:
        key, _, value = text.partition("=")
        if not key or not text.isprintable():
            return
        if kind == "H" and key == "session":
            self._announce(value)
        elif kind == "H":
            self._header[key] = value
        elif self.session:
            self._summary[key] = value

    def _announce(self, text: str) -> None:
        try:
            session = int(text, 16)
        except ValueError:
            return
        self._begin(session)

    def _begin(self, session: int) -> None:
        if self.session == session and session:
            return
        self.end("recovered")
        self.session = session
        if session:
            self.sessionless = False
        self.live.session = session

    def _take(self, scan: StreamedScan, at_s: float) -> None:
        if scan.session == 0 and not self.sessionless:
            return
        step = scan.number - self._next
        if scan.session == self.session and (scan.session or step >= 0) and step <= LARGEST_STEP:
            if step >= 0:  # otherwise it has come before
                self._accept(scan, at_s)
            return
        # Another session, or far ahead: one frame in 65536 broken ones passes for a good one.
        before, self._suspect = self._suspect, scan
        if before is None or before.session != scan.session:
            return
        if 0 < scan.number - before.number <= LARGEST_STEP:
            if scan.session != self.session or not scan.session:
                self._begin(scan.session)
            for one in (before, scan):
                self._accept(one, at_s)

    def _accept(self, scan: StreamedScan, at_s: float) -> None:
        self._suspect = None
        begun = self._writer or self._backlog
        self.span += scan.number + 1 - (self._next if begun else scan.number)
        self.live.add(at_s, scan.stored, scan.number - self._next if self._writer else 0)
        self._next = scan.number + 1
        if self.clock:
            self.clock.add(scan.number, at_s, self._late)
        if self._writer:
            self._writer.add(scan.number, scan.stored, self._late)
        else:
            self._backlog.append((scan, at_s))

    def _take_acknowledgement(self, told: Acknowledgement) -> None:
        if told.session == self.session:
            self._late = told.late
            self.live.told = told

    def _open(self) -> None:
        header = dict(self._header)
        if not all(key in header for key in HEADER_KEYS):
            asked = self.info()
            if unix_s := number_or(asked.get("unix_s"), 0):  # of now, not of the start
                past_s = self._next // number_or(asked.get("rate_hz"), self.live.rate_hz)
                asked["unix_s"] = str(unix_s - past_s)
            header = {**asked, **header}
        session = self.session or secrets.randbits(16) | 1
        self.live.describe(header)
        writer = LogWriter(
            self._new_path(session),
            session,
            {**header, "source": "stream"},
            max(len(self.live.channels), 1),
        )
        self._writer, self.live.file = writer, writer.path
        self.clock = ClockEstimate(self.live.rate_hz)
        backlog, self._backlog = self._backlog, []
        for scan, at_s in backlog:
            writer.add(scan.number, scan.stored, self._late)
            self.clock.add(scan.number, at_s, self._late)


def _totals(summary: Mapping[str, str]) -> tuple[int, int, int] | None:
    values = [summary.get(key, "") for key in ("due", "written", "lost")]
    if not all(value.isdecimal() for value in values):
        return None
    due, written, lost = map(int, values)
    return due, written, lost
