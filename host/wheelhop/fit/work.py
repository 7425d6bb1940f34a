"""How much work was done, and how much may be: a verdict must not depend on how busy a computer is.

Work is counted in seconds of driving that were simulated with a linear vehicle. Seconds of a
computer are only what it is calibrated to, on a processor of 2024.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from threading import Lock

SIMULATED_PER_SECOND = 8000.0
"""So many seconds of driving are simulated, fitted and screened in one of a processor."""

WITH_LAWS = 3.0
"""A second with laws of friction, stops or dampers in it costs so many without."""

PER_HEIGHT = 1.5e-6
"""Equations of n unknown heights of the ground cost n³ times this, each time they are solved."""


class OutOfBudget(Exception):
    """The work that was allowed is done."""


class Work:
    """Counts what was simulated, in seconds of driving; threads may add to it."""

    def __init__(self) -> None:
        self.done = 0.0
        self._most = inf
        self._lock = Lock()

    def add(self, amount: float) -> None:
        """So much more was done."""
        with self._lock:
            self.done += amount

    @property
    def seconds(self) -> float:
        """What was done, as seconds of a processor."""
        return self.done / SIMULATED_PER_SECOND

    def check(self) -> None:
        """Raise `OutOfBudget` where what is allowed is done."""
        if self.done > self._most:
            raise OutOfBudget

    @contextmanager
    def limited(self, seconds: float | None) -> Iterator[None]:
        """Within this, work beyond so many seconds of a processor, those before it included, is
        refused; None: any amount is allowed."""
        self._most = inf if seconds is None else seconds * SIMULATED_PER_SECOND
        try:
            yield
        finally:
            self._most = inf
