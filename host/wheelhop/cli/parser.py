"""The commands of `wheelhop` and what each of them takes."""

import argparse
from pathlib import Path

from wheelhop.cli.one_line import OneLineParser
from wheelhop.cli.parser_formats import add_formats
from wheelhop.cli.parser_identify import add_identify
from wheelhop.cli.parser_new import add_new
from wheelhop.cli.parser_parts import add_bushing, add_frame, add_rates
from wheelhop.cli.parser_simulate import add_prediction
from wheelhop.cli.parser_workbench import add_workbench

BUDGET_S = 60.0
"""What `diagnose` may spend unless told otherwise, as in `wheelhop.diagnose`."""


def make_parser() -> argparse.ArgumentParser:
    """What `wheelhop` understands; makes it without loading any other package."""
    parser = OneLineParser(
        prog="wheelhop",
        description="Find out which physics a suspension model is missing.",
    )
    parser.add_argument(
        "--version", dest="command", action="store_const", const="version", help="print the version"
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")

    _make_analysis(commands)
    _library(add_workbench(commands))
    add_identify(commands)
    add_prediction(commands)
    demo = commands.add_parser("demo", help="from simulated sensors through a logger to a verdict")
    demo.add_argument(
        "folder",
        metavar="FOLDER",
        nargs="?",
        type=Path,
        help="a new folder to put it in (default ./wheelhop-demo, -2, …)",
    )
    demo.add_argument("--workbench", action="store_true", help="then open it in the browser")
    flash = commands.add_parser("flash", help="write the firmware into the logger")
    flash.add_argument("--port", metavar="PORT", help="serial port (default: the only one)")
    flash.add_argument(
        "--hex", metavar="FILE", type=Path, help="firmware (default: what make firmware has built)"
    )
    flash.add_argument("--board", choices=("nano", "mega"), default="nano", help="default nano")
    flash.add_argument(
        "--old-bootloader", action="store_true", help="for Nanos of before 2018 (57600 baud)"
    )
    _make_recording(commands)
    emulate = commands.add_parser("emulate", help="an emulated logger, to try things out with")
    emulate.add_argument(
        "--card", metavar="FOLDER", type=Path, help="what is its card (default: gone at the end)"
    )
    emulate.add_argument(
        "--factor", metavar="X", type=float, default=10.0, help="times faster (default 10)"
    )
    emulate.add_argument(
        "--campaign", metavar="FOLDER", type=Path, help="feel a run of it (default: a field day)"
    )
    emulate.add_argument(
        "--on",
        choices=("shaker", "beam"),
        help="stand on a calibrator's shaker, or on the cantilever",
    )
    emulate.add_argument(
        "--files", metavar="FOLDER", type=Path, help="where the rig's files are put"
    )
    emulate.add_argument("--run", metavar="ID", help="which run of it (default: the first)")
    _make_logs(commands)
    _make_checks(commands)
    add_formats(commands)
    add_bushing(commands)
    add_frame(commands)
    add_rates(commands)
    add_new(commands)
    _make_campaign(commands.add_parser("campaign", help="make a campaign of recordings"))
    completion = commands.add_parser("completion", help="print what a shell needs to complete")
    completion.add_argument("shell", choices=("bash", "zsh", "tcsh"))
    schema = commands.add_parser("schema", help="print the JSON Schema of a file, or of --json")
    schema.add_argument("name", metavar="NAME", nargs="?", help="such as vehicle (default: list)")
    commands.add_parser("version", help="print the version")
    return parser


def _make_analysis(commands: "argparse._SubParsersAction[OneLineParser]") -> None:
    check = commands.add_parser("check", help="read a campaign and show what is in it")
    _campaign(check)
    _library(check)
    _json(check)

    compare = commands.add_parser("compare", help="compare the model with the measurements")
    _campaign(compare)
    compare.add_argument(
        "--add",
        metavar="EFFECT",
        action="append",
        default=[],
        help="make an effect part of the model, more than once if wanted",
    )
    _library(compare)
    _outputs(compare)

    settings = commands.add_parser(
        "settings", help="compare settings of a vehicle over one course, without a model"
    )
    _campaign(settings)
    settings.add_argument(
        "--reference", metavar="NAME", default="", help="the setting compared with (default: first)"
    )
    _outputs(settings)

    diagnose = commands.add_parser("diagnose", help="find out which effects are missing")
    _campaign(diagnose)
    diagnose.add_argument("more", metavar="MORE", nargs="*", type=Path, help="more campaigns")
    diagnose.add_argument(
        "--out", metavar="TABLE.parquet", type=Path, help="table of several; goes on where it was"
    )
    diagnose.add_argument(
        "--cluster", metavar="ADDRESS", help="diagnose several on a Dask cluster: tcp://HOST:PORT"
    )
    diagnose.add_argument(
        "--max-effects", metavar="N", type=_count, default=4, help="longest ladder (default 4)"
    )
    diagnose.add_argument(
        "--jobs", metavar="N", type=_count, help="parallel threads (default: one a processor)"
    )
    diagnose.add_argument(
        "--all",
        action="store_true",
        help="add effects, too, that lower the error by little beside what the first did",
    )
    diagnose.add_argument(
        "--budget",
        metavar="SECONDS",
        type=_budget,
        default=BUDGET_S,
        help=f"work to spend, in seconds of one processor, or none (default {BUDGET_S:g})",
    )
    _library(diagnose)
    _outputs(diagnose)

    law = commands.add_parser("law", help="find the force a model is missing: curve and formula")
    _campaign(law)
    law.add_argument(
        "--with",
        dest="accepted",
        metavar="EFFECT",
        nargs="+",
        default=[],
        help="effects that are part of the model",
    )
    law.add_argument("--save", metavar="FILE.py", type=Path, help="keep the formula as an effect")
    _json(law)
    law.add_argument(
        "--report", metavar="FILE", type=Path, help="write a page to read: .html, or .pdf"
    )
    law.add_argument("--figure", metavar="FILE.png", type=Path, help="draw the law")
    _library(law)

    add = commands.add_parser("add", help="add effects, refit, and store the model in CAMPAIGN")
    _campaign(add)
    add.add_argument("effects", metavar="EFFECT", nargs="+", help="an effect, such as dry-friction")
    _library(add, "effects_file")  # "effects" are those to add
    _json(add)


def _make_recording(commands: "argparse._SubParsersAction[OneLineParser]") -> None:
    logger = commands.add_parser("logger", help="ask the logger, and set it up")
    logger.add_argument(
        "action",
        choices=("info", "status", "list", "time", "start", "stop", "ports", "selftest"),
        nargs="?",
        default="info",
        help="default info; time: tell it the time; ports: those that may have a logger; selftest:"
        " tell a dead sensor from a still one",
    )
    logger.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="rate, channels, name, start, stream, size_mb, pulses_per_km, device, calibration,"
        " clock_ppm",
    )
    record = commands.add_parser("record", help="write what the logger streams, and show it")
    record.add_argument(
        "--out",
        metavar="PATH",
        type=Path,
        default=Path(),
        help="a new FILE.HOP, or a folder (default: here), where the name is as on the card",
    )
    record.add_argument(
        "--start", action="store_true", help="start a session on the card, stop it at the end"
    )
    record.add_argument(
        "--seconds", metavar="S", type=_positive, help="end after so long (default: Ctrl-C)"
    )
    record.add_argument("--plot", action="store_true", help="live plot for a browser")
    record.add_argument(
        "--plot-port", metavar="N", type=int, default=0, help="its port (default: any)"
    )
    download = commands.add_parser("download", help="fetch log files from the logger's card")
    download.add_argument(
        "names", metavar="NAME", nargs="*", help="such as HOP00012.HOP (default: the last)"
    )
    download.add_argument("--all", action="store_true", help="all that are on the card")
    download.add_argument(
        "--out", metavar="FOLDER", type=Path, default=Path(), help="where to (default: here)"
    )
    for command in (logger, record, download):
        command.add_argument(
            "--port",
            metavar="PORT",
            help="COM3, /dev/ttyUSB0, socket://HOST:PORT (default: find it)",
        )
        command.add_argument(
            "--baud", metavar="N", type=int, default=500_000, help="default 500000"
        )


