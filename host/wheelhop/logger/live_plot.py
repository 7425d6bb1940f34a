"""The live plot: a page of our own and its data, for a browser on this computer.

Other pages in that browser, and other users of this computer, can reach the port. So nothing is
answered without the token in the address, nor to another name for this host (DNS rebinding) or a
request that another page has made; and the page may load nothing but itself.
"""

import json
import secrets
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from threading import BoundedSemaphore, Event, Thread
from types import TracebackType
from typing import Any

from wheelhop.logger.error import LoggerError
from wheelhop.logger.live import Live

INTERVAL_S = 0.1
MOST_STREAMS = 8
MOST_CONNECTIONS = 32
PATIENCE_S = 10.0  # for a request, or a reader that does not read
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)


class LivePlot:
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

    def __enter__(self) -> "LivePlot":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


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
