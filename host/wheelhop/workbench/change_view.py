"""A change of the campaign's files as the user decides on it: the lines that go and come, one
button that makes it, and one that takes it back."""

from __future__ import annotations

from collections.abc import Callable
from html import escape

from nicegui import run, ui

from wheelhop.campaign import CampaignError
from wheelhop.campaign.change import SESSION, Proposal
from wheelhop.workbench.bench import Workbench
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.edits import planned
from wheelhop.workbench.view import Words, html

KINDS = {"+": "come", "-": "gone"}


class Changing:
    """The dialog in which a proposal is looked at."""

    def __init__(self, bench: Workbench, desk: Desk) -> None:
        self._bench, self._desk = bench, desk

    async def propose(self, proposal: Proposal) -> None:
        """Show what it would change, and make it where the user says so."""
        desk = self._desk
        runs = [c.value for c in proposal.changes if c.file == SESSION]
        try:
            files = await run.io_bound(planned, desk.campaign, proposal.changes)
        except CampaignError as error:
            desk.say(str(error))
            return
        with ui.dialog() as dialog, ui.card().classes("bench-dialog"):
            Words(proposal.title, "h3")
            if runs:
                left = f"Of this session: {', '.join(runs)} left out. Undo takes it back."
                ui.label(left)
            for each in files or ():
                html(f"<p class='soft'>{escape(each.file)}</p>{diff_html(each.lines())}")
            if not files and not runs:
                ui.label("Nothing changes: the file says so already.")
            with ui.row():
                make = ui.button("Make this change", on_click=lambda: dialog.submit(True))
                make.props("no-caps unelevated").set_enabled(bool(files or runs))
                ui.button("Leave it", on_click=dialog.close).props("no-caps flat")
        agreed = await dialog
        dialog.delete()
        if not agreed:
            return
        for name in runs:
            if name not in desk.choice.without_runs:
                desk.toggle_run(name)
        if files:
            await self._do(lambda: self._bench.change(proposal.title, files))

    async def take_back(self) -> None:
        """Undo the last change of the files."""
        await self._do(self._bench.take_back)

    async def _do(self, work: Callable[[], None]) -> None:
        try:
            await run.io_bound(work)
        except CampaignError as error:
            self._desk.say(str(error))


def diff_html(lines: list[str]) -> str:
    """Lines that go and come, told apart by sign, colour and words for who listens."""
    rows = "".join(_line(line) for line in lines)
    return f'<div class="diff" tabindex="0">{rows}</div>'


def _line(line: str) -> str:
    kind = KINDS.get(line[:1], "")
    tag = {"come": "ins", "gone": "del"}.get(kind, "span")
    return f"<{tag}>{escape(line) or '⋯'}</{tag}>"
