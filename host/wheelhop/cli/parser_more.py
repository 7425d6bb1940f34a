"""What `wheelhop emulate` and `wheelhop completion` take."""

from pathlib import Path
from typing import Any

FACTOR = 10.0


def add_emulate(commands: Any) -> None:
    """Add the command; makes it without loading any room."""
    emulate = commands.add_parser("emulate", help="a logger that is none, to try things out with")
    emulate.add_argument(
        "--card", metavar="FOLDER", type=Path, help="what is its card (default: gone at the end)"
    )
    emulate.add_argument(
        "--factor", metavar="X", type=float, default=FACTOR, help=f"times faster ({FACTOR:g})"
    )


def add_completion(commands: Any) -> None:
    """Add the command; makes it without loading any room."""
    completion = commands.add_parser("completion", help="print what a shell needs to complete")
    completion.add_argument("shell", choices=("bash", "zsh", "tcsh"))
