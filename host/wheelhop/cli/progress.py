"""What a user sees on stderr while the computer works."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

from rich.console import Console

from wheelhop.files.progress import TimeLeft, clock, spinning

COMPILED = (("wheelhop.simulate", "integrator"), ("wheelhop.effects", "dry_friction"))
"""A folder and a module in it with compiled functions; numba keeps them in __pycache__."""


def announce_compilation() -> None:
    """Say that the first run takes longer, if this is the first run.

    It looks at files alone: importing the packages would already compile.
    """
    if "NUMBA_CACHE_DIR" in os.environ:
        return
    for package, module in COMPILED:
        spec = find_spec(package)
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


@contextmanager
def stages() -> Iterator[Callable[[str], None]]:
    """A function that shows at what stage the work is, and how long a stage that counts will take:
    on one line that vanishes at the end, or where stderr is not a terminal, on a line of its own
    every ten seconds."""
    if not Console(stderr=True).is_terminal:
        yield lines()
        return
    with spinning() as show:
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
            print(f"wheelhop: {clock(now_s - begun_s)} {text}{words}", file=sys.stderr, flush=True)

    return show
