"""Did the sensors' supply, which is the converter's reference, hold through a session?"""

from collections.abc import Mapping
from typing import NamedTuple

from wheelhop.logger.settings import number

SAG = 0.03  # relative change that is told; the readings' common error of ±10 % cancels in it


class Change(NamedTuple):
    """The largest change since the start, `relative` to it, and a sentence about it."""

    relative: float
    text: str


def supply_change(notes: Mapping[str, str]) -> Change | None:
    """Return what a log's notes say of a supply that changed by more than 3 %; None: it held."""
    first = number(notes, "supply_mv")
    when = f"at {notes['low_supply_s']} s" if "low_supply_s" in notes else "in between"
    seen = {when: number(notes, "low_supply_mv"), "at the end": number(notes, "end_supply_mv")}
    changes = {moment: mv / first - 1 for moment, mv in seen.items() if mv > 0 and first > 0}
    if not changes:
        return None
    moment = max(changes, key=lambda key: abs(changes[key]))
    if abs(changes[moment]) <= SAG:
        return None
    verb = "fell" if changes[moment] < 0 else "rose"
    return Change(
        changes[moment],
        f"the sensors' supply {verb} from {first:.0f} to {seen[moment]:.0f} mV"
        f" ({100 * changes[moment]:+.0f} %) {moment}",
    )
