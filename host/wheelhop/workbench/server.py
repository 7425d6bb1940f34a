"""The workbench's server: one campaign, one address with a token, until Ctrl-C."""

from __future__ import annotations

import secrets
import socket
import sys
import time
import webbrowser
from collections.abc import Callable
from contextlib import asynccontextmanager
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING

import uvicorn
from fastapi import FastAPI, HTTPException
from fastapi.responses import FileResponse
from nicegui import ui

from wheelhop.campaign import CampaignError
from wheelhop.workbench.bench import Workbench
from wheelhop.workbench.guard import Guard
from wheelhop.workbench.out_view import REPORT_ADDRESS
from wheelhop.workbench.page import lay_out
from wheelhop.workbench.takeaway import REPORT

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

LOCAL = "127.0.0.1"
AHEAD_S = 2.0
REPORT_POLICY = "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:"
"""A report may have come with somebody's campaign: it shows, and does nothing."""
PATIENCE_S = 3600.0
"""So long a page that lost its connection, on a closed laptop, finds what it showed."""


def serve(
    folder: Path | None,
    *,
    effects_file: Path | None = None,
    emulated: bool = False,
    host: str = LOCAL,
    port: int = 0,
    browse: bool = True,
    tell: Callable[[str], None] = print,
    progress: Callable[[str], None] = lambda text: None,
) -> None:
    """Open a campaign on the workbench, or none yet, and serve it until interrupted.

    ``port`` 0 takes any that is free; ``tell`` is given the address; ``emulated`` switches on an
    emulated logger; ``progress`` is told how far reading is. Raises CampaignError for a campaign
    that cannot be read, a folder that has a workbench already, and an address that is taken.
    """
    bench = Workbench(effects_file)
    if folder is not None:
        bench.put(folder, progress)
    if emulated:
        bench.recorder.emulate()
    with _bound(host, port) as listening:
        port = listening.getsockname()[1]
        token = secrets.token_urlsafe(24)
        names = {host, "localhost"} if host == LOCAL else {host}
        guard = Guard(make_app(bench), token, frozenset(f"{name}:{port}" for name in names))
        address = f"http://{host}:{port}/?token={token}"
        tell(f"the workbench is at {address}")
        if browse:
            webbrowser.open(address)
        config = uvicorn.Config(guard, log_level="warning", timeout_graceful_shutdown=1)
        uvicorn.Server(config).run(sockets=[listening])


def make_app(bench: Workbench) -> FastAPI:
    """The application that shows a bench; its work begins and ends with the server."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        if bench.desk is not None:
            bench.desk.begin()
        Thread(target=_load_ahead, daemon=True).start()
        yield
        bench.close()

    app = FastAPI(lifespan=lifespan)

    @ui.page("/")
    def index() -> None:
        lay_out(bench)

    @app.get(REPORT_ADDRESS)
    def report() -> FileResponse:
        desk = bench.desk
        if desk is None or not (desk.campaign.folder / REPORT).is_file():
            raise HTTPException(404, "there is no report yet")
        headers = {"content-security-policy": REPORT_POLICY}
        return FileResponse(desk.campaign.folder / REPORT, headers=headers)

    ui.run_with(app, title="wheelhop", dark=None, reconnect_timeout=PATIENCE_S, tailwind=False)
    return app


def _load_ahead() -> None:
    """What only some views need is loaded after the first page is there, before it is asked for."""
    time.sleep(AHEAD_S)
    import wheelhop.workbench.log_in_view  # noqa: F401


def _bound(host: str, port: int) -> socket.socket:
    listening = socket.socket()
    if sys.platform != "win32":  # there it would let two servers share a port
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((host, port))
        listening.listen()  # a browser that comes before the server is up waits
    except OSError as error:
        listening.close()
        line = f"cannot listen on {host}:{port}: {error.strerror}; choose another --port"
        raise CampaignError(line) from None
    return listening
