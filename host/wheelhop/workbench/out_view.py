"""Take away: the report, the model, figures, tables, and the commands and the script that repeat
the session."""

from __future__ import annotations

from functools import partial
from html import escape
from pathlib import Path

from nicegui import ui

from wheelhop.files import InputError, write_text
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.session import FILE, Choice
from wheelhop.workbench.takeaway import (
    FIGURES,
    MODEL,
    PDF,
    REPORT,
    SCRIPT,
    TABLES,
    commands,
    script,
)
from wheelhop.workbench.view import Looking, html, verbatim

REPORT_ADDRESS = "/report"
WRITTEN = {
    "report": REPORT,
    "report as PDF": PDF,
    "model": MODEL,
    "figures": FIGURES,
    "tables": TABLES,
}


class OutView:
    """Everything goes into the campaign's folder, under a name that is shown."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk = desk
        self._seen: object = None
        folder = desk.campaign.folder.resolve()
        html(
            f"<p>Files are written into <code>{escape(str(folder))}</code>. The session itself is"
            f" kept there too, in <code>{FILE}</code>: the workbench opens where you left it.</p>",
        )
        with ui.row().classes("bench-controls"):
            self._buttons = [
                ui.button(f"Write the {name}", on_click=partial(desk.write, file))
                for name, file in WRITTEN.items()
            ]
            self._buttons.append(ui.button("Write a script", on_click=self._script))
            for button in self._buttons:
                button.props("no-caps outline")
            self._open = ui.link("Look at the report", REPORT_ADDRESS, new_tab=True)
        self._commands = html()

    def show(self) -> None:
        """Bring it up to date."""
        desk = self._desk
        self._open.set_visibility((desk.campaign.folder / REPORT).is_file())
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
