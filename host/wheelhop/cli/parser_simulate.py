"""What `wheelhop simulate` and the other commands that foretell take."""

from pathlib import Path
from typing import Any

from wheelhop.cli.parser_export import add_export
from wheelhop.cli.parser_modes import add_modes, add_spectra
from wheelhop.cli.parser_plan import add_plan
from wheelhop.cli.parser_tune import add_tune


def add_prediction(commands: Any) -> None:
    """Add the commands of simulation as a tool."""
    add_simulate(commands)
    add_road(commands)
    add_modes(commands)
    add_spectra(commands)
    add_plan(commands)
    add_tune(commands)
    add_export(commands)


def add_simulate(commands: Any) -> None:
    """Add the command; makes it without loading any other package."""
    simulate = commands.add_parser(
        "simulate", help="drive a vehicle over tracks: a campaign, a recording, or a sweep"
    )
    simulate.add_argument(
        "vehicle", metavar="VEHICLE.toml", type=Path, help="the vehicle, such as vehicle.toml"
    )
    simulate.add_argument(
        "--tracks",
        metavar="TRACK",
        nargs="+",
        required=True,
        help="washboard/low, table-5.1 (all of them), or KIND:KEY=VALUE:…, such as"
        " washboard:amplitude_mm=15:pitch_mm=400, profile:file=road.csv",
    )
    simulate.add_argument(
        "--speed",
        metavar="KMPH",
        nargs="+",
        default=[],
        help="km/h, one or more, or along the track, m:km/h, such as 0:5,20:12 (default: those the"
        " thesis drove a named track at)",
    )
    simulate.add_argument(
        "--with",
        dest="effects",
        metavar="EFFECT[:PARAM=VALUE]",
        nargs="+",
        default=[],
        help="effects the vehicle has; what is not stated is clearly visible",
    )
    simulate.add_argument(
        "--library", metavar="FILE.py", type=Path, help="a file with effects of your own"
    )
    simulate.add_argument(
        "--noise",
        metavar="RMS",
        type=float,
        help="of a channel in band, m/s² (default 0.1)",
    )
    simulate.add_argument(
        "--logger", action="store_true", help="through the logger's double, in 10-bit codes"
    )
    simulate.add_argument(
        "--seconds", metavar="S", type=float, help="length of a run (default 10.24)"
    )
    simulate.add_argument(
        "--seed", metavar="N", type=int, default=0, help="another one draws other noise (default 0)"
    )
    simulate.add_argument(
        "--sweep",
        metavar="NAME=FIRST:LAST:COUNT",
        nargs="+",
        default=[],
        help="speed (km/h), a number of the vehicle (body.mass_kg) or of an effect"
        " (dry-friction.front_N); several make a grid; --out is a table, .parquet",
    )
    simulate.add_argument(
        "--jobs", metavar="N", type=int, help="processes of a sweep (default: one a processor)"
    )
    simulate.add_argument(
        "--cluster", metavar="ADDRESS", help="compute a sweep on a Dask cluster: tcp://HOST:PORT"
    )
    simulate.add_argument(
        "--against",
        metavar="OTHER.toml",
        nargs="+",
        type=Path,
        default=[],
        help="other vehicles on the same runs, to be compared",
    )
    simulate.add_argument(
        "--figure", metavar="FILE.png", type=Path, help="draw the rides of all vehicles"
    )
    simulate.add_argument(
        "--out",
        metavar="PATH",
        type=Path,
        help="a new folder for a campaign, or one recording: .csv, .parquet, .mf4, .uff, .hop",
    )


def add_road(commands: Any) -> None:
    """Add `wheelhop road`."""
    road = commands.add_parser("road", help="tell how rough a track is, and write it as a survey")
    road.add_argument(
        "track", metavar="TRACK", help="as simulate takes them, such as profile:file=road.crg"
    )
    road.add_argument(
        "--length", metavar="M", type=float, help="of what is looked at (default: all, or 200 m)"
    )
    road.add_argument(
        "--step", metavar="M", type=float, help="between stations (default: the survey's, or 0.02)"
    )
    road.add_argument(
        "--width", metavar="M", type=float, help="between the paths (default 1.2; grids: all of it)"
    )
    road.add_argument(
        "--out", metavar="FILE", type=Path, help="two paths as .csv, a grid as .crg or .rdf (Adams)"
    )
    road.add_argument(
        "--plot",
        dest="figure",
        metavar="FILE.png",
        type=Path,
        help="draw ground and wheels' paths over time, at --speed (default: the thesis's)",
    )
    road.add_argument("--speed", metavar="KMPH", nargs="+", type=float, default=[], help="km/h")
    road.add_argument(
        "--vehicle",
        metavar="VEHICLE.toml",
        type=Path,
        help="whose wheels are drawn (default: the thesis's, 22 inch, 1.42 m apart)",
    )
    road.add_argument("--json", metavar="FILE", type=Path, help="write what was found as JSON")
    road.add_argument("--grid", action="store_true", help="write a grid as .csv, too")
