"""`wheelhop workbench`: a campaign in the browser."""

from __future__ import annotations

import sys
import time
from argparse import Namespace
from collections.abc import Callable

from wheelhop.workbench.guard import LOCAL
from wheelhop.workbench.server import serve

EVERY_S = 2.0


def run(arguments: Namespace) -> int:
    """Serve the workbench until Ctrl-C; raises CampaignError."""
    if arguments.host != LOCAL:
        print(
            f"wheelhop: everybody who can reach {arguments.host} and has the address can use this"
            " workbench, and what he sends and sees is not encrypted",
            file=sys.stderr,
        )
    serve(
        arguments.campaign,
        effects_file=arguments.effects,
        emulated=arguments.emulated,
        host=arguments.host,
        port=arguments.port,
        browse=not arguments.no_browser,
        tell=lambda line: print(f"{line}\nCtrl-C ends it", flush=True),
        progress=_said(),
    )
    return 0


def _said() -> Callable[[str], None]:
    """A function that prints what it is told on stderr, at once and then every two seconds."""
    last_s = -EVERY_S

    def show(text: str) -> None:
        nonlocal last_s
        if time.monotonic() - last_s >= EVERY_S:
            last_s = time.monotonic()
            print(text, file=sys.stderr, flush=True)

    return show
