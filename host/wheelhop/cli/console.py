"""Where the commands print: coloured and fitted to the terminal, plain text elsewhere."""

import sys

from rich.console import Console

PLAIN_WIDTH = 120


def open_console() -> Console:
    """A console on stdout; into a pipe or file it writes no colours and does not fold tables."""
    return Console(highlight=False, width=None if sys.stdout.isatty() else PLAIN_WIDTH)
