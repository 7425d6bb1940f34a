"""What `wheelhop workbench` takes."""

from pathlib import Path
from typing import Any


def add_workbench(commands: Any) -> Any:
    """Add the command and return it; makes it without loading any other package."""
    workbench = commands.add_parser("workbench", help="see, ask and add in the browser")
    workbench.add_argument(
        "campaign", metavar="CAMPAIGN", nargs="?", type=Path, help="the folder (default: ask)"
    )
    workbench.add_argument(
        "--port", metavar="N", type=int, default=0, help="where it listens (default: any)"
    )
    workbench.add_argument(
        "--host",
        metavar="ADDRESS",
        default="127.0.0.1",
        help="who may reach it (default: this computer alone)",
    )
    workbench.add_argument(
        "--emulated", action="store_true", help="with an emulated logger to record from"
    )
    workbench.add_argument("--no-browser", action="store_true", help="only print the address")
    return workbench
