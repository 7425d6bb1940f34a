"""What `wheelhop frame` takes."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def add_frame(commands: Any) -> None:
    """Add the command."""
    frame = commands.add_parser("frame", help="find a tubular frame's modes and stiffness")
    frame.add_argument("frame", metavar="FRAME.toml", type=Path, help="nodes, tubes, masses")
    frame.add_argument(
        "--modes", metavar="N", type=int, default=10, help="how many (default 10, at most 200)"
    )
    frame.add_argument("--figure", metavar="FILE.png", type=Path, help="draw the frame, its modes")
    frame.add_argument("--json", metavar="FILE", type=Path, help="write the result as JSON")
