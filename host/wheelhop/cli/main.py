"""`wheelhop`: which command is meant, and the one place where a user's mistake becomes one line.

Each command is a module of this room with `run(arguments) -> exit status`. It is imported only
when it is called, so that `wheelhop --help` answers at once.
"""

import os
import sys
from argparse import Namespace
from collections.abc import Sequence
from importlib import import_module
from keyword import iskeyword
from pathlib import Path

from wheelhop.cli.parser import BAD_INPUT, make_parser

INTERRUPTED = 130
COMPUTING = ("compare", "diagnose", "add", "demo")
BROKEN_PIPE = 1  # what rich, when it is the one to notice, ends with


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit status is 0, 2 for bad input, 130 when interrupted."""
    # Every run is worked on by one thread; linear algebra's own threads would be in the way.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    parser = make_parser()
    arguments = parser.parse_args(argv)
    if arguments.command is None:
        parser.error("say what to do")
    try:
        status = _run(arguments)
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:
        return _complain("interrupted", INTERRUPTED)
    except BrokenPipeError:  # the reader, `head` say, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE


def _run(arguments: Namespace) -> int:
    from wheelhop.files import InputError

    try:
        for key in ("json", "report", "figure", "mat", "study_figure"):
            _check_output(vars(arguments).get(key))
        if arguments.command in COMPUTING:
            import_module("wheelhop.cli.progress").announce_compilation()
        command = import_module(f"wheelhop.cli.{module_of(arguments.command)}")
        status: int = command.run(arguments)
        return status
    except InputError as error:
        return _complain(str(error), BAD_INPUT)
    except OSError as error:
        if isinstance(error, BrokenPipeError) or error.filename is None:
            raise
        return _complain(f"{error.filename}: {error.strerror}", BAD_INPUT)


def module_of(command: str) -> str:
    """The module of this room that a command is; `import` cannot be the name of one."""
    name = command.replace("-", "_")
    return f"{name}_" if iskeyword(name) else name


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


if __name__ == "__main__":
    sys.exit(main())
