"""What there is to see while the logger streams, and the live plot that shows it.

Other pages in that browser, and other users of this computer, can reach the page's port. So
nothing is answered without the token in the address, nor to another name for this host (DNS
rebinding) or a request that another page has made; and the page may load nothing but itself.
"""

import json
import secrets
from collections import deque
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from pathlib import Path
from threading import BoundedSemaphore, Event, Lock, Thread
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.closing import Closing
from wheelhop.logger.block import scan_bytes, unpack_scans
from wheelhop.logger.clock import ClockError
from wheelhop.logger.error import LoggerError
from wheelhop.logger.frames import Acknowledgement
from wheelhop.logger.settings import Settings, find_settings

CODES = 1024
CLIPPED = (4, CODES - 5)
"""Beyond these codes the sensor or the converter is at its end."""
KEPT_SCANS = 8192  # 20 s at the highest rate
RATE_WINDOW_S = 2.0


UNTOLD = Settings(100, 8, ())  # until a header comes


@dataclass
class Live:
    """The state of a recording, kept up to date by it and read by whoever shows it.

    `written` and `lost` are scans in and missing from the host's file, `told` what the logger last
    said of its card. Scans are shared with other threads through `window` and `after`.
    """

    port: str = ""
    connected: bool = True
    session: int | None = None
    file: Path | None = None
    channels: tuple[str, ...] = ()
    rate_hz: int = 100
    scan: Settings = UNTOLD
    written: int = 0
    lost: int = 0
    told: Acknowledgement | None = None
    card: str = ""
    supply_mv: int = 0
    clock: ClockError | None = None
    broken: int = 0  # pieces of the line that were no frames
    messages: deque[str] = field(default_factory=lambda: deque(maxlen=100))
    _scans: deque[tuple[float, bytes]] = field(default_factory=lambda: deque(maxlen=KEPT_SCANS))
    _count: int = 0  # of scans ever
    _lock: Lock = field(default_factory=Lock)

    def describe(self, header: dict[str, str]) -> None:
        """Take the settings over; what does not make sense is left as it was."""
        channels = tuple(name for name in header.get("channels", "").split() if name != "-")
        rate_hz = number_or(header.get("rate_hz"), self.rate_hz)
        with self._lock:
            if (channels, rate_hz) != (self.channels, self.rate_hz):
                self._scans.clear()
            self.channels, self.rate_hz = channels, rate_hz
            self.scan = find_settings(header) or self.scan
            self.supply_mv = number_or(header.get("supply_mv"), 0)

    def add(self, at_s: float, stored: bytes, missing: int = 0) -> None:
        """A scan has come; so many before it have not."""
        gap = min(missing, KEPT_SCANS)
        with self._lock:
            self._scans.extend([(at_s, b"")] * gap)
            self._scans.append((at_s, stored))
            self._count += gap + 1

    def say(self, message: str) -> None:
        """Something a user should read."""
        self.messages.append(message)

    def window(self, seconds: float) -> NDArray[np.float64]:
        """(n, channels) mean codes of the last so many seconds, without scans that are missing."""
        with self._lock:
            most = max(round(seconds * self.rate_hz), 1)
            codes = self._codes([stored for _, stored in list(self._scans)[-most:]])
        here: NDArray[np.float64] = codes[~np.isnan(codes).any(axis=1)]
        return here

    def after(self, count: int) -> tuple[int, NDArray[np.float64]]:
        """How many scans there ever were, and the codes of those behind the first `count`, as far
        as they are kept: (n, channels), NaN where one is missing."""
        with self._lock:
            new = min(self._count - count, len(self._scans))
            recent = [stored for _, stored in list(self._scans)[len(self._scans) - new :]]
            return self._count, self._codes(recent)

    def measured_rate_hz(self) -> float:
        """Scans that came in a second of the host's, of late; 0 if hardly any did."""
        with self._lock:
            recent = list(self._scans)[-round(RATE_WINDOW_S * self.rate_hz) :]
        times = [at_s for at_s, stored in recent if stored]
        span = times[-1] - times[0] if len(times) > 1 else 0.0
        return (len(times) - 1) / span if span > 0 else 0.0

    def _codes(self, stored: list[bytes]) -> NDArray[np.float64]:
        count = len(self.channels)
        bits = self.scan.sum_bits
        size = scan_bytes(count, bits)
        here = [len(scan) == size for scan in stored]
        codes = np.full((len(stored), count), np.nan)
        if count and any(here):
            whole = b"".join(scan for scan in stored if len(scan) == size)
            codes[here] = self.scan.codes(unpack_scans(whole, count, bits))
        return codes


