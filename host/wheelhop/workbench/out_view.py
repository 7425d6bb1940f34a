"""Take away: the report, the model, the data, and the commands that repeat the session."""

from __future__ import annotations

import shlex
from html import escape

from nicegui import ui

from wheelhop.campaign import Campaign
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.session import FILE, Choice
from wheelhop.workbench.view import Looking

REPORT, MODEL = "report.html", "model.toml"


class OutView:
    """Everything goes into the campaign's folder, under a name that is shown."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk = desk
        self._seen: object = None
        folder = desk.campaign.folder.resolve()
        ui.html(
            f"<p>Files are written into <code>{escape(str(folder))}</code>. The session itself is"
            f" kept there too, in <code>{FILE}</code>: the workbench opens where you left it.</p>",
            sanitize=False,
        )
        with ui.row().classes("bench-controls"):
            self._buttons = [
                ui.button("Write the report", on_click=self._report),
                ui.button("Write the model", on_click=self._model),
            ]
            for button in self._buttons:
                button.props("no-caps outline")
            self._open = ui.button("Look at the report", on_click=self._look)
            self._open.props("no-caps flat")
        self._commands = ui.html("", sanitize=False)

    def show(self) -> None:
        """Bring it up to date."""
        desk = self._desk
        self._open.set_visibility((desk.campaign.folder / REPORT).is_file())
        for button in self._buttons:
            button.set_enabled(desk.job is None)
        if desk.choice != self._seen:
            self._seen = desk.choice
            lines = commands(desk.campaign, desk.choice)
            body = "\n".join(map(escape, lines))
            self._commands.set_content(
                f"<h2>The same from the command line</h2><pre>{body}</pre>{_left(desk.choice)}"
            )

    def _report(self) -> None:
        self._desk.write(report=self._desk.campaign.folder / REPORT)

    def _model(self) -> None:
        self._desk.write(model=self._desk.campaign.folder / MODEL)

    def _look(self) -> None:
        ui.download.file(self._desk.campaign.folder / REPORT)


def commands(campaign: Campaign, choice: Choice) -> list[str]:
    """The commands that come to the same model and report."""
    folder = shlex.quote(str(campaign.folder))
    lines = [f"wheelhop diagnose {folder} --report report.html"]
    if choice.added:
        names = " ".join(map(shlex.quote, choice.added))
        added = " ".join(f"--add {shlex.quote(name)}" for name in choice.added)
        lines.append(f"wheelhop compare {folder} {added} --report report.html")
        lines.append(f"wheelhop add {folder} {names}")
    return lines


def _left(choice: Choice) -> str:
    if not (choice.without_runs or choice.without_channels or choice.roles):
        return ""
    return (
        "<p class='soft'>The commands take all runs and channels in the roles of campaign.toml;"
        " what was left out or changed here has to be changed there first.</p>"
    )
