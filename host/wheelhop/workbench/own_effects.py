"""Effects of the user's own: a file is shown, and runs only after he has said so."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui

from wheelhop.campaign import CampaignError
from wheelhop.files import InputError, read_text
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.view import Words, html, verbatim

SHOWN = 20_000  # characters
ASKED = (
    "An effect is a program: it may do on this computer whatever you may. Load it if you wrote it,"
    " or trust who did. This is what would run:"
)


class OwnEffects:
    """A field for a file, and the question."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        with ui.expansion("An effect of your own").classes("bench-better"):
            with ui.row().classes("bench-controls"):
                self._file = ui.input("file, such as my_effects.py").props("dense outlined")
                self._file.classes("bench-path").on("keydown.enter", self._ask)
                ui.button("Look at it", on_click=self._ask).props("no-caps outline")
            ui.label("docs/writing-an-effect.md says how to write one.").classes("soft")

    def _ask(self) -> None:
        file = Path(self._file.value.strip()).expanduser()
        try:
            text = read_text(file, CampaignError)
        except InputError as error:
            self._desk.say(str(error))
            return
        more = "\n…" if len(text) > SHOWN else ""
        with ui.dialog() as dialog, ui.card().classes("bench-dialog"):
            Words(str(file), "h3")
            ui.label(ASKED)
            html(verbatim(text[:SHOWN] + more))

            def load() -> None:
                dialog.close()
                self._desk.use_effects(file)

            with ui.row().classes("bench-controls"):
                ui.button("Load it", on_click=load).props("no-caps unelevated")
                ui.button("Leave it", on_click=dialog.close).props("no-caps outline autofocus")
        dialog.open()
