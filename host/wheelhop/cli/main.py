"""`wheelhop`: which command is meant, and the one place where a user's mistake becomes one line.

Each command is a module of this package with `run(arguments) -> exit status`. It is imported only
when it is called, so that `wheelhop --help` answers at once.
"""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Sequence
    from sys import UnraisableHookArgs
    from types import FrameType

BAD_INPUT = 2
INTERRUPTED = 130
COMPUTING = ("compare", "diagnose", "law", "add", "demo", "simulate", "plan", "tune")
SETTINGS = ".numba_config.yaml"
"""numba takes its settings from such a file in the folder it is started in, and code: that of its
cache, or of a module named there. It may be somebody else's campaign."""
BROKEN_PIPE = 1  # what rich, when it is the one to notice, ends with
STRIKES_AGAIN_S = 0.1


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit status is 0, 2 for bad input, 130 when interrupted."""
    interrupts: list[int] = []
    listening = False
    try:
        listening = _listen(interrupts)
        return _run(argv, interrupts)
    except BaseException as error:
        # What Ctrl-C strikes may turn it into something else: a class body into a RuntimeError.
        if isinstance(error, KeyboardInterrupt) or (interrupts and isinstance(error, Exception)):
            return _complain("interrupted", INTERRUPTED)
        raise
    finally:
        if listening:
            _listen_no_more(interrupts)


def _listen(interrupts: list[int]) -> bool:
    """Note every Ctrl-C, which raises KeyboardInterrupt as ever; whether that is for us to do."""
    import signal
    import threading
    from _thread import interrupt_main

    def interrupt(number: int, frame: FrameType | None) -> None:
        interrupts.append(number)
        raise KeyboardInterrupt

    def once_more(lost: UnraisableHookArgs) -> None:
        # In a callback of the compiler, say, nothing can be raised: it strikes again right after.
        if issubclass(lost.exc_type, KeyboardInterrupt):
            threading.Timer(STRIKES_AGAIN_S, interrupt_main).start()
        else:
            sys.__unraisablehook__(lost)

    ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
    if ours:
        signal.signal(signal.SIGINT, interrupt)
        sys.unraisablehook = once_more
    return ours


def _listen_no_more(interrupts: list[int]) -> None:
    import signal

    # The threads that compute finish what they are at; a second Ctrl-C does not wait for that.
    after = signal.SIG_DFL if interrupts else signal.default_int_handler
    signal.signal(signal.SIGINT, after)
    sys.unraisablehook = sys.__unraisablehook__


def _run(argv: Sequence[str] | None, interrupts: Sequence[int]) -> int:
    from wheelhop.cli.parser import make_parser

    # Every run is worked on by one thread; linear algebra's own threads would be in the way.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    parser = make_parser()
    arguments = parser.parse_args(argv)
    if arguments.command is None:
        parser.error("say what to do")
    if os.path.lexists(SETTINGS):
        here = os.path.abspath(SETTINGS)
        return _complain(f"{here}: could make numba run what it names: delete it", BAD_INPUT)
    try:
        status = _call(arguments, interrupts)
        sys.stdout.flush()
        return status
    except BrokenPipeError:  # the reader, `head` say, has seen enough
        _drop_output()
        return BROKEN_PIPE
    except OSError as error:  # a full disk, say, below a redirected output
        _drop_output()
        return _complain(f"{error.filename or 'output'}: {error.strerror or error}", BAD_INPUT)


def _call(arguments: Namespace, interrupts: Sequence[int]) -> int:
    from importlib import import_module

    from wheelhop.files import InputError, check_new, check_picture, check_target

    try:
        # Better to know before a long computation.
        for check, keys in (
            (check_target, ("json", "report", "mat")),
            (check_new, ("save",)),
            (check_picture, ("figure", "study_figure")),
        ):
            for key in keys:
                if vars(arguments).get(key) is not None:
                    check(vars(arguments)[key])
        if arguments.command in COMPUTING:
            import_module("wheelhop.cli.progress").announce_compilation()
        command = imported(f"wheelhop.cli.{module_of(arguments.command)}")
        if interrupts:  # what was being imported has made nothing of it
            raise KeyboardInterrupt
        status: int = command.run(arguments)
        return status
    except InputError as error:
        return _complain(str(error), BAD_INPUT)


def imported(module: str) -> Any:
    """A module and all it needs. What is imported stays: to look through it for garbage, while it
    comes and ever after, would cost a third of a second."""
    import gc
    from importlib import import_module

    collecting = gc.isenabled()
    gc.disable()
    try:
        return import_module(module)
    finally:
        if not gc.get_freeze_count():
            gc.freeze()
        if collecting:
            gc.enable()


def module_of(command: str) -> str:
    """The module of this package that a command is; `import` cannot be the name of one."""
    from keyword import iskeyword

    name = command.replace("-", "_")
    return f"{name}_" if iskeyword(name) else name


def _drop_output() -> None:
    """What has not been written yet cannot be: the interpreter shall not try again at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _complain(line: str, status: int) -> int:
    print(f"wheelhop: {line}", file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
