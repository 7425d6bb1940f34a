"""What `wheelhop identify` and `wheelhop thesis` take."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any


def add_identify(commands: Any) -> None:
    """Add both commands."""
    identify = commands.add_parser("identify", help="fit a transfer matrix from axles to body")
    identify.add_argument(
        "source", metavar="CAMPAIGN", type=Path, help="a campaign's folder, or STEPS.csv"
    )
    identify.add_argument(
        "--order", metavar="N", type=_order, help="number of poles (default: by held-out runs)"
    )
    identify.add_argument(
        "--start",
        metavar="HZ:ZETA,…",
        type=_modes,
        help="where the modes begin, such as 2.4:0.3,5:0.3 (default: found)",
    )
    identify.add_argument(
        "--structure",
        choices=("reciprocal", "symmetric", "free"),
        default="reciprocal",
        help="reciprocal: H/D symmetric (default); symmetric: H itself, as in the thesis",
    )
    for name, what in (
        ("left-right", "the left side need not mirror the right"),
        ("rigid", "the body need not follow raised axles at 0 Hz; of steps: need not begin at 0"),
        ("stable", "poles need not decay"),
    ):
        identify.add_argument(
            f"--no-{name}", dest=name.replace("-", "_"), action="store_false", help=what
        )
    identify.add_argument(
        "--fore-aft",
        action="store_true",
        help="take the axles' accelerations along x as inputs, too: eight inputs",
    )
    identify.add_argument(
        "--physics", action="store_true", help="fit without each piece of physics, too"
    )
    identify.add_argument(
        "--study",
        metavar="WHAT=FACTOR,…",
        type=_study,
        help="vary the car, such as front-stiffness=1,1.25,1.5 or, at both ends, stiffness=1,1.2",
    )
    identify.add_argument(
        "--study-corner",
        metavar="N",
        type=int,
        choices=(1, 2, 3, 4),
        default=1,
        help="the corner whose ground and body are studied (default 1, front left)",
    )
    identify.add_argument(
        "--bushing",
        metavar="FILE.toml",
        type=Path,
        help="for the study: a specimen of wheelhop bushing in line with each strut; then"
        " front-bushing, rear-bushing and bushing may be varied, too",
    )
    identify.add_argument(
        "--half-car",
        choices=("left", "right", "front", "rear"),
        help="the generalized half car of a side or an axle: two grounds to two body points",
    )
    identify.add_argument(
        "--frf",
        choices=("H1", "H2", "Hv"),
        help="estimate frequency responses without a model: noise on outputs, inputs, both",
    )
    identify.add_argument(
        "--frf-lines", metavar="N", type=_count, default=9, help="lines averaged over (default 9)"
    )
    identify.add_argument("--study-figure", metavar="FILE.png", type=Path, help="draw the study")
    identify.add_argument("--figure", metavar="FILE.png", type=Path, help="draw H with its bands")
    identify.add_argument(
        "--report",
        metavar="FILE",
        type=Path,
        help="write a page: H, and every run as H predicts it; .html, or .pdf",
    )
    identify.add_argument("--mat", metavar="FILE.mat", type=Path, help="write H for MATLAB")
    identify.add_argument(
        "--force-N", metavar="N", type=float, default=1.0, help="of the steps (default 1)"
    )
    identify.add_argument(
        "--vehicle", metavar="FILE.toml", type=Path, help="for a study of STEPS.csv: its car"
    )
    thesis = commands.add_parser(
        "thesis", help="the thesis's tables, recomputed beside the printed"
    )
    thesis.add_argument(
        "--figures", metavar="FOLDER", type=Path, help="draw its figures, and make a page of them"
    )
    thesis.add_argument(
        "--frame", metavar="FILE.toml", type=Path, help="draw figure 6.1 with a frame of beams"
    )
    for command in (identify, thesis):
        command.add_argument("--json", metavar="FILE", type=Path, help="write the result as JSON")


MOST_POLES = 100
"""Fifty modes are more than any band of a vehicle holds; time grows with the cube of the order."""


def _order(text: str) -> int:
    poles = _count(text)
    if poles > MOST_POLES:
        raise argparse.ArgumentTypeError(f"{poles} poles: take at most {MOST_POLES}")
    return poles


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 1 up")
    return int(text)


def _modes(text: str) -> list[tuple[float, float]]:
    try:
        modes = [tuple(map(float, pair.split(":"))) for pair in text.split(",")]
    except ValueError:
        modes = []
    if not modes or any(len(mode) != 2 or not mode[0] > 0 for mode in modes):
        raise argparse.ArgumentTypeError(f"'{text}' is not HZ:ZETA,HZ:ZETA,…")
    return [(mode[0], mode[1]) for mode in modes]


def _study(text: str) -> tuple[str, list[float]]:
    varied, _, numbers = text.partition("=")
    try:
        factors = [float(number) for number in numbers.split(",")]
    except ValueError:
        factors = []
    if not varied or not factors or not all(0 < factor < 1e3 for factor in factors):
        raise argparse.ArgumentTypeError(f"'{text}' is not WHAT=FACTOR,FACTOR,…")
    return varied, factors
