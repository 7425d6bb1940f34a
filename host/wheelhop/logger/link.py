"""The conversation with a logger: commands and their replies, and what it says unasked."""

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from queue import Empty, Queue
from threading import Event, Thread

from wheelhop.files.closing import Closing
from wheelhop.logger.emulated import emulated_ports
from wheelhop.logger.error import LoggerError
from wheelhop.logger.frames import Frame, FrameReader, is_ready, pack_command
from wheelhop.logger.port import BAUD, POLL_S, Port, PortLost, SerialPort, find_ports
from wheelhop.logger.refusal import explain

REPLY_S = 2.0
SLOW_REPLY_S = 30.0  # while the card works
SLOW_TRIES = 15  # no longer until somebody hears that there is no logger
QUIET_S = 0.25  # without a reply frame: no late one will come
LEAST_WAIT_S = 1e-4
TRIES = 4
REPLY = "LFKE"
WAIT = "wait"  # the line that says that a command was heard and takes long
NOISE = ("checksum", "line too long or not plain text")  # refusals of a line that was damaged


class Refused(LoggerError):
    """The logger answered `E`; `reason` is its text."""

    def __init__(self, line: str, reason: str) -> None:
        super().__init__(line)
        self.reason = reason


class Silent(LoggerError):
    """No answer, or none that is a logger's."""


@dataclass(frozen=True)
class Reply:
    """The text of the `K`, and the lines before it."""

    text: str
    lines: tuple[str, ...] = ()

    @property
    def values(self) -> dict[str, str]:
        """Lines `key=value` as a mapping."""
        pairs = (line.partition("=") for line in self.lines)
        return {key: value for key, sign, value in pairs if sign}


