"""Who is told how far the work is: a terminal, a notebook, a function of the user's, or nobody."""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

Progress = Callable[[str], None]
Watching = Progress | bool
"""A function called with a line of text at every stage; True: a line in a terminal or notebook, if
there is one; False: nothing is shown."""

COUNTED = re.compile(r"(\d+) of (\d+)")
NOTEBOOK_S = 0.25
"""Between two changes of a notebook's line: more often is only traffic."""


def silent(text: str) -> None:
    """Show nothing."""


@contextmanager
def shown(progress: Watching) -> Iterator[Progress]:
    """The function to call at every stage. In a terminal the line vanishes at the end, and nothing
    is shown where stderr is neither a terminal nor in a notebook."""
    if callable(progress):
        yield progress
    elif not progress:
        yield silent
    elif _in_notebook():
        with _in_cell() as show:
            yield show
    elif sys.stderr is not None and sys.stderr.isatty():
        with spinning() as show:
            yield show
    else:
        yield silent


@contextmanager
def spinning() -> Iterator[Progress]:
    """One line on a terminal, which vanishes at the end: the stage, how long it has taken so far,
    and how long one that counts will take."""
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress as Bar
    from rich.progress import SpinnerColumn, TextColumn, TimeElapsedColumn

    left = TimeLeft()
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reading the campaign", total=None)

        def show(text: str) -> None:
            bar.update(task, description=escape(text + left.words(text, time.monotonic())))

        yield show


@contextmanager
def _in_cell() -> Iterator[Progress]:
    """One line below a notebook's cell, emptied at the end."""
    shell: Any = import_module("IPython.display")
    left, said_s = TimeLeft(), -NOTEBOOK_S
    handle = shell.display(shell.Pretty("reading the campaign"), display_id=True)

    def show(text: str) -> None:
        nonlocal said_s
        now_s = time.monotonic()
        words = text + left.words(text, now_s)
        if now_s >= said_s + NOTEBOOK_S:
            said_s = now_s
            handle.update(shell.Pretty(words))

    try:
        yield show
    finally:
        handle.update(shell.Pretty(""))


def _in_notebook() -> bool:
    """Whether the code runs in a cell of Jupyter, or of what is like it."""
    found = sys.modules.get("IPython")
    shell = None if found is None else found.get_ipython()
    return shell is not None and hasattr(shell, "kernel")


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
        return f", about {clock(left_s)} left"


def clock(seconds: float) -> str:
    """A duration as 1:02:03, or 2:03."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
