"""Effects of the user's own: a file is shown, and the text shown runs only after he said so."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui

from wheelhop.campaign import CampaignError
from wheelhop.files import InputError, Source
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.view import Words, html, verbatim

ASKED = (
    "An effect is a program: it may do on this computer whatever you may. Load it if you wrote it,"
    " or trust who did. These {lines} lines are what would run:"
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
        shown = self._read(Path(self._file.value.strip()).expanduser())
        if shown is None:
            return
        with ui.dialog() as dialog, ui.card().classes("bench-dialog"):
            Words(str(shown), "h3")
            ui.label(ASKED.format(lines=shown.text.rstrip().count("\n") + 1))
            html(verbatim(visible(shown.text)))

            def load() -> None:
                dialog.close()
                now = self._read(shown.path)
                if now == shown:
                    self._desk.use_effects(shown)
                elif now is not None:
                    self._desk.say(f"{shown}: has changed since it was shown: look at it again")

            with ui.row().classes("bench-controls"):
                ui.button("Load it", on_click=load).props("no-caps unelevated")
                ui.button("Leave it", on_click=dialog.close).props("no-caps outline autofocus")
        dialog.open()

    def _read(self, file: Path) -> Source | None:
        try:
            return Source.read(file, CampaignError)
        except InputError as error:
            self._desk.say(str(error))
            return None


def visible(text: str) -> str:
    """The text with escapes for characters that do not show, or that show others elsewhere (bidi
    controls: Boucher and Anderson, "Trojan Source", CVE-2021-42574)."""
    return "".join(
        c if c.isprintable() or c in "\n\t" else c.encode("unicode_escape").decode() for c in text
    )
