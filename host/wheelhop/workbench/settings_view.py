"""Settings: how the settings that the runs name differ, without any model."""

from __future__ import annotations

from nicegui import ui

from wheelhop.workbench.desk import Desk
from wheelhop.workbench.shown import Settings
from wheelhop.workbench.view import Looking, drawn

WHAT = (
    "Which setting differs from the first one, where, and in which band. It takes no model, no"
    " survey and one sensor; it says what a change did, and not why."
)


class SettingsView:
    """The report's sections, once asked for."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk = desk
        self._seen: object = None
        with ui.row().classes("bench-controls"):
            self._start = ui.button("Compare the settings", on_click=lambda: desk.find("settings"))
            self._start.props("no-caps unelevated")
            ui.label(WHAT).classes("soft")
        self._body = drawn()

    def show(self) -> None:
        """Bring it up to date."""
        self._start.set_enabled(self._desk.job is None)
        found = self._desk.beside(Settings)
        if found is not self._seen:
            self._seen = found
            self._body.set_content(found.html if found else "")
