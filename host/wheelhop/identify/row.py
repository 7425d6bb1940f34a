"""One printed number beside ours, and what their agreement is worth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Kind = Literal["fit", "round trip", "recalculation", "prediction", "taken over"]
KINDS: Mapping[Kind, str] = {
    "fit": "six numbers of an equivalent vehicle, which are not printed, were chosen so that these"
    " rows agree",
    "round trip": "records were made of the printed numbers, and these found in them again: that"
    " tests the program, not the thesis",
    "recalculation": "by a formula from other printed numbers: that tests the thesis's arithmetic",
    "prediction": "from masses, springs and dampers, none of them chosen for the row; where they"
    " are not printed, they are the equivalent vehicle's (chapter 2) or the examples' (chapter 5)",
    "taken over": "a printed number that stands in this program as it is, or is printed twice: that"
    " tests the copy alone",
}
"""How ours came about, and so what its agreement with the printed number is worth."""

UNPUBLISHED = (
    "the frame's finite elements are not printed; an equivalent rigid body with one twisting mode"
    " stands for them"
)
AGREES = 0.01


@dataclass(frozen=True)
class Row:
    """One number: where it is printed, what it is, the printed value, ours (NaN: there is none),
    of which kind ours is, and why they differ (empty: they agree to 1 %)."""

    table: str
    what: str
    printed: float
    ours: float
    kind: Kind
    reason: str


def make_row(table: str, what: str, printed: float, ours: float, kind: Kind, reason: str) -> Row:
    """A row; the reason stands where the two differ by more than 1 %."""
    agrees = abs(ours - printed) <= AGREES * abs(printed)
    return Row(table, what, printed, float(ours), kind, "" if agrees else reason)
