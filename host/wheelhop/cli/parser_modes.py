"""What `wheelhop modes` takes."""

from pathlib import Path
from typing import Any


def add_modes(commands: Any) -> None:
    """Add the command; makes it without loading any other package."""
    modes = commands.add_parser(
        "modes", help="vehicles' modes, their energy, what moves them, and transmissibility"
    )
    modes.add_argument(
        "vehicle", metavar="VEHICLE.toml", nargs="+", type=Path, help="one, or several to compare"
    )
    modes.add_argument(
        "--with",
        dest="effects",
        metavar="EFFECT[:PARAM=VALUE]",
        nargs="+",
        default=[],
        help="effects the vehicles have; force laws are left out",
    )
    modes.add_argument(
        "--library", metavar="FILE.py", type=Path, help="a file with effects of your own"
    )
    modes.add_argument(
        "--speed",
        metavar="KMPH",
        type=float,
        help="at which the rear wheels meet waves later (default: all wheels together)",
    )
    modes.add_argument("--json", metavar="FILE", type=Path, help="write all numbers as JSON")
    modes.add_argument("--figure", metavar="FILE.png", type=Path, help="draw all vehicles")
