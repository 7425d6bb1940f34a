"""What `wheelhop plan` takes."""

from pathlib import Path
from typing import Any


def add_plan(commands: Any) -> None:
    """Add the command; makes it without loading any other package."""
    plan = commands.add_parser(
        "plan", help="choose the runs that would tell most, before anyone has driven"
    )
    plan.add_argument(
        "vehicle", metavar="VEHICLE.toml", type=Path, help="the vehicle, as it is believed to be"
    )
    plan.add_argument(
        "--tracks",
        metavar="TRACK",
        nargs="+",
        required=True,
        help="those there are, as wheelhop simulate takes them: washboard/low, table-5.1, …",
    )
    plan.add_argument(
        "--speeds",
        metavar="KMPH",
        nargs="+",
        type=float,
        default=[],
        help="km/h at which each could be driven (default: those the thesis drove a named track"
        " at)",
    )
    budget = plan.add_mutually_exclusive_group()
    budget.add_argument("--runs", metavar="N", type=int, help="how many to choose (default 8)")
    budget.add_argument("--minutes", metavar="M", type=float, help="of recording, instead")
    plan.add_argument(
        "--only",
        metavar="EFFECT",
        nargs="+",
        default=[],
        help="effects to tell apart (default: all but faults of sensors)",
    )
    plan.add_argument(
        "--library", metavar="FILE.py", type=Path, help="a file with effects of your own"
    )
    plan.add_argument(
        "--noise", metavar="RMS", type=float, help="of a channel in band, m/s² (default 0.1)"
    )
    plan.add_argument("--seconds", metavar="S", type=float, help="length of a run (default 10.24)")
    plan.add_argument("--json", metavar="FILE", type=Path, help="write the plan as JSON")
    plan.add_argument("--figure", metavar="FILE.png", type=Path, help="draw it")
    plan.add_argument(
        "--out", metavar="FOLDER", type=Path, help="begin a campaign that lists the runs to drive"
    )
