"""What a user sees on stderr while the computer works."""

from __future__ import annotations

import os
import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

COMPILED = (("wheelhop.simulate", "integrator"), ("wheelhop.effects", "dry_friction"))
"""A folder and a module in it with compiled functions; numba keeps them in __pycache__."""


def announce_compilation() -> None:
    """Say that the first run takes longer, if this is the first run.

    It looks at files alone: importing the rooms would already compile.
    """
    if "NUMBA_CACHE_DIR" in os.environ:
        return
    for room, module in COMPILED:
        spec = find_spec(room)
        if spec is None or not spec.submodule_search_locations:
            continue
        folder = Path(spec.submodule_search_locations[0])
        caches = [file.stat().st_mtime for file in folder.glob(f"__pycache__/{module}.*.nbi")]
        source = (folder / f"{module}.py").stat().st_mtime
        if os.access(folder, os.W_OK) and max(caches, default=0.0) < source:
            print("compiling the integrator, once: this takes up to a minute", file=sys.stderr)
            return


QUIET_S = 10.0
"""Between two lines where stderr is not a terminal; what takes less says nothing."""
COUNTED = re.compile(r"(\d+) of (\d+)")


class TimeLeft:
    """How long it still takes, from texts that count: "12 of 200 points"."""

    def __init__(self) -> None:
        self._total = self._first = 0
        self._since_s = 0.0

    def words(self, text: str, now_s: float) -> str:
        """ ", about 0:40 left", or nothing where the text does not count or has just begun to."""
        found = COUNTED.search(text)
        if found is None:
            return ""
        done, total = int(found[1]), int(found[2])
        if total != self._total or done < self._first:
            self._total, self._first, self._since_s = total, done, now_s
        if done == self._first or done >= total:
            return ""
        left_s = (total - done) * (now_s - self._since_s) / (done - self._first)
        return f", about {_clock(left_s)} left"


@contextmanager
def stages() -> Iterator[Callable[[str], None]]:
    """A function that shows at what stage the work is, and how long a stage that counts will take:
    on one line that vanishes at the end, or where stderr is not a terminal, on a line of its own
    every ten seconds."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lines()
        return
    left = TimeLeft()
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("reading the campaign", total=None)

        def show(text: str) -> None:
            words = text + left.words(text, time.monotonic())
            progress.update(task, description=escape(words))

        yield show


def lines() -> Callable[[str], None]:
    """A function that prints what it is told on stderr, after ten seconds and then every ten."""
    left = TimeLeft()
    begun_s = said_s = time.monotonic()

    def show(text: str) -> None:
        nonlocal said_s
        now_s = time.monotonic()
        words = left.words(text, now_s)
        if now_s >= said_s + QUIET_S:
            said_s = now_s
            print(f"wheelhop: {_clock(now_s - begun_s)} {text}{words}", file=sys.stderr, flush=True)

    return show


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return (
        f"{minutes // 60}:{minutes % 60:02}:{rest:02}" if minutes >= 60 else f"{minutes}:{rest:02}"
    )
