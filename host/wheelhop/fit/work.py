"""How much work was done, and how much may be: a verdict must not depend on how busy a computer is.

Work is counted in thousands of integration steps, and what is made of a record costs as many as it
lasts seconds. Seconds of a computer are only what it is calibrated to, on a processor of 2024.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from threading import Lock

PER_SECOND = 6000.0
"""So much is simulated, fitted and screened in a second of a processor."""

PER_STEP, PER_RECORD_S = 1e-3, 1.2
"""What a step of the integration costs, and what is done with a second of a record."""

PER_HEIGHT = 1.1e-6
"""Equations of n unknown heights of the ground cost n³ times this, each time they are solved."""


class OutOfBudget(Exception):
    """The work that was allowed is done."""


class Work:
    """Counts what was done; threads may add to it."""

    def __init__(self) -> None:
        self.done = 0.0
        self._most = inf
        self._lock = Lock()

    def __getstate__(self) -> dict[str, float]:
        return {"done": self.done}

    def __setstate__(self, state: dict[str, float]) -> None:
        self.done, self._most, self._lock = state["done"], inf, Lock()

    def add(self, amount: float) -> None:
        """So much more was done."""
        with self._lock:
            self.done += amount

    @property
    def seconds(self) -> float:
        """What was done, as seconds of a processor."""
        return self.done / PER_SECOND

    def check(self) -> None:
        """Raise `OutOfBudget` where what is allowed is done."""
        if self.done > self._most:
            raise OutOfBudget

    @contextmanager
    def limited(self, seconds: float | None) -> Iterator[None]:
        """Within this, work beyond so many seconds of a processor, those before it included, is
        refused; None: any amount is allowed."""
        self._most = inf if seconds is None else seconds * PER_SECOND
        try:
            yield
        finally:
            self._most = inf
