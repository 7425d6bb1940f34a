"""What the server serves: the page of a bench, and its report."""

from __future__ import annotations

import re
import time
from contextlib import asynccontextmanager
from importlib.resources import files
from threading import Thread
from typing import TYPE_CHECKING

from fastapi import FastAPI, HTTPException, Response
from fastapi.middleware.gzip import GZipMiddleware
from fastapi.responses import FileResponse
from jinja2 import DictLoader
from nicegui import ui
from nicegui.client import templates

from wheelhop.workbench.bench import Workbench
from wheelhop.workbench.guard import NONCE
from wheelhop.workbench.out_view import REPORT_ADDRESS, TAKEN
from wheelhop.workbench.page import OWN, OWN_FILES, THEME, lay_out
from wheelhop.workbench.takeaway import REPORT, WHAT, packed
from wheelhop.workbench.theme import theme_css

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

AHEAD_S = 2.0
FRAME = "index.html"
REPORT_POLICY = "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:"
"""A report may have come with somebody's campaign: it shows, and does nothing."""
PATIENCE_S = 3600.0
"""So long a page that lost its connection, on a closed laptop, finds what it showed."""


def make_app(bench: Workbench, far: bool) -> FastAPI:
    """The application that shows a bench; its work ends with the server. What goes over a network
    (`far`) is compressed; on the way to a browser beside the server that only takes time."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        Thread(target=_load_ahead, daemon=True).start()
        yield
        bench.close()

    app = FastAPI(lifespan=lifespan, openapi_url=None)
    _mark_scripts()

    @ui.page("/", language="en-US")
    def index() -> None:
        lay_out(bench)

    @app.get(f"{OWN}/{{name}}")
    def own(name: str) -> Response:
        if name not in OWN_FILES:
            raise HTTPException(404, "there is no such file")
        package, kind = OWN_FILES[name]
        if name == THEME:
            return Response(theme_css(), media_type=kind)
        return Response((files(package) / name).read_bytes(), media_type=kind)

    @app.get(REPORT_ADDRESS)
    def report() -> FileResponse:
        desk = bench.desk
        if desk is None or not (desk.campaign.folder / REPORT).is_file():
            raise HTTPException(404, "there is no report yet")
        headers = {"content-security-policy": REPORT_POLICY}
        return FileResponse(desk.campaign.folder / REPORT, headers=headers)

    @app.get(f"{TAKEN}/{{name}}")
    def take(name: str) -> Response:
        """What was written, to be kept elsewhere: a file as it is, a folder as an archive."""
        path = None if bench.desk is None else bench.desk.campaign.folder / name
        if path is None or name not in WHAT or not path.exists():
            raise HTTPException(404, "there is no such file yet")
        headers = {"content-security-policy": REPORT_POLICY}
        if path.is_file():
            return FileResponse(path, filename=name, headers=headers)
        headers = {"content-disposition": f'attachment; filename="{name}.zip"'}
        return Response(packed(path), media_type="application/zip", headers=headers)

    ui.run_with(
        app,
        title="wheelhop",
        dark=None,
        reconnect_timeout=PATIENCE_S,
        tailwind=False,
        gzip_middleware_factory=GZipMiddleware if far else None,
    )
    return app


def _mark_scripts() -> None:
    """Give the scripts in the frame of the framework's pages the nonce of each answer; what is put
    into that frame is not marked."""
    environment = templates.env
    assert environment.loader is not None
    frame, _, _ = environment.loader.get_source(environment, FRAME)
    marked = re.sub(
        r"<script(?! nonce)", f"<script nonce=\"{{{{ request.scope['{NONCE}'] }}}}\"", frame
    )
    environment.loader = DictLoader({FRAME: marked})


def _load_ahead() -> None:
    """What only some views need is loaded after the first page is there, before it is asked for."""
    time.sleep(AHEAD_S)
    import wheelhop.workbench.log_in_view  # noqa: F401
