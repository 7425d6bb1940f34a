"""What a user sees on stderr while the computer works."""

from __future__ import annotations

import os
import sys
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


@contextmanager
def stages() -> Iterator[Callable[[str], None]]:
    """A function that shows at what stage the work is, on one line that vanishes at the end;
    where stderr is not a terminal it stays silent."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda text: None
        return
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("reading the campaign", total=None)
        yield lambda text: progress.update(task, description=escape(text))
