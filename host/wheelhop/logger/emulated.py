"""How an emulated logger is found: it announces its port to the programs of the same user."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from wheelhop.files import claimed, write_text
from wheelhop.logger.error import LoggerError

PURPOSE = "emulated logger"


@contextmanager
def announced(url: str) -> Iterator[None]:
    """Let `emulated_ports` find this port while the block runs. Raises LoggerError if another
    emulated logger is there already."""
    folder = _folder()
    folder.mkdir(parents=True, exist_ok=True)
    with claimed(folder, PURPOSE, LoggerError):
        write_text(folder / PURPOSE, url, LoggerError)
        try:
            yield
        finally:
            (folder / PURPOSE).unlink(missing_ok=True)


def emulated_ports() -> list[str]:
    """The port of the emulated logger, if one runs; what a killed one has left does not count."""
    folder = _folder()
    try:
        url = (folder / PURPOSE).read_text(encoding="utf-8")
    except OSError:
        return []
    try:
        with claimed(folder, PURPOSE, LoggerError):
            return []
    except LoggerError:
        return [url]


def _folder() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "wheelhop"
