"""A law fitted in full."""

from __future__ import annotations

from dataclasses import dataclass

from wheelhop.diagnose import Rung


@dataclass(frozen=True, eq=False)
class Rival:
    """A law fitted in full: its name, how it reads, and the model with it."""

    name: str
    words: str
    rung: Rung
