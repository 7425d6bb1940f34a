"""The logger as every tab sees it: what it records now, what it has recorded, what its card has.

Recording and fetching run in threads of the page's process: the line is slow, so they need little.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Event, Thread
from typing import TYPE_CHECKING

from wheelhop.files import InputError, away_from_here, make_folder
from wheelhop.logger.live import Live
from wheelhop.logger.port import find_ports

if TYPE_CHECKING:
    from multiprocessing.process import BaseProcess

EMULATED_FACTOR = 10.0
FOLDER = "recordings"
ANNOUNCED_S = 60.0


@dataclass(frozen=True)
class Made:
    """A recording that is here: how long, s, scans missing, what is wrong with its sensors."""

    path: Path
    seconds: float
    missing: int
    findings: tuple[str, ...]


@dataclass
class Recorder:
    """At most one recording, or one download, at a time.

    `busy` says what goes on, "" if nothing; `live` is the recording while and after it runs; `made`
    are the recordings of this workbench, the last one first; `card` what the card was said to hold,
    bytes by name; `notice` is a line for the user. `version` changes with all but `live`.
    """

    busy: str = ""
    live: Live | None = None
    made: list[Made] = field(default_factory=list)
    card: dict[str, int] = field(default_factory=dict)
    notice: str = ""
    version: int = 0
    _wish: Event = field(default_factory=Event)
    _thread: Thread | None = None
    _emulated: BaseProcess | None = None
    _keeps_it: Connection | None = None

    def start(self, folder: Path, port: str | None) -> None:
        """Start a session on the logger and record it into `folder`, until `stop`."""
        self._wish.clear()
        self.live = Live()
        self._do("recording", lambda: self._record(folder, port))

    def stop(self) -> None:
        """End the recording in good order; its file is whole."""
        self._wish.set()

    def look_at_card(self, port: str | None) -> None:
        """Ask the logger which files its card has."""

        def look() -> None:
            from wheelhop.logger.link import connect

            with connect(port) as link:
                self.card = link.files()
            if not self.card:
                self.notice = "there are no log files on the card"

        self._do("asking the card", look)

    def fetch(self, name: str, folder: Path, port: str | None) -> None:
        """Download a file of the card."""

        def fetch() -> None:
            from wheelhop.logger.download import Downloader
            from wheelhop.logger.link import connect

            make_folder(folder)
            downloader = Downloader(connect(port))
            try:
                size, progress = self.card[name], self._progress(name)
                found = downloader.download(name, size, folder, progress, recorded_will_do=True)
            finally:
                downloader.close()
            if found.damaged:
                self.notice = f"{found.path}: {found.damaged} blocks are damaged on the card"
            elif not found.fresh:
                self.notice = f"{found.path}: all of it is here already"
            self._keep(found.path)

        self._do(f"fetching {name}", fetch)

    def ports(self) -> list[str]:
        """Where a logger may be: serial ports over USB, and an emulated one."""
        from wheelhop.logger.emulated import emulated_ports

        return [*find_ports(), *emulated_ports()]

    def emulate(self) -> None:
        """Have an emulated logger, as long as this process lives."""

        def begin() -> None:
            context = get_context("spawn")
            self._keeps_it, there = context.Pipe()
            self._emulated = context.Process(target=be_a_logger, args=(there,), daemon=True)
            with away_from_here():
                self._emulated.start()
            there.close()
            line = "the emulated logger does not start"
            if self._keeps_it.poll(ANNOUNCED_S):
                with suppress(EOFError):  # it has ended without a word
                    line = self._keeps_it.recv()
            if line:
                raise InputError(line)
            self.notice = (
                f"An emulated logger is there; its time runs {EMULATED_FACTOR:g} times faster. In"
                " its first session the sensors are turned over, in the second the vehicle is"
                " struck beside each sensor, from the third on it drives."
            )

        self._do("switching on an emulated logger", begin)

    def close(self) -> None:
        """End what goes on, and the emulated logger."""
        self.stop()
        if self._thread is not None:
            self._thread.join(5.0)
        if self._emulated is not None:
            self._emulated.kill()

    def say(self, line: str) -> None:
        """A line for the user, in every tab."""
        self.notice = line
        self.version += 1

    def _do(self, what: str, work: Callable[[], None]) -> None:
        if self.busy:
            return
        self.busy, self.notice = what, ""
        self.version += 1

        def run() -> None:
            try:
                work()
            except InputError as error:
                self.notice = str(error)
            except OSError as error:
                self.notice = f"{what}: {error.strerror or error}"
            finally:
                self.busy = ""
                self.version += 1

        self._thread = Thread(target=run, daemon=True, name=what)
        self._thread.start()

    def _record(self, folder: Path, port: str | None) -> None:
        from wheelhop.logger.record import RecordOptions, record

        make_folder(folder)
        options = RecordOptions(out=folder, port=port, start=True)
        result = record(options, self.live, stopped=self._wish.is_set)
        for one in result.files:
            self._keep(one.path)
        if not result.files:
            self.notice = "nothing was recorded"

    def _progress(self, name: str) -> Callable[[int, int], None]:
        def progress(done: int, whole: int) -> None:
            self.busy = f"fetching {name}: {100 * done // max(whole, 1)} %"
            self.version += 1

        return progress

    def _keep(self, file: Path) -> None:
        from wheelhop.calibration import examine
        from wheelhop.logger import read_log

        recording = read_log(file).recording()
        found = [
            f"{', '.join(f.channels) or 'all channels'}: {f.what} ({f.sure}); {f.remedy}"
            for f in examine(recording).findings
        ]
        seconds = len(recording.values) / recording.rate_hz
        missing = int(recording.missing.sum())
        others = [made for made in self.made if made.path != file]
        self.made = [Made(file, seconds, missing, tuple(found)), *others]


def be_a_logger(keeper: Connection) -> None:
    """The emulated logger's process: it lives as long as the other end of the pipe."""
    sys.stdout = sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    from wheelhop.hil_sim.emulated import emulated_logger

    try:
        with emulated_logger(None, EMULATED_FACTOR):
            keeper.send("")
            try:
                keeper.recv()
            except EOFError:
                return
    except InputError as error:
        keeper.send(str(error))
