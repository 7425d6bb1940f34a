"""`wheelhop download`: fetch log files from the logger's card."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, DownloadColumn, Progress, TimeRemainingColumn
from rich.progress import TransferSpeedColumn as SpeedColumn

from wheelhop.cli.progress import lines
from wheelhop.logger import read_log
from wheelhop.logger.download import Downloaded, Downloader
from wheelhop.logger.error import LoggerError
from wheelhop.logger.link import connect

DAMAGED = 1


def run(arguments: Namespace) -> int:
    """Fetch the named files, all that are not here, or else the last and those that it goes on
    with; raises LoggerError.

    The exit status is 1 where a file is damaged on the card.
    """
    folder: Path = arguments.out
    if not folder.is_dir():
        raise LoggerError(f"{folder}: there is no such folder")
    downloader = Downloader(connect(arguments.port, baud=arguments.baud), baud=arguments.baud)
    try:
        sizes = downloader.link.files()
        names = choose(arguments.names, arguments.all, sizes, downloader.link.port.name)
        any_copy = not arguments.names  # who names a file wants the card's
        files = [_fetch(downloader, name, sizes[name], folder, any_copy) for name in names]
        if not arguments.names:
            while (before := goes_on(files[-1].path)) in sizes and before not in names:
                print(f"{files[-1].path} goes on with {before}")
                files.append(_fetch(downloader, before, sizes[before], folder, any_copy))
                names.append(before)
    finally:
        downloader.close()
    return DAMAGED if any(file.damaged for file in files) else 0


def choose(names: list[str], every: bool, sizes: dict[str, int], port: str) -> list[str]:
    """The files meant, of those on the card. Raises LoggerError if one is not there."""
    if not sizes:
        raise LoggerError(f"{port}: there are no log files on the card")
    if every:
        return sorted(sizes)
    known = {name.upper(): name for name in sizes}
    for name in names:
        if name.upper() not in known:
            raise LoggerError(f"{name}: not on the card, there are {', '.join(sorted(sizes))}")
    return [known[name.upper()] for name in names] or [max(sizes)]


def goes_on(path: Path) -> str:
    """The card's name of the file that this one goes on with; empty: it stands alone."""
    try:
        return read_log(path).goes_on_with
    except LoggerError:
        return ""  # damaged: `wheelhop info` says where


def _fetch(
    downloader: Downloader, name: str, size: int, folder: Path, any_copy: bool
) -> Downloaded:
    columns = (BarColumn(), DownloadColumn(), SpeedColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    say = lines()
    with Progress("{task.description}", *columns, console=console, transient=True) as progress:
        progress.disable = not console.is_terminal
        task = progress.add_task(name, total=size)

        def show(done: int, _: int) -> None:
            progress.update(task, completed=done)
            if progress.disable:
                say(f"{name}: {done} of {size} bytes")

        file = downloader.download(name, size, folder, show, any_copy)
    damaged = f", {file.damaged} blocks damaged on the card" if file.damaged else ""
    here = "" if file.fresh else " was here already"
    print(f"{file.path}{here}: {file.size} bytes{damaged}", flush=True)
    return file
