"""Struts: histograms of their velocity and travel, and their loops; a component's loops."""

from __future__ import annotations

from wheelhop.workbench.desk import Desk
from wheelhop.workbench.view import Looking, drawn

WAITING = "<p class='soft'>The model is being fitted; what its struts did stands here then.</p>"


class StrutsView:
    """The report's section of the last model."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk = desk
        self._seen: object = None
        self._body = drawn(WAITING)

    def show(self) -> None:
        """Bring it up to date."""
        rung = self._desk.rungs[-1] if self._desk.rungs else None
        if rung is not self._seen:
            self._seen = rung
            self._body.set_content(rung.html["struts"] if rung else WAITING)
