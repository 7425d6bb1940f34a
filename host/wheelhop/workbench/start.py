"""The start: open a campaign, look at an example, or make one of recordings."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui

from wheelhop.files import InputError
from wheelhop.workbench.bench import Workbench, examples
from wheelhop.workbench.guide import Guide
from wheelhop.workbench.record_view import RecordView

LOOK_S = 0.5


class Start:
    """What to see while no campaign is on the bench."""

    def __init__(self, bench: Workbench) -> None:
        self._bench = bench
        with ui.element("header").classes("bench-head"):
            ui.html("wheelhop workbench", sanitize=False, tag="h1")
        self._notice = ui.label().classes("bench-notice").props('role="status"')
        self._notice.set_visibility(False)
        with ui.element("div").classes("bench-main"):
            with ui.element("section"):
                ui.html("Open a campaign", sanitize=False, tag="h2")
                with ui.row().classes("bench-controls"):
                    self._folder = ui.input("folder that holds campaign.toml")
                    self._folder.classes("bench-path").on("keydown.enter", self._open)
                    ui.button("Open", on_click=self._open).props("no-caps unelevated")
                self._list_examples()
            with ui.element("section"):
                ui.html("Record with the logger", sanitize=False, tag="h2")
                recording = ui.element("div")
            with ui.element("section"):
                ui.html("Make a campaign of recordings", sanitize=False, tag="h2")
                guide = Guide(bench.draft, self.put, self._say)
            with recording:
                RecordView(bench.recorder, Path.home() / "wheelhop", guide.take)
        ui.timer(LOOK_S, self._look)

    def put(self, folder: Path) -> None:
        """Open a campaign; a mistake is said."""
        try:
            self._bench.put(folder)
        except InputError as error:
            self._say(str(error))
            return
        if self._bench.desk is not None:
            self._bench.desk.begin()

    def _open(self) -> None:
        text = self._folder.value.strip()
        if text:
            self.put(Path(text).expanduser())

    def _list_examples(self) -> None:
        found = examples()
        if not found:
            return
        ui.html("Examples to look at:", sanitize=False, tag="p").classes("soft")
        with ui.row():
            for folder in found:
                ui.button(folder.name, on_click=lambda folder=folder: self.put(folder)).props(
                    "no-caps outline dense"
                )

    def _say(self, line: str) -> None:
        self._notice.set_text(line)
        self._notice.set_visibility(bool(line))

    def _look(self) -> None:
        if self._bench.desk is not None:
            ui.navigate.reload()
