"""`wheelhop`: which command is meant, and the one place where a user's mistake becomes one line.

Each command is a module of this room with `run(arguments) -> exit status`. It is imported only
when it is called, so that `wheelhop --help` answers at once.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import NoReturn

BAD_INPUT = 2
INTERRUPTED = 130
COMPUTING = ("compare", "diagnose", "add", "demo")
BROKEN_PIPE = 1  # what rich, when it is the one to notice, ends with


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit status is 0, 2 for bad input, 130 when interrupted."""
    # Every run is worked on by one thread; linear algebra's own threads would be in the way.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    parser = _parser()
    arguments = parser.parse_args(argv)
    if arguments.command is None:
        parser.error("say what to do: check, compare, diagnose, add or demo")
    try:
        status = _run(arguments)
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:
        return _complain("interrupted", INTERRUPTED)
    except BrokenPipeError:  # the reader, `head` say, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE


def _run(arguments: argparse.Namespace) -> int:
    from wheelhop.campaign import CampaignError

    try:
        for output in (vars(arguments).get("json"), vars(arguments).get("report")):
            _check_output(output)
        if arguments.command in COMPUTING:
            import_module("wheelhop.cli.progress").announce_compilation()
        command = import_module(f"wheelhop.cli.{arguments.command}")
        status: int = command.run(arguments)
        return status
    except CampaignError as error:
        return _complain(str(error), BAD_INPUT)
    except OSError as error:
        if isinstance(error, BrokenPipeError) or error.filename is None:
            raise
        return _complain(f"{error.filename}: {error.strerror}", BAD_INPUT)


def _check_output(file: Path | None) -> None:
    """Better to know before a long computation than after it."""
    from wheelhop.campaign import CampaignError

    if file is not None and file.is_dir():
        raise CampaignError(f"{file}: is a folder; give the name of a file to write")
    if file is not None and not file.parent.is_dir():
        raise CampaignError(f"{file}: cannot be written, there is no folder {file.parent}")


def _complain(line: str, status: int) -> int:
    print(f"wheelhop: {line}", file=sys.stderr)
    return status


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line instead of printing the usage first."""

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"wheelhop: {message}; see {self.prog} --help\n")


def _parser() -> argparse.ArgumentParser:
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


if __name__ == "__main__":
    sys.exit(main())
