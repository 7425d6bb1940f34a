"""Record with the logger, or take other recordings: their stretches join the campaign."""

from __future__ import annotations

from pathlib import Path

from nicegui import run, ui

from wheelhop.campaign import ComponentCampaign
from wheelhop.files import InputError
from wheelhop.workbench.bench import Workbench
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.guide import Guide
from wheelhop.workbench.record_view import RecordView
from wheelhop.workbench.view import Words, html

ON_RIG = "<p class='soft'>Recordings of a rig are added to campaign.toml by hand.</p>"


class LogInView:
    """The recorder above, the guide of the campaign's draft beneath."""

    def __init__(self, bench: Workbench, desk: Desk) -> None:
        if isinstance(desk.campaign, ComponentCampaign):
            html(ON_RIG)
            return

        async def done(folder: Path) -> None:
            try:
                await run.io_bound(bench.put, folder)
            except InputError as error:
                desk.say(str(error))

        with ui.element("section"):
            Words("Record with the logger", "h2")
            recording = ui.element("div")
        with ui.element("section"):
            Words("More runs for this campaign", "h2")
            guide = Guide(bench.draft, done, desk.say)
        with recording:
            RecordView(bench.recorder, desk.campaign.folder, guide.take)

    def show(self) -> None:
        """It looks after itself."""
