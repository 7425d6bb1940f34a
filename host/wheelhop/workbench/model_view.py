"""The model: the ladder, the effects in it, and every number that the fit has moved."""

from __future__ import annotations

from html import escape

from nicegui import ui

from wheelhop.workbench.desk import Desk
from wheelhop.workbench.view import Looking, acting
from wheelhop.workbench.where_view import WAITING


class ModelView:
    """What was added, in order, to be taken out or exchanged; the error it leaves; the numbers."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk, self._looking = desk, looking
        self._seen: object = None
        self._chips = acting("", self._act)
        self._body = ui.html(WAITING, sanitize=False)

    def show(self) -> None:
        """Bring it up to date."""
        desk = self._desk
        rung = desk.rungs[-1] if desk.rungs else None
        seen = (rung, desk.choice)
        if seen != self._seen:
            self._seen = seen
            self._chips.set_content(self._added())
            body = rung.html["ladder"] + rung.html["model"] if rung else WAITING
            self._body.set_content(body)

    def _added(self) -> str:
        added = self._desk.choice.added
        if not added:
            words = "Nothing has been added to the baseline. What is missing says what to add."
            return f'<p class="soft">{words} <button data-act="missing">Look there</button></p>'
        chips = []
        for i, name in enumerate(added):
            earlier = f'<button data-act="up" data-effect="{escape(name)}">earlier</button>'
            chips.append(
                f'<li class="chip"><strong>{escape(name)}</strong> {earlier if i else ""}'
                f'<button data-act="out" data-effect="{escape(name)}">take out</button></li>'
            )
        return f'<p class="soft">Added to the baseline:</p><ol class="chips">{"".join(chips)}</ol>'

    def _act(self, data: dict[str, str]) -> None:
        match data["act"]:
            case "missing":
                self._looking.go("missing")
            case "up":
                self._desk.move_up(data["effect"])
            case "out":
                self._desk.take_out(data["effect"])
