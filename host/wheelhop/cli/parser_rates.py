"""What `wheelhop rates` takes."""

from pathlib import Path
from typing import Any


def add_rates(commands: Any) -> None:
    """Add the command; makes it without loading any room."""
    rates = commands.add_parser("rates", help="from strut, damper and linkage to the wheel's rates")
    rates.add_argument(
        "strut", metavar="STRUT.csv", type=Path, help="displacement_mm, force_N from the rig"
    )
    rates.add_argument(
        "damper", metavar="DAMPER.csv", type=Path, help="velocity_mm_s, force_N of its chart"
    )
    rates.add_argument(
        "--motion-ratio",
        metavar="RATIO",
        required=True,
        help="strut over wheel: a number, or a CSV of wheel_travel_mm and strut_travel_mm, or"
        " motion_ratio",
    )
    rates.add_argument(
        "--ride", metavar="MM", type=float, help="displacement at ride height (default: the middle)"
    )
    rates.add_argument(
        "--travel",
        metavar="MM",
        type=float,
        help="of the wheel, up and down, for which one number has to do (default: all)",
    )
    rates.add_argument("--axle", choices=("front", "rear"), help="whose numbers --into replaces")
    rates.add_argument(
        "--into", metavar="VEHICLE.toml", type=Path, help="write them into this vehicle"
    )
    rates.add_argument("--json", metavar="FILE", type=Path, help="write the result as JSON")
    rates.add_argument("--figure", metavar="FILE.png", type=Path, help="draw curves and numbers")
