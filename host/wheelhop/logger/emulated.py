"""How an emulated logger is found: it announces its port to the programs of the same user."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from wheelhop.files import cache_folder, claimed, write_text
from wheelhop.logger.error import LoggerError

PURPOSE = "emulated logger"


@contextmanager
def announced(url: str) -> Iterator[None]:
    """Let `emulated_ports` find this port while the block runs. Raises LoggerError if another
    emulated logger is there already."""
    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    with claimed(folder, PURPOSE, LoggerError):
        write_text(folder / PURPOSE, url, LoggerError)
        try:
            yield
        finally:
            (folder / PURPOSE).unlink(missing_ok=True)


def emulated_ports() -> list[str]:
    """The port of the emulated logger, if one runs; what a killed one has left does not count."""
    folder = cache_folder()
    try:
        url = (folder / PURPOSE).read_text(encoding="utf-8")
    except OSError:
        return []
    try:
        with claimed(folder, PURPOSE, LoggerError):
            return []
    except LoggerError:
        return [url]
