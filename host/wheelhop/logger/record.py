"""Record what a logger streams: start it, follow it, come back when the line was lost."""

import os
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from wheelhop.logger.clock import ClockError
from wheelhop.logger.error import LoggerError
from wheelhop.logger.interrupt import interrupt_as_wish
from wheelhop.logger.link import Refused, Silent, connect, reconnect
from wheelhop.logger.live import Live
from wheelhop.logger.log import log_name
from wheelhop.logger.port import BAUD, PortLost
from wheelhop.logger.record_file import NO_ANSWER, Recorded, StreamRecorder

TICK_S = 0.05
SILENCE_S = 3.0  # without a frame while the logger should stream: ask whether it is there
CLOCK_AFTER_S = 60.0
SUFFIX = ".HOP"


@dataclass(frozen=True)
class RecordOptions:
    """`out` is a folder, or the name of a .HOP file; `start`: start a session on the card and stop
    it at the end; `seconds`: end after so much of the logger's time."""

    out: Path = Path()
    port: str | None = None
    baud: int = BAUD
    start: bool = False
    seconds: float | None = None


@dataclass
class RecordResult:
    """One call of `record`: the files it wrote, and the clock error it has stored, if any."""

    files: list[Recorded] = field(default_factory=list)
    clock: ClockError | None = None


def free_path(out: Path, session: int) -> Path:
    """A file for a session that is not there yet; the name is as on the card, where `out` is a
    folder. Never one that exists: -2, -3 and so on are appended."""
    first = out if _is_file(out) else out / log_name(session)
    path, number = first, 1
    while path.exists():
        number += 1
        path = first.with_name(f"{first.stem}-{number}{first.suffix}")
    return path


def check_out(out: Path) -> None:
    """Raise LoggerError unless `out` is a folder, or a new file in one."""
    if _is_file(out):
        if out.exists():
            raise LoggerError(f"{out}: is there already; it will not be overwritten")
        out = out.parent
    if not out.is_dir():
        raise LoggerError(f"{out}: there is no such folder")
    if not os.access(out, os.W_OK):
        raise LoggerError(f"{out}: you may not write there; give another folder with --out")


def _is_file(out: Path) -> bool:
    return out.suffix.upper() == SUFFIX


def record(
    options: RecordOptions,
    live: Live | None = None,
    on_tick: Callable[[Live], None] = lambda live: None,
    stopped: Callable[[], bool] = lambda: False,
) -> RecordResult:
    """Record until `stopped`, `seconds` are over, or the session that was started has ended.

    `on_tick` is called about 20 times a second. The first Ctrl-C ends it in good order, the second
    at once. Raises LoggerError where there is no logger, it refuses, or the disk takes no more.
    What has been written until then is good.
    """
    check_out(options.out)
    return _Run(options, live or Live(), on_tick, stopped).run()


