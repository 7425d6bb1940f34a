"""Take away: the report, the model, figures, tables, and the commands and the script that repeat
the session."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from html import escape
from pathlib import Path

from nicegui import ui

from wheelhop.files import InputError, write_text
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.session import FILE, Choice
from wheelhop.workbench.takeaway import REPORT, SCRIPT, WHAT, commands, offered, script
from wheelhop.workbench.view import Looking, html, verbatim

REPORT_ADDRESS = "/report"
TAKEN = "/take"


class OutView:
    """Everything goes into the campaign's folder, under a name that is shown, and can be downloaded
    from there."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk = desk
        self._seen: object = None
        folder = desk.campaign.folder.resolve()
        html(
            f"<p>Files are written into <code>{escape(str(folder))}</code>. The session itself is"
            f" kept there too, in <code>{FILE}</code>: the workbench opens where you left it.</p>",
        )
        self._buttons: list[ui.button] = []
        self._links: dict[str, ui.link] = {}
        with ui.element("div").classes("bench-taken"):
            for name, file in offered().items():
                self._row(f"Write the {name}", file, partial(desk.write, file))
            self._row("Write a script", SCRIPT, self._script)
        self._open = ui.link("Look at the report", REPORT_ADDRESS, new_tab=True)
        self._commands = html()

    def _row(self, words: str, file: str, act: Callable[[], None]) -> None:
        """What it is, a button that writes it, and once it is there a link that downloads it."""
        button = ui.button(words, on_click=act).props("no-caps outline")
        ui.label(WHAT[file]).classes("soft")
        with ui.element("div"):
            self._links[file] = ui.link(f"Download {file}", f"{TAKEN}/{file}")
            self._links[file].props("download")
        self._buttons.append(button)

    def show(self) -> None:
        """Bring it up to date."""
        desk = self._desk
        self._open.set_visibility((desk.campaign.folder / REPORT).is_file())
        for file, link in self._links.items():
            link.set_visibility((desk.campaign.folder / file).exists())
        for button in self._buttons:
            button.set_enabled(desk.job is None)
        if (seen := (desk.choice, desk.effects_file)) != self._seen:
            self._seen = seen
            lines = commands(desk.campaign, desk.choice, self._effects)
            body = verbatim("\n".join(lines))
            self._commands.set_content(
                f"<h2>The same from the command line</h2>{body}{_left(desk.choice)}"
            )

    @property
    def _effects(self) -> Path | None:
        """The file of the user's own effects, which commands and scripts name."""
        source = self._desk.effects_file
        return None if source is None else source.path

    def _script(self) -> None:
        desk = self._desk
        try:
            text = script(desk.campaign, desk.choice, self._effects)
            write_text(desk.campaign.folder / SCRIPT, text)
            desk.say(f"script: {desk.campaign.folder / SCRIPT}")
        except InputError as error:
            desk.say(str(error))


def _left(choice: Choice) -> str:
    if not (choice.without_runs or choice.without_channels or choice.roles):
        return ""
    return (
        "<p class='soft'>The commands take all runs and channels in the roles of campaign.toml;"
        " what was left out or changed here has to be changed there first; the script does it"
        " all.</p>"
    )
