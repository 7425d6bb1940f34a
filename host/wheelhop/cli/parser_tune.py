"""What `wheelhop tune` takes."""

from pathlib import Path
from typing import Any


def add_tune(commands: Any) -> None:
    """Add the command; makes it without importing what it calls."""
    tune = commands.add_parser(
        "tune", help="search the settings of a known car that are best on the roads it drives"
    )
    tune.add_argument(
        "car",
        metavar="CAMPAIGN|MODEL.toml|VEHICLE.toml",
        type=Path,
        help="a campaign in which wheelhop add has stored its model, or a file",
    )
    tune.add_argument(
        "--vary",
        metavar="NAME=RANGE",
        nargs="+",
        required=True,
        help="front.damping=±50%%, rear.stiffness=8000:12000, front.springs=springs.csv,"
        " front.damper=valves.csv:now=8, dry-friction.front_N=20:80",
    )
    tune.add_argument(
        "--tracks",
        metavar="TRACK",
        nargs="+",
        default=[],
        help="as wheelhop simulate takes them (default: the campaign's runs)",
    )
    tune.add_argument(
        "--speed",
        metavar="KMPH",
        nargs="+",
        type=float,
        default=[],
        help="km/h (default: those the thesis drove a named track at)",
    )
    tune.add_argument(
        "--objective",
        metavar="A,B,…",
        default="comfort,road-holding,travel",
        help="what shall be small: comfort, road-holding, travel, roll (default the first 3)",
    )
    tune.add_argument(
        "--library", metavar="FILE.py", type=Path, help="a file with effects of your own"
    )
    tune.add_argument(
        "--settings", metavar="N", type=int, help="how many the search rides (default 800)"
    )
    tune.add_argument("--seconds", metavar="S", type=float, help="length of a run (default 10.24)")
    tune.add_argument("--seed", metavar="N", type=int, default=0, help="of all that is drawn")
    tune.add_argument("--json", metavar="FILE", type=Path, help="write what was found as JSON")
    tune.add_argument("--report", metavar="FILE.html", type=Path, help="write the page")
