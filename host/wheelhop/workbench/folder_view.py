"""A folder chosen by looking, in place of typing its name."""

from __future__ import annotations

from html import escape
from pathlib import Path

from nicegui import run, ui

from wheelhop.files import InputError
from wheelhop.workbench.places import folders, holds_one
from wheelhop.workbench.view import Words, acting, html


class FolderPicker:
    """The folders of this computer, one level at a time; campaigns come first."""

    def __init__(self) -> None:
        self._here, self._listed = Path.home(), list[Path]()
        with ui.dialog() as self._dialog, ui.card().classes("bench-dialog"):
            Words("Open a campaign", "h3")
            self._place = ui.label().classes("soft")
            self._list = acting(html(), self._act)
            with ui.row():
                ui.button("Leave it", on_click=self._dialog.close).props("no-caps flat")

    async def choose(self) -> Path | None:
        """The folder chosen, None where none was."""
        await self._show(self._here)
        chosen = await self._dialog
        return chosen if isinstance(chosen, Path) else None

    async def _act(self, data: dict[str, str]) -> None:
        if data["act"] == "up":
            await self._show(self._here.parent)
            return
        folder = self._listed[int(data["folder"])]
        if data["act"] == "open":
            self._dialog.submit(folder)
        else:
            await self._show(folder)

    async def _show(self, place: Path) -> None:
        try:
            listed = await run.io_bound(folders, place)
        except InputError as error:
            self._place.set_text(str(error))
            return
        self._here, self._listed = place, listed or []
        self._place.set_text(str(place))
        items = "".join(_item(i, folder) for i, folder in enumerate(self._listed))
        up = '<li><button data-act="up">↑ the folder above</button></li>'
        self._list.set_content(f'<ul class="folders">{up}{items}</ul>')


def _item(number: int, folder: Path) -> str:
    act, mark = ("open", " <strong>campaign</strong>") if holds_one(folder) else ("into", "")
    name = escape(folder.name)
    return f'<li><button data-act="{act}" data-folder="{number}">{name}</button>{mark}</li>'