class Link(Closing):
    """A logger at the other end of a port; a thread of its own takes the bytes as they come.

    Every command is sent with its check sum and repeated where no whole reply came back. What the
    logger says meanwhile waits for `receive`. Methods raise Refused, Silent or PortLost.
    """

    def __init__(self, port: Port, *, reply_s: float = REPLY_S) -> None:
        self.port = port
        self.reader = FrameReader()
        self._reply_s = reply_s
        # SimpleQueue would wait for ever if a deadline passed in the middle of its own get().
        self._queue: Queue[tuple[float, bytes] | PortLost] = Queue()
        self._arrived: deque[Frame] = deque()  # nobody has looked at these yet
        self._unasked: deque[Frame] = deque()  # for `receive`
        self._late_replies = False
        self._closing = Event()
        self._thread = Thread(target=self._listen, daemon=True, name=f"link {port.name}")
        self._thread.start()

    def receive(self, timeout_s: float = POLL_S) -> list[Frame]:
        """Frames that no command asked for; waits for the first, at most so long."""
        deadline = time.monotonic() + timeout_s
        while not self._unasked:
            frame = self._next(deadline)
            if frame is None:
                break
            self._keep(frame)
        try:
            while self._arrived or not self._queue.empty():
                self._keep(self._next(0.0))
        except PortLost:
            if not self._unasked:
                raise
        frames = list(self._unasked)
        self._unasked.clear()
        return frames

    def command(
        self,
        line: str,
        *,
        timeout_s: float | None = None,
        first_s: float | None = None,
        tries: int = TRIES,
        whole: Callable[[Reply], bool] = lambda reply: True,
        piece: Callable[[Frame], None] | None = None,
    ) -> Reply:
        """Send a line until it is answered.

        `first_s` may pass before the first frame of the reply, `timeout_s` between those that
        follow; a reply that is not `whole` is asked for again. `F` frames are given to `piece`.
        Raises Refused, Silent, or LoggerError for a line that cannot be sent.
        """
        try:
            data = pack_command(line)
        except ValueError as error:
            raise LoggerError(f"{line}: {error}") from None
        refusal = ""
        before = self.reader.bytes
        unanswered = False
        timeout_s = timeout_s or self._reply_s
        first_s = first_s or timeout_s
        for _ in range(tries):
            if self._late_replies or unanswered:
                self._drop_late_replies()
            self.port.write(data)
            reply = self._reply(first_s, timeout_s, piece)
            unanswered |= reply is None
            # Of a line that was heard more than once the last answer counts.
            while unanswered and reply is not None:
                later = self._reply(QUIET_S, timeout_s, piece)
                if later is None:
                    break
                reply = later
            self._late_replies = unanswered  # they may come after the one we take
            if isinstance(reply, Reply) and whole(reply):
                return reply
            refusal = reply if isinstance(reply, str) else ""
            if refusal and not refusal.startswith(NOISE):
                break
        if refusal:
            refusal = explain(line, refusal)
            raise Refused(f"{self.port.name}: {line}: {refusal}", refusal)
        raise Silent(f"{self.port.name}: {self._silence(self.reader.bytes - before)}")

    def info(self) -> dict[str, str]:
        """The settings: keys and values as in a log's header."""
        return self.command("info", whole=lambda reply: "channels" in reply.values).values

    def status(self) -> dict[str, str]:
        """`state`, `card`, and what a log's summary says, of the running or the last session."""
        return self.command("status", whole=lambda reply: "written" in reply.values).values

    def set(self, key: str, value: object) -> None:
        """Change a setting, as a line of HOP.CFG does."""
        self.command(f"set {key}={value}")

    def set_time(self, unix_s: float | None = None) -> None:
        """Tell the time; now if not given."""
        self.command(f"time {round(time.time() if unix_s is None else unix_s)}")

    def start(self) -> str:
        """Start a session, unless one runs; the name of its file."""
        return self._heard("start").text

    def stop(self) -> None:
        """End the session, if one runs; returns when its file is closed."""
        self._heard("stop")

    def _heard(self, line: str) -> Reply:
        """Send a line that takes long; the logger says at once that it has heard it."""
        return self.command(line, first_s=self._reply_s, timeout_s=SLOW_REPLY_S, tries=SLOW_TRIES)

    def stream(self, on: bool) -> None:
        """Ask for `D` frames, or no longer."""
        self.command("stream on" if on else "stream off")

    def files(self) -> dict[str, int]:
        """The log files on the card and their sizes in bytes.

        A reply does not say how many lines it has, and a bad line may have lost one: what is told
        twice in a row is believed.
        """
        before, lines = None, self._list()
        while lines != before:
            before, lines = lines, self._list()
        return {name: int(size) for name, size in (line.split() for line in lines)}

    def _list(self) -> tuple[str, ...]:
        return self.command("list", whole=_is_list, timeout_s=SLOW_REPLY_S).lines

    def get(self, name: str, block: int, count: int) -> tuple[dict[int, bytes], int]:
        """Pieces of a file by their offset, as many as came, and the file's size in bytes.

        Asks once: who wants what is missing asks for it. Raises Silent where nothing came at all.
        """
        pieces: dict[int, bytes] = {}

        def take(frame: Frame) -> None:
            pieces[int.from_bytes(frame.payload[:4], "little")] = frame.payload[4:]

        reply = self.command(f"get {name} {block} {count}", whole=_is_size, piece=take)
        return pieces, int(reply.text)

    def close(self) -> None:
        """Give the port back."""
        self._closing.set()
        self._thread.join(timeout=5 * POLL_S)
        self.port.close()

    def _listen(self) -> None:
        while not self._closing.is_set():
            try:
                data = self.port.read()
            except PortLost as error:
                self._queue.put(error)
                return
            if data:
                self._queue.put((time.monotonic(), data))

    def _next(self, deadline: float) -> Frame | None:
        """The next frame, None at the deadline. Raises PortLost, and goes on doing so."""
        while not self._arrived:
            try:
                item = self._queue.get(timeout=max(deadline - time.monotonic(), LEAST_WAIT_S))
            except Empty:
                return None
            if isinstance(item, PortLost):
                self._queue.put(item)
                raise item
            self._arrived.extend(self.reader.feed(item[1], item[0]))
        return self._arrived.popleft()

    def _keep(self, frame: Frame | None) -> None:
        if frame is not None and frame.kind not in REPLY:
            self._unasked.append(frame)

    def _reply(
        self, first_s: float, timeout_s: float, piece: Callable[[Frame], None] | None
    ) -> Reply | str | None:
        """The reply, or the text of a refusal, or None if none came, or one with holes."""
        lost = self.reader.lost
        lines: list[str] = []
        deadline = time.monotonic() + first_s
        while (frame := self._next(deadline)) is not None:
            if frame.kind in REPLY:
                deadline = time.monotonic() + timeout_s
            if frame.kind == "L" and frame.text != WAIT:
                lines.append(frame.text)
            elif frame.kind == "F" and piece:
                piece(frame)
            elif frame.kind == "E":
                return frame.text or "refused"
            elif frame.kind == "K":
                torn = bool(lines) and self.reader.lost != lost
                return None if torn else Reply(frame.text, tuple(lines))
            else:
                self._keep(frame)
            if is_ready(frame):  # it has restarted, and perhaps forgotten what it was asked
                lines.clear()
                deadline = min(deadline, time.monotonic() + QUIET_S)
        return None

    def _drop_late_replies(self) -> None:
        """Let a reply that comes too late pass, so that it is not taken for the next one's."""
        end = time.monotonic() + 4 * QUIET_S
        deadline = time.monotonic() + QUIET_S
        while (frame := self._next(min(deadline, end))) is not None:
            if frame.kind in REPLY:
                deadline = time.monotonic() + QUIET_S
            self._keep(frame)
        self._late_replies = False

    def _silence(self, came: int) -> str:
        if not came:
            return "no answer: is it the logger's port, and is its firmware in (wheelhop flash)?"
        if not self.reader.frames:
            return (
                f"{came} bytes came and no frame of a logger's: another device, or another speed?"
                " The logger talks at 500000 baud"
            )
        return "the logger is there, but its replies do not come through: is the cable sound?"