def _make_logs(commands: "argparse._SubParsersAction[OneLineParser]") -> None:
    info = commands.add_parser("info", help="tell all about a log of the logger")
    info.add_argument("files", metavar="LOG", nargs="+", type=Path, help="a .HOP file")
    _json(info)
    decode = commands.add_parser("decode", help="turn a log into CSV, Parquet, MDF4 or UFF")
    decode.add_argument("files", metavar="LOG", nargs="+", type=Path, help="a .HOP file")
    decode.add_argument(
        "--out", metavar="FILE|FOLDER", type=Path, help="where to (default: beside the log)"
    )
    decode.add_argument("--format", choices=("csv", "parquet", "mf4", "uff"), help="default csv")
    decode.add_argument("--calibration", metavar="FILE.toml", type=Path, help="make it m/s²")
    decode.add_argument(
        "--sensor-hz",
        metavar="HZ",
        type=_positive,
        help="undo the sensors' low-pass (default: that of the calibration)",
    )
    decode.add_argument("--force", action="store_true", help="replace files that exist")
    decode.add_argument("--raw", action="store_true", help="undo nothing")
    decode.add_argument("--scans", metavar="FIRST:STOP", type=_scans, help="only these")
    recover = commands.add_parser("recover", help="save what is whole of a damaged log or card")
    recover.add_argument("file", metavar="FILE", type=Path, help="a log, or the image of a card")
    recover.add_argument(
        "--into", metavar="FOLDER", type=Path, default=Path("recovered"), help="default ./recovered"
    )
    for command in (info, decode, recover):
        command.add_argument(
            "--header-from",
            metavar="LOG",
            type=Path,
            help="a log with the same settings, if the header is damaged",
        )


