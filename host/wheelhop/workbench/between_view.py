"""Axle to body: what the records say lies between them, as transfer functions, beside the model."""

from __future__ import annotations

from nicegui import ui

from wheelhop.workbench.desk import Desk
from wheelhop.workbench.shown import AxleToBody
from wheelhop.workbench.view import Looking, drawn

WHY = (
    "Fitted to what the axles and the body did, knowing nothing of what the vehicle is made of."
    " Where it fits and the model does not, what is missing is linear."
)


class BetweenView:
    """The statement, the picture and the table of levels, once asked for."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk = desk
        self._seen: object = None
        with ui.row().classes("bench-controls"):
            self._start = ui.button("Identify it", on_click=lambda: desk.find("axles"))
            self._start.props("no-caps unelevated")
            ui.label(WHY).classes("soft")
        self._body = drawn()

    def show(self) -> None:
        """Bring it up to date."""
        desk = self._desk
        self._start.set_enabled(desk.job is None)
        between = desk.beside(AxleToBody)
        if between is not self._seen:
            self._seen = between
            self._body.set_content(between.html if between else "")
