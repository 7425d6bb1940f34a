"""The workbench's server: one campaign, one address with a token, until Ctrl-C."""

from __future__ import annotations

import secrets
import socket
import sys
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from wheelhop.campaign import CampaignError
from wheelhop.files import require
from wheelhop.workbench.bench import Workbench
from wheelhop.workbench.guard import EVERYWHERE, LOCAL, Guard, known_as

ELSEWHERE = "192.0.2.1"  # TEST-NET-1, RFC 5737: nobody's
CLIENTS = ("aiohttp", "requests", "tornado")
"""What the page's framework loads for programs that talk to it. Ours are browsers."""


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
    that cannot be read, a folder that has a workbench already, and an address that is taken;
    InputError where NiceGUI is not installed.
    """
    require("nicegui", "the workbench", "workbench")
    bench = Workbench(effects_file)
    if folder is not None:
        bench.put(folder, progress)
    if emulated:
        bench.recorder.emulate()
    with _bound(host, port) as listening:
        port = listening.getsockname()[1]
        token = secrets.token_urlsafe(24)
        address = f"http://{_reached_at(host)}:{port}/?token={token}"
        tell(f"the workbench is at {address}")
        if browse:
            webbrowser.open(address)
        # A browser takes a second to start: the framework is loaded meanwhile.
        with _without(CLIENTS):
            import uvicorn

            from wheelhop.workbench.app import make_app

        far = host != LOCAL
        config = uvicorn.Config(
            Guard(make_app(bench, far), token, known_as(host), port),
            log_level="warning",
            timeout_graceful_shutdown=1,
            ws_per_message_deflate=far,
        )
        uvicorn.Server(config).run(sockets=[listening])


@contextmanager
def _without(packages: tuple[str, ...]) -> Iterator[None]:
    """Within it these packages are as if they were not installed, unless they are loaded."""
    hidden = {name: None for name in packages if name not in sys.modules}
    sys.modules.update(hidden)  # type: ignore[arg-type]
    try:
        yield
    finally:
        for name in hidden:
            del sys.modules[name]


def _reached_at(host: str) -> str:
    """The address by which others reach a server that listens on `host`: that of the interface to
    the network where it listens on all."""
    if host != EVERYWHERE:
        return host
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((ELSEWHERE, 9))  # sends nothing: it only chooses the interface
        except OSError:
            return LOCAL
        return str(probe.getsockname()[0])


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