def number_or(text: str | None, otherwise: int) -> int:
    """A number above 0 as a header tells it, or something else where it does not."""
    return int(text) if text and text.isdecimal() and int(text) > 0 else otherwise


INTERVAL_S = 0.1
MOST_STREAMS = 8
MOST_CONNECTIONS = 32
PATIENCE_S = 10.0  # for a request, or a reader that does not read
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)


class LivePlot(Closing):
    """Serves `live` at `url`, on the loopback interface alone, while the `with` block lasts.

    `port` 0: any that is free. Raises LoggerError if the port is taken.
    """

    def __init__(self, live: Live, port: int = 0) -> None:
        closing = Event()
        page = (files("wheelhop.logger") / "live.html").read_bytes()

        class Handler(_Handler):
            pass

        token = secrets.token_urlsafe(16)
        Handler.live, Handler.page, Handler.closing = live, page, closing
        Handler.token, Handler.streams = token, BoundedSemaphore(MOST_STREAMS)
        try:
            self._server = _Server(("127.0.0.1", port), Handler)
        except OSError as error:
            raise LoggerError(f"--plot-port {port}: {error.strerror}; take another") from None
        self._server.daemon_threads = True
        Handler.place = f"127.0.0.1:{self._server.server_port}"
        self._closing = closing
        self.url = f"http://127.0.0.1:{self._server.server_port}/{token}/"
        self._thread = Thread(target=self._server.serve_forever, daemon=True, name="live plot")
        self._thread.start()

    def close(self) -> None:
        """End the server and its streams."""
        self._closing.set()
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    """Takes no more connections at a time than a person has windows."""

    def __init__(self, address: tuple[str, int], handler: type[BaseHTTPRequestHandler]) -> None:
        super().__init__(address, handler)
        self._free = BoundedSemaphore(MOST_CONNECTIONS)

    def process_request(self, request: Any, client_address: Any) -> None:
        if not self._free.acquire(blocking=False):
            self.shutdown_request(request)
            return
        super().process_request(request, client_address)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Nothing: a browser may leave at any time, and the terminal is for the recording."""


class _Handler(BaseHTTPRequestHandler):
    timeout = PATIENCE_S
    live: Live
    page: bytes
    closing: Event
    token: str
    place: str  # host and port
    streams: BoundedSemaphore

    def do_GET(self) -> None:
        """The page, or the stream of events (text/event-stream) that feeds it."""
        place = self.place
        own = self.headers.get_all("Host") == [place]
        from_ = self.headers.get("Origin", f"http://{place}")
        site = self.headers.get("Sec-Fetch-Site", "none")
        if not own or from_ != f"http://{place}" or site not in ("none", "same-origin"):
            self.send_error(403)
        elif not self._has_token():
            self.send_error(404)
        elif self.path.endswith("/"):
            self._answer("text/html; charset=utf-8")
            self.wfile.write(self.page)
        elif self.streams.acquire(blocking=False):
            try:
                self._answer("text/event-stream")
                self._stream()
            finally:
                self.streams.release()
        else:
            self.send_error(503)

    def _has_token(self) -> bool:
        known = (f"/{self.token}/", f"/{self.token}/events")
        return any([secrets.compare_digest(self.path.encode(), path.encode()) for path in known])

    def log_message(self, format: str, *args: object) -> None:
        """Nothing: the terminal is for the recording."""

    def _answer(self, kind: str) -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        self.send_header("Content-Security-Policy", POLICY)
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.end_headers()

    def _stream(self) -> None:
        count = 0
        while not self.closing.is_set():
            count, codes = self.live.after(count)
            rows = [None if row[0] != row[0] else row for row in codes.round(1).tolist()]
            told = json.dumps({**facts(self.live), "codes": rows})
            try:
                self.wfile.write(f"data: {told}\n\n".encode())
                self.wfile.flush()
            except OSError:  # the page was closed
                return
            self.closing.wait(INTERVAL_S)


def facts(live: Live) -> dict[str, object]:
    """What the page says in words."""
    told, clock = live.told, live.clock
    return {
        "channels": live.channels,
        "rate_hz": live.rate_hz,
        "measured_hz": round(live.measured_rate_hz(), 1),
        "file": live.file.name if live.file else "",
        "connected": live.connected,
        "written": live.written,
        "missing": live.lost,
        "card": f"{told.written} scans safe, {told.lost} lost" if told else live.card,
        "stall_ms": told.stall_ms if told else 0,
        "supply_mv": live.supply_mv,
        "clock_ppm": round(clock.ppm) if clock else None,
        "clock_deviation_ppm": round(2 * clock.deviation_ppm) if clock else None,
    }