def _make_checks(commands: "argparse._SubParsersAction[OneLineParser]") -> None:
    calibrate = commands.add_parser("calibrate", help="find what turns codes into m/s²")
    calibrate.add_argument(
        "session", metavar="SESSION", nargs="?", type=Path, help="SESSION.toml; or, turned, a log"
    )
    calibrate.add_argument(
        "--flip", action="store_true", help="the sensors were turned over; alone: how to do that"
    )
    calibrate.add_argument(
        "--out",
        metavar="FILE.toml",
        type=Path,
        default=Path("calibration.toml"),
        help="default calibration.toml",
    )
    calibrate.add_argument(
        "--figure", metavar="FILE.png", type=Path, help="default: beside the constants"
    )
    health = commands.add_parser("health", help="say what is wrong with recordings")
    health.add_argument(
        "recordings", metavar="RECORDING", nargs="+", type=Path, help=".hop, .csv, .mf4 …"
    )
    health.add_argument(
        "--checklist", action="store_true", help="the session of firmware/BUILD.md, step by step"
    )
    sync = commands.add_parser("sync-check", help="check on a beam that channels are in step")
    sync.add_argument("recording", metavar="SESSION", type=Path, help="recording of a driven beam")
    sync.add_argument("beam", metavar="BEAM.toml", type=Path, help="the beam, its drive, sensors")
    sync.add_argument(
        "--limit-ms", metavar="MS", type=_positive, default=0.5, help="largest skew (default 0.5)"
    )
    sync.add_argument(
        "--correct",
        metavar=("OLD", "NEW"),
        nargs=2,
        type=Path,
        help="write recording OLD with its channels moved into step as NEW",
    )
    for command in (health, sync):
        command.add_argument("--figure", metavar="FILE.png", type=Path, help="draw what was found")
        _json(command)


def _make_campaign(command: argparse.ArgumentParser) -> None:
    actions = command.add_subparsers(dest="action", metavar="ACTION", required=True)
    stretches = actions.add_parser("stretches", help="show where a recording was driven")
    new = actions.add_parser("new", help="begin a campaign in FOLDER, for recordings like this one")
    add = actions.add_parser("add", help="add a run to the campaign in FOLDER")
    for action in (new, add):
        action.add_argument("folder", metavar="FOLDER", type=Path, help="the campaign's folder")
    for action in (stretches, new, add):
        action.add_argument("recording", metavar="RECORDING", type=Path, help=".hop, .csv, .mf4 …")
        action.add_argument(
            "--calibration", metavar="FILE.toml", type=Path, help="constants of the sensors"
        )
        action.add_argument(
            "--nominal", action="store_true", help="do without: take the data sheet's, ±10 %%"
        )
    new.add_argument("--title", help="what was recorded (default: the folder's name)")
    new.add_argument("--vehicle", metavar="FILE.toml", type=Path, help="vehicle.toml to copy")
    new.add_argument(
        "--place",
        metavar="CHANNEL=PLACE",
        action="append",
        default=[],
        help="A1…A4, B1…B4, body, x,y in m; travel:CORNER:RATIO, force:CORNER, rate:pitch, speed",
    )
    add.add_argument("--id", required=True, help="name of the run, such as washboard-slow")
    add.add_argument(
        "--speed-kmph",
        metavar="V",
        type=float,
        help="nominal speed (default: the mean of the channel that measures it)",
    )
    add.add_argument(
        "--track",
        metavar=("KIND", "KEY=VALUE"),
        nargs="+",
        default=["unknown"],
        help="such as washboard amplitude_mm=15 pitch_mm=400 (default unknown)",
    )
    add.add_argument(
        "--role", choices=("fit", "validate"), default="fit", help="default fit; validate judges"
    )
    add.add_argument("--from", dest="from_s", metavar="S", type=float, help="begin, s")
    add.add_argument("--to", dest="to_s", metavar="S", type=float, help="end, s")
    add.add_argument(
        "--stretch",
        metavar="N",
        type=_count,
        help="the N-th of wheelhop campaign stretches: its steady part on a track that goes on"
        " alike, all of it on another",
    )
    add.add_argument("--whole", action="store_true", help="all of the stretch in any case")


def _campaign(command: argparse.ArgumentParser) -> None:
    command.add_argument("campaign", metavar="CAMPAIGN", type=Path, help="the campaign's folder")


def _library(command: argparse.ArgumentParser, name: str = "effects") -> None:
    command.add_argument(
        "--effects", dest=name, metavar="FILE.py", type=Path, help="a file with effects of your own"
    )


def _json(command: argparse.ArgumentParser) -> None:
    command.add_argument("--json", metavar="FILE", type=Path, help="write the result as JSON")


def _outputs(command: argparse.ArgumentParser) -> None:
    _json(command)
    command.add_argument(
        "--report", metavar="FILE", type=Path, help="write a report: .html, or .pdf by a browser"
    )


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 1 up")
    return int(text)


def _budget(text: str) -> float | None:
    return None if text == "none" else _positive(text)


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number above 0")
    return value


def _scans(text: str) -> tuple[int, int]:
    first, _, stop = text.partition(":")
    if not (first.isdecimal() and stop.isdecimal() and int(first) < int(stop)):
        raise argparse.ArgumentTypeError(f"'{text}' is not FIRST:STOP, two whole numbers")
    return int(first), int(stop)
