"""What the commands on parts of a vehicle take: `bushing`, `frame`, `rates`."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def add_bushing(commands: Any) -> None:
    """Add the command; makes it without loading any other package."""
    command = commands.add_parser("bushing", help="find the complex modulus of bushings")
    actions = command.add_subparsers(dest="action", metavar="ACTION", required=True)
    fit = actions.add_parser("fit", help="fit models to what a rig has measured")
    fit.add_argument(
        "data", metavar="DATA", nargs="+", type=Path, help="moduli or signals, or a folder of them"
    )
    fit.add_argument(
        "--model",
        metavar="MODEL",
        action="append",
        help="only this one, or these (default: all)",
    )
    fit.add_argument("--out", metavar="FOLDER", type=Path, help="write SPECIMEN.toml into it")
    fit.add_argument("--json", metavar="FILE", type=Path, help="write the result as JSON")
    fit.add_argument("--report", metavar="FILE", type=Path, help="write a report: .html, or .pdf")
    shift = actions.add_parser("shift", help="bring one specimen's temperatures onto one curve")
    shift.add_argument(
        "data", metavar="FILE=DEGC", nargs="+", help="moduli or signals, and the temperature, °C"
    )
    shift.add_argument(
        "--reference", metavar="DEGC", type=float, default=23.0, help="of the curve (default 23)"
    )
    shift.add_argument(
        "--model", metavar="MODEL", default="fractional-zener", help="default fractional-zener"
    )
    shift.add_argument("--out", metavar="SPECIMEN.toml", type=Path, help="write the specimen")
    shift.add_argument("--json", metavar="FILE", type=Path, help="write the result as JSON")


def add_frame(commands: Any) -> None:
    """Add the command."""
    frame = commands.add_parser("frame", help="find a tubular frame's modes and stiffness")
    frame.add_argument("frame", metavar="FRAME.toml", type=Path, help="nodes, tubes, masses")
    frame.add_argument(
        "--modes", metavar="N", type=int, default=10, help="how many (default 10, at most 200)"
    )
    frame.add_argument("--figure", metavar="FILE.png", type=Path, help="draw the frame, its modes")
    frame.add_argument("--json", metavar="FILE", type=Path, help="write the result as JSON")


def add_rates(commands: Any) -> None:
    """Add the command; makes it without loading any other package."""
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
