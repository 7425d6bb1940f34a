"""Where it fails: the report's breakdown of the residual, of the baseline and the last model."""

from __future__ import annotations

from nicegui import ui

from wheelhop.workbench.desk import Desk
from wheelhop.workbench.view import Looking

WAITING = "<p class='soft'>The model is being fitted; where it fails is known after that.</p>"


class WhereView:
    """Band × motion × run, what the residual is locked to, and the sentences beside them."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk = desk
        self._seen: object = None
        self._body = ui.html(WAITING, sanitize=False)

    def show(self) -> None:
        """Bring it up to date."""
        rung = self._desk.rungs[-1] if self._desk.rungs else None
        if rung is not self._seen:
            self._seen = rung
            self._body.set_content(rung.html["where"] if rung else WAITING)
