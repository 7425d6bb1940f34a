"""What `wheelhop export` takes."""

from pathlib import Path
from typing import Any


def add_export(commands: Any) -> None:
    """Add the command; makes it without importing what it calls."""
    export = commands.add_parser(
        "export", help="write a known car for other programs: an FMU, or a state space for MATLAB"
    )
    export.add_argument(
        "car",
        metavar="CAMPAIGN|MODEL.toml|VEHICLE.toml",
        type=Path,
        help="a campaign in which wheelhop add has stored its model, or a file",
    )
    export.add_argument(
        "file", metavar="FILE", type=Path, help="CAR.fmu (FMI 2.0 co-simulation) or CAR.mat"
    )
    export.add_argument(
        "--with",
        dest="effects",
        metavar="EFFECT[:PARAM=VALUE]",
        nargs="+",
        default=[],
        help="effects the car has besides",
    )
    export.add_argument(
        "--library", metavar="FILE.py", type=Path, help="a file with effects of your own"
    )
