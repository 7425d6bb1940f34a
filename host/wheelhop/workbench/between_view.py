"""Axle to body: what the records say lies between them, as transfer functions, beside the model."""

from __future__ import annotations

from nicegui import ui

from wheelhop.campaign import ComponentCampaign
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.view import Looking, drawn

WHY = (
    "Fitted to what the axles and the body did, knowing nothing of what the vehicle is made of."
    " Where it fits and the model does not, what is missing is linear."
)
ON_RIG = "<p class='soft'>A component on a rig has no axles and no body.</p>"


class BetweenView:
    """The statement, the picture and the table of levels, once asked for."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk = desk
        self._seen: object = None
        self._on_rig = isinstance(desk.campaign, ComponentCampaign)
        with ui.row().classes("bench-controls"):
            self._start = ui.button("Identify it", on_click=desk.identify)
            self._start.props("no-caps unelevated")
            ui.label(WHY).classes("soft")
        self._start.set_visibility(not self._on_rig)
        self._body = drawn()

    def show(self) -> None:
        """Bring it up to date."""
        desk = self._desk
        self._start.set_enabled(desk.job is None)
        if desk.between is not self._seen or self._on_rig:
            self._seen = desk.between
            body = ON_RIG if self._on_rig else desk.between.html if desk.between else ""
            self._body.set_content(body)
