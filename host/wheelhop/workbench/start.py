"""The start: open a campaign, look at an example, or make one of recordings."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from nicegui import run, ui

from wheelhop.files import InputError
from wheelhop.workbench.bench import Workbench
from wheelhop.workbench.folder_view import FolderPicker
from wheelhop.workbench.guide import Guide
from wheelhop.workbench.places import examples, for_tour, recent, to_open
from wheelhop.workbench.record_view import RecordView
from wheelhop.workbench.theme import theme_menu
from wheelhop.workbench.tour import EXAMPLE
from wheelhop.workbench.view import Words, html

LOOK_S = 0.5
WORDS = (
    "A <em>campaign</em> is one vehicle, driven a few times, with sensors on its body and on its"
    " axles or dampers. Drop the files, say what was driven, and give four numbers of the"
    " vehicle: the workbench fits a model and finds out which physics it is missing."
)


class Start:
    """What to see while no campaign is on the bench."""

    def __init__(self, bench: Workbench) -> None:
        self._bench = bench
        self._reading = ""
        self._picker = FolderPicker()
        with ui.element("header").classes("bench-head"):
            Words("wheelhop workbench", "h1")
            theme_menu()
        self._notice = ui.label().classes("bench-notice").props('role="status"')
        self._notice.set_visibility(False)
        with ui.element("div").classes("bench-main"):
            with ui.element("section"):
                Words("From recordings to what the model is missing", "h2")
                html(f"<p>{WORDS}</p>")
                tour = ui.button("Take the tour: three minutes on an example", on_click=self._tour)
                tour.props("no-caps outline").set_visibility(bool(examples()))
                guide = Guide(bench.draft, self.put, self._say)
            with ui.element("section"):
                Words("Open a campaign that is there", "h2")
                with ui.row().classes("bench-controls"):
                    self._folder = ui.input("its folder").props("dense outlined")
                    self._folder.classes("bench-path").on("keydown.enter", self._open)
                    ui.button("Open", on_click=self._open).props("no-caps unelevated")
                    look = ui.button("Look for it …", on_click=self._look_for_it)
                    look.props("no-caps outline")
                self._list("Opened lately:", recent())
                self._list("Examples to look at:", examples())
            with ui.element("section"):
                Words("Record with the logger", "h2")
                recording = ui.element("div")
            with recording:
                RecordView(bench.recorder, Path.home() / "wheelhop", guide.take)
        ui.timer(LOOK_S, self._look)

    async def put(self, folder: Path) -> None:
        """Open a campaign; a mistake is said, and how far reading is."""
        self._say(f"reading {folder}")
        try:
            folder = await run.io_bound(to_open, folder) or folder
            await run.io_bound(self._bench.put, folder, self._read)
        except InputError as error:
            self._say(str(error))

    async def _open(self) -> None:
        text = self._folder.value.strip()
        if text:
            await self.put(Path(text).expanduser())

    async def _tour(self) -> None:
        try:
            folder = await run.io_bound(for_tour, EXAMPLE)
        except InputError as error:
            self._say(str(error))
            return
        if folder is not None:
            await self.put(folder)
            self._bench.touring = self._bench.desk is not None

    def _read(self, line: str) -> None:
        """Told by the thread that reads; shown by the next look."""
        self._reading = line

    def _list(self, words: str, found: list[Path]) -> None:
        if not found:
            return
        Words(words, "p").classes("soft")
        with ui.row():
            for folder in found:
                button = ui.button(folder.name, on_click=partial(self.put, folder))
                button.props("no-caps outline").tooltip(str(folder))

    async def _look_for_it(self) -> None:
        folder = await self._picker.choose()
        if folder is not None:
            await self.put(folder)

    def _say(self, line: str) -> None:
        self._notice.set_text(line)
        self._notice.set_visibility(bool(line))

    def _look(self) -> None:
        if self._reading:
            self._say(self._reading)
            self._reading = ""
        if self._bench.desk is not None:
            ui.navigate.reload()
