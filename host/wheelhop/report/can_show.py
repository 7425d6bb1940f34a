"""What channels and roads can show, in words: of a terminal and of a page."""

from __future__ import annotations

from collections.abc import Iterator

from wheelhop.diagnose import Limit
from wheelhop.files.words import listed
from wheelhop.predict.detectable import Added, Detectable, Told
from wheelhop.report.words import limit_words

MOST_NAMED = 3
"""So many of the effects that gain most are named in the sentence; the table has all."""
LEAST_GAIN = 1.5
"""Less than two thirds of what was needed is worth a sensor, and more than half as much again worth
a word: to first order limits are no better known."""


def seen_from(found: Detectable) -> Iterator[tuple[str, str]]:
    """Every effect in the form it was tried in, and from where on it would be seen and told from
    what is most like it."""
    for limit, told in zip(found.limits, found.told, strict=True):
        form = f" ({limit.form})" if limit.form else ""
        rival = _rival(told) if limit.shown and told.times > LEAST_GAIN else ""
        yield f"{limit.effect}{form}", f"{limit_words(limit)}{rival}"


def best_words(found: Detectable) -> str:
    """What nothing on these roads tells of, and what one more channel would add; "" for neither."""
    idle = f"Nothing on these roads tells of {listed(found.idle)}." if found.idle else ""
    best = "" if found.best is None else _said(found.best, found.limits)
    return " ".join(part for part in (idle, best) if part)


def _said(best: Added, before: tuple[Limit, ...]) -> str:
    """What one more channel would add, in a sentence."""
    was = {limit.effect: limit for limit in before}
    now = {limit.effect: limit for limit in best.limits}
    most = sorted(best.less, key=lambda effect: -best.less[effect])[:MOST_NAMED]
    named = [
        f"{effect} from {limit_words(now[effect])} on ({_before(was[effect])})"
        for effect in most
        if best.less[effect] > LEAST_GAIN and now[effect].amplitudes
    ]
    if not named:
        return "No further channel would add much."
    return f"Most would be added by {best.channels}: it would show {'; '.join(named)}."


def _rival(told: Told) -> str:
    if not told.limit.shown:
        return f"; not told from {told.rival}"
    return f"; told from {told.rival} from {limit_words(told.limit)} on"


def _before(limit: Limit) -> str:
    return f"now {limit_words(limit)}" if limit.shown else "not seen now"
