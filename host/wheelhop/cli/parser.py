"""The commands of `wheelhop` and what each of them takes."""

import argparse
import os
from pathlib import Path
from typing import NoReturn

BAD_INPUT = 2


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line instead of printing the usage first."""

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"wheelhop: {message}; see {self.prog} --help\n")


def make_parser() -> argparse.ArgumentParser:
    """What `wheelhop` understands; makes it without loading any room."""
    parser = _Parser(
        prog="wheelhop",
        description="Find out which physics a suspension model is missing.",
    )
    parser.add_argument(
        "--version", dest="command", action="store_const", const="version", help="print the version"
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")

    check = commands.add_parser("check", help="read a campaign and show what is in it")
    _campaign(check)

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

    diagnose = commands.add_parser("diagnose", help="find out which effects are missing")
    _campaign(diagnose)
    diagnose.add_argument(
        "--max-effects", metavar="N", type=_count, default=4, help="longest ladder (default 4)"
    )
    diagnose.add_argument(
        "--jobs", metavar="N", type=_count, default=os.cpu_count() or 1, help="parallel threads"
    )
    _library(diagnose)
    _outputs(diagnose)

    add = commands.add_parser("add", help="add effects, refit, and store the model in CAMPAIGN")
    _campaign(add)
    add.add_argument("effects", metavar="EFFECT", nargs="+", help="an effect, such as dry-friction")
    _library(add, "effects_file")  # "effects" are those to add

    demo = commands.add_parser("demo", help="diagnose a campaign that comes with wheelhop")
    demo.add_argument(
        "folder",
        metavar="FOLDER",
        nargs="?",
        type=Path,
        default=Path("wheelhop-demo"),
        help="where to put it (default ./wheelhop-demo)",
    )
    flash = commands.add_parser("flash", help="write the firmware into the logger")
    flash.add_argument("--port", metavar="PORT", help="serial port (default: the only one)")
    flash.add_argument(
        "--hex", metavar="FILE", type=Path, help="firmware (default: what make firmware has built)"
    )
    flash.add_argument("--board", choices=("nano", "mega"), default="nano", help="default nano")
    flash.add_argument(
        "--old-bootloader", action="store_true", help="for Nanos of before 2018 (57600 baud)"
    )
    commands.add_parser("version", help="print the version")
    return parser


def _campaign(command: argparse.ArgumentParser) -> None:
    command.add_argument("campaign", metavar="CAMPAIGN", type=Path, help="the campaign's folder")


def _library(command: argparse.ArgumentParser, name: str = "effects") -> None:
    command.add_argument(
        "--effects", dest=name, metavar="FILE.py", type=Path, help="a file with effects of your own"
    )


def _outputs(command: argparse.ArgumentParser) -> None:
    command.add_argument("--json", metavar="FILE", type=Path, help="write the result as JSON")
    command.add_argument("--report", metavar="FILE.html", type=Path, help="write a report")


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 1 up")
    return int(text)
