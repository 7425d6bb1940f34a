"""What `wheelhop modes` and `wheelhop spectra` take."""

import argparse
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


def add_spectra(commands: Any) -> None:
    """Add `wheelhop spectra`."""
    spectra = commands.add_parser(
        "spectra", help="compare runs on roads known by their spectrum: power, peaks, coherence"
    )
    spectra.add_argument("campaign", metavar="CAMPAIGN", type=Path, help="a campaign's folder")
    spectra.add_argument(
        "--road",
        metavar="C:W",
        type=_road,
        help="unevenness, m³, and waviness of the road of all runs, such as 6.7e-4:1.36 (default:"
        " those of the runs on iso8608)",
    )
    spectra.add_argument("--json", metavar="FILE", type=Path, help="write all numbers as JSON")
    spectra.add_argument("--figure", metavar="FILE.png", type=Path, help="draw all runs")


def _road(text: str) -> tuple[float, float]:
    try:
        unevenness, waviness = map(float, text.split(":"))
    except ValueError:
        unevenness = waviness = 0.0
    if not (0.0 < unevenness < 1.0 and 0.5 <= waviness <= 4.0):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not C:W, an unevenness in m³ and a waviness of 0.5 to 4"
        )
    return unevenness, waviness
