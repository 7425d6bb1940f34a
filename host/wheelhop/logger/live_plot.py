"""The live plot: a page of our own and its data, for a browser on this computer."""

import json
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from threading import Event, Thread
from types import TracebackType

from wheelhop.logger.error import LoggerError
from wheelhop.logger.live import Live

INTERVAL_S = 0.1


class LivePlot:
    """Serves `live` at `url`, on the loopback interface alone, while the `with` block lasts.

    `port` 0: any that is free. Raises LoggerError if the port is taken.
    """

    def __init__(self, live: Live, port: int = 0) -> None:
        closing = Event()
        page = (files("wheelhop.logger") / "live.html").read_bytes()

        class Handler(_Handler):
            pass

        Handler.live, Handler.page, Handler.closing = live, page, closing
        try:
            self._server = ThreadingHTTPServer(("127.0.0.1", port), Handler)
        except OSError as error:
            raise LoggerError(f"--plot-port {port}: {error.strerror}; take another") from None
        self._server.daemon_threads = True
        self._closing = closing
        self.url = f"http://127.0.0.1:{self._server.server_port}/"
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


class _Handler(BaseHTTPRequestHandler):
    live: Live
    page: bytes
    closing: Event

    def do_GET(self) -> None:
        """The page, or the stream of events (text/event-stream) that feeds it."""
        if self.path == "/":
            self._answer("text/html; charset=utf-8")
            self.wfile.write(self.page)
        elif self.path == "/events":
            self._answer("text/event-stream")
            self._stream()
        else:
            self.send_error(404)

    def log_message(self, format: str, *args: object) -> None:
        """Nothing: the terminal is for the recording."""

    def _answer(self, kind: str) -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
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