class _Run:
    def __init__(
        self,
        options: RecordOptions,
        live: Live,
        on_tick: Callable[[Live], None],
        stopped: Callable[[], bool],
    ) -> None:
        self._options, self._live, self._on_tick, self._stopped = options, live, on_tick, stopped
        self._link = connect(options.port, baud=options.baud)
        self._stream = StreamRecorder(
            lambda session: free_path(options.out, session),
            lambda: self._link.info(),
            lambda: self._link.status(),
            live,
        )
        self._ours = False  # whether we have started the session
        self._followed = 0  # sessions ended there that we have asked about
        self._stored: ClockError | None = None
        self._heard_s = time.monotonic()
        live.port = self._link.port.name

    def run(self) -> RecordResult:
        """Greet, follow, take leave."""
        try:
            with interrupt_as_wish() as interrupted:
                self._interrupted = interrupted
                self._greet()
                if not self._options.start:
                    self._live.say(f"{self._live.port}: listening; the logger's button starts it")
                while not self._done():
                    self._step()
                self._leave()
        finally:
            self._stream.give_up()
            self._link.close()
        return RecordResult(self._stream.recorded, self._stored)

    def _greet(self) -> None:
        """Tell the time, and have it stream; start a session if that is wanted."""
        header = self._link.info()
        self._live.describe(header)
        status = self._link.status()
        self._live.card = status.get("card", "")
        running = status.get("state") == "recording"
        if not running:
            self._link.set_time()
        if self._options.start:
            self._stream.sessionless = False
        self._link.stream(True)
        if self._options.start and not running:
            self._link.start()
            self._ours = True
        self._heard_s = time.monotonic()

    def _done(self) -> bool:
        if self._wanted_to_stop():
            return True
        if self._options.start and self._ended_there():
            return True
        seconds = self._options.seconds
        if seconds is None:
            return False
        return self._stream.span >= seconds * self._live.rate_hz

    def _ended_there(self) -> bool:
        """Whether the session was ended at the logger. One whose file is full goes on in the next,
        and one that was cut off is followed by another."""
        ended = self._stream.recorded
        if len(ended) == self._followed or not ended[-1].card:
            return False
        try:
            state = self._link.status().get("state")
        except NO_ANSWER:
            return False  # asked again as soon as the line is back
        self._followed = len(ended)
        return state != "recording"

    def _wanted_to_stop(self) -> bool:
        return self._stopped() or self._interrupted()

    def _step(self) -> None:
        try:
            self._listen()
        except PortLost as error:
            self._come_back(error)
        except Silent as error:  # it restarted, and is slow to wake
            self._live.say(str(error))
        self._on_tick(self._live)

    def _listen(self) -> None:
        """Take what comes; greet the logger again if it has restarted."""
        restarted = False
        frames = self._link.receive(TICK_S)
        for frame in frames:
            self._stream.feed(frame)
            restarted |= frame.kind == "M" and frame.text.startswith("ready")
        self._stream.tick()
        self._live.broken = self._link.reader.broken
        now_s = time.monotonic()
        if frames:
            self._heard_s = now_s
        elif now_s - self._heard_s > SILENCE_S:
            self._ask_for_a_sign()
        if restarted:
            self._greet()

    def _ask_for_a_sign(self) -> None:
        """Nothing comes: it does not stream any longer, does not answer, or the port is dead."""
        self._heard_s = time.monotonic()
        try:
            self._link.stream(True)
        except (Silent, Refused) as error:
            raise PortLost(str(error)) from None

    def _come_back(self, error: PortLost) -> None:
        self._live.connected = False
        self._live.say(f"{error}, waiting for it")
        url = self._link.port.name
        self._link.close()
        while not self._wanted_to_stop():
            self._stream.tick()
            self._on_tick(self._live)
            if link := reconnect(url, baud=self._options.baud, wait_s=0.0):
                self._link = link
                break
            time.sleep(TICK_S)
        else:
            return
        self._live.connected = True
        self._live.say(f"{url}: it is back")
        self._resume()

    def _resume(self) -> None:
        """After the line was lost: has the session gone on, or has the logger restarted?"""
        try:
            if self._link.status().get("state") != "recording":
                self._stream.end("recovered")
            self._greet()
        except NO_ANSWER as error:
            self._live.say(str(error))
            self._heard_s = 0.0  # try again soon

    def _leave(self) -> None:
        """Store the clock's error, end the session if it is ours, close the file."""
        farewell: list[Callable[[], None]] = [self._store_clock, lambda: self._link.stream(False)]
        if self._ours:
            farewell.insert(1, self._link.stop)
        for step in farewell if self._live.connected else []:
            try:
                step()
            except NO_ANSWER as error:
                self._live.say(str(error))
        with suppress(PortLost):
            for frame in self._link.receive(TICK_S):
                self._stream.feed(frame)
        self._stream.end()

    def _store_clock(self) -> None:
        clock = self._stream.clock.result() if self._stream.clock else None
        long_enough = self._stream.due >= CLOCK_AFTER_S * self._live.rate_hz
        if clock and clock.is_sound and long_enough:
            self._link.set("clock_ppm", round(clock.ppm))
            self._stored = clock