def _is_list(reply: Reply) -> bool:
    words = [line.split() for line in reply.lines]
    return all(len(pair) == 2 and pair[1].isdecimal() for pair in words)


def _is_size(reply: Reply) -> bool:
    return reply.text.isdecimal()


FIRST_REPLY_S = 1.0
WAKE_TRIES = 8
"""Opening its port restarts many a board: boot loader and card take a few seconds."""
BACK_TRIES = 2


def connect(url: str | None = None, *, baud: int = BAUD, tries: int = WAKE_TRIES) -> Link:
    """Open a port, or the one port over USB (or of `wheelhop emulate`) that a logger answers on,
    and wait for the logger.

    Raises LoggerError where there is no port, it cannot be opened, or no logger answers.
    """
    if url is not None:
        return _open(url, baud, tries)
    ports = [*find_ports(), *emulated_ports()]
    if not ports:
        raise LoggerError(
            "no serial port over USB found: plug the logger in, or give --port PORT; to try without"
            " one, wheelhop emulate"
        )
    if len(ports) == 1:
        return _open(ports[0], baud, tries)
    links: list[Link] = []
    reasons: list[str] = []
    for port in ports:
        try:
            links.append(_open(port, baud, tries))
        except LoggerError as error:
            reasons.append(str(error))
    if len(links) == 1:
        return links[0]
    for link in links:
        link.close()
    if links:
        names = ", ".join(link.port.name for link in links)
        raise LoggerError(f"several loggers: {names}; say which one with --port")
    raise LoggerError(f"no logger answers: {'; '.join(reasons)}")


def reconnect(url: str, *, baud: int = BAUD, wait_s: float) -> Link | None:
    """Try for so long to open a port that was lost; None if it is not back."""
    deadline = time.monotonic() + wait_s
    while True:
        try:
            return _open(url, baud, BACK_TRIES)
        except LoggerError:
            if time.monotonic() > deadline:
                return None
            time.sleep(0.2)


def _open(url: str, baud: int, tries: int) -> Link:
    link = Link(SerialPort(url, baud))
    try:
        link.command("info", timeout_s=FIRST_REPLY_S, tries=tries)
    except BaseException:
        link.close()
        raise
    return link
