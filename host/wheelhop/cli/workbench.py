"""`wheelhop workbench`: a campaign in the browser."""

from __future__ import annotations

import sys
from argparse import Namespace

from wheelhop.workbench.server import LOCAL, serve


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
    )
    return 0
