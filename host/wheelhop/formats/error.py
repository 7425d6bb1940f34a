"""What a user can mend in a file, and the one place where a library's exception becomes a line."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from importlib import import_module
from io import StringIO
from pathlib import Path
from types import ModuleType

from wheelhop.files import InputError, require

LONGEST_REASON = 160  # characters of what a library says
_PROCESS_WIDE = threading.RLock()


class ExchangeError(InputError):
    """A file that cannot be read or written, or a mapping that does not fit it."""


def need(module: str, extra: str, file: Path) -> ModuleType:
    """Import an optional library; raises `ExchangeError` with the pip command if it is missing."""
    require(module.partition(".")[0], f"{file}: {file.suffix}", extra, ExchangeError)
    return import_module(module)


@contextmanager
def guarded(file: Path, what: str) -> Iterator[None]:
    """Whatever a library raises over a damaged file is an `ExchangeError` of one line.

    Libraries meet bytes that their authors never saw, and then raise anything, or print
    what they think of it. Standard output and the filter of warnings belong to all threads, so one
    thread at a time is guarded: two that overlap would leave them redirected for good.
    """
    try:
        with _PROCESS_WIDE, warnings.catch_warnings(), redirect_stdout(StringIO()):
            warnings.simplefilter("ignore")
            yield
    except InputError:
        raise
    except Exception as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())
        reason = reason[:LONGEST_REASON] or type(error).__name__
        raise ExchangeError(f"{file}: cannot {what}: {reason}") from None
