"""What the page asks of the process that computes, and that process's first step."""

from __future__ import annotations

import os
import signal
import sys
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Literal

from wheelhop.files import Source
from wheelhop.workbench.session import Choice

Wish = Literal["", "diagnose", "law", "axles", "foresee", "settings"]
DOING: dict[Wish, str] = {
    "": "fitting",
    "diagnose": "diagnosing",
    "law": "finding a law",
    "axles": "identifying",
    "foresee": "asking what these channels can show",
    "settings": "comparing settings",
}
"""What may be wished beside the models that lead to a choice, and what the page calls it: a
diagnosis; the force that is missing beside the effects chosen; what lies between axle and body;
from which strength on effects would be seen; how settings differ, which takes no model."""
LONG: tuple[Wish, ...] = ("diagnose", "law")
"""What another wish ends."""


@dataclass(frozen=True)
class Order:
    """What to work out: the models that lead to a choice and a `wish`; and what to write into the
    folder, a name of `takeaway`. `effects_file` is the text of the user's own effects."""

    folder: Path
    choice: Choice
    effects_file: Source | None = None
    wish: Wish = ""
    write: str = ""


@dataclass(frozen=True)
class GiveWay:
    """What will be ordered next: of the models being fitted only those on the way to it are worth
    finishing."""

    following: Order


@dataclass(frozen=True)
class Enough:
    """The diagnosis shall end with the verdict so far."""


def obey_orders(orders: Connection) -> None:
    """Obey until the page's process is gone. Only here what computes is loaded."""
    _give_way()
    from wheelhop.workbench.worker import Worker

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the page's to answer
    worker = Worker(orders.send, lambda: orders.recv() if orders.poll() else None)
    while True:
        try:
            order = orders.recv()
        except EOFError:
            return
        if isinstance(order, Order):  # who is told to give way may have finished
            worker.obey(order)


def how_it_ended(status: int | None) -> str:
    """In a line, how that process ended by itself, from its exit status."""
    if status is not None and -status == getattr(signal, "SIGKILL", None):
        how = "was killed by the system, for lack of memory most likely: leave runs out, or close"
        return f"the process that computes {how} other programs, and try again"
    if status is not None and status < 0:
        how = f"was ended by signal {-status} ({signal.strsignal(-status)})"
    else:
        how = f"ended with status {status}"
    return f"the process that computes {how}: the terminal of the workbench may say why; try again"


def _give_way() -> None:
    """Page and browser come first: whoever clicks shall not wait for what takes a minute anyway."""
    if sys.platform != "win32":
        os.nice(5)
