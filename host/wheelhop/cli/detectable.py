"""What channels and roads can show, on the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from wheelhop.cli.show import print_limits
from wheelhop.diagnose import Limit
from wheelhop.files.words import listed
from wheelhop.predict.detectable import Added, Detectable
from wheelhop.report.words import limit_words

MOST_NAMED = 3
"""So many of the effects that gain most are named in the sentence; the table has all."""
LEAST_GAIN = 1.5
"""Below two thirds of what was needed: what is less is not worth a sensor."""


def print_detectable(found: Detectable, console: Console) -> None:
    """Print from where on effects would be seen, and what one more channel would add; or why
    nothing can be diagnosed."""
    if found.refused:
        console.print(Text(f"! cannot be compared or diagnosed: {found.refused}", style="yellow"))
        return
    heading = "These channels and roads would show, from so much on (to first order):"
    print_limits(found.limits, console, heading)
    if found.idle:
        console.print(Text(f"Nothing on these roads tells of {listed(found.idle)}."))
    if found.best is not None:
        console.print(Text(_said(found.best, found.limits)))


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


def _before(limit: Limit) -> str:
    return f"now {limit_words(limit)}" if limit.shown else "not seen now"
