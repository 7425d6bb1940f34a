"""What a column of a table holds, what a file states of its rate, and what is known of its time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from wheelhop.formats.stamps import Stamps

SLOWEST_HZ, FASTEST_HZ = 5.0, 1e5
"""Rates of recordings of a suspension; any other is asked about."""


def plausible(rate_hz: float) -> bool:
    """Whether recordings of a suspension are sampled so fast."""
    return SLOWEST_HZ <= rate_hz <= FASTEST_HZ


@dataclass(frozen=True, eq=False)
class Column:
    """What a column is called, in which unit the file says it is, and what it holds: `values`
    (n,), `stamps`, or `texts`. `stamps` is a text where they cannot be read."""

    label: str
    name: str
    unit: str
    values: NDArray[np.float64] | None = None
    stamps: Stamps | str | None = None
    texts: Sequence[str] = ()


@dataclass(frozen=True)
class Question:
    """What a file does not say: the key of a mapping that does, and what is asked in words."""

    key: str
    words: str


@dataclass(frozen=True)
class Timing:
    """Time is column `index` in `unit`, or there is only `rate_hz`; what is asked is empty there.

    `aside` are columns that are clocks or counters, too, and so no channels; with the reason.
    `guess` says what was taken for granted, "" for nothing.
    """

    index: int | None = None
    unit: str = ""
    rate_hz: float | None = None
    why: str = ""
    guess: str = ""
    questions: tuple[Question, ...] = ()
    aside: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Stated:
    """Where a file states its rate, as a user finds it; `bare` if it says no unit with it."""

    place: str
    bare: bool = False
