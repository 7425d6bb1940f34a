"""What was changed in a campaign's files from the page, kept so that it can be taken back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from wheelhop.campaign import Campaign, CampaignError
from wheelhop.campaign.change import (
    CAMPAIGN,
    SESSION,
    VEHICLE,
    Change,
    Check,
    Rewritten,
    rewrite,
    rewritten,
)
from wheelhop.campaign.read import check_run
from wheelhop.files import InputError, read_text, read_toml, to_toml, write_text

FILE = "edits.toml"
MOST = 20
"""So many changes back can be taken back."""


@dataclass(frozen=True)
class Edit:
    """A change that was made: its words, and the files before and after."""

    title: str
    files: tuple[Rewritten, ...]


def read_edits(folder: Path) -> tuple[Edit, ...]:
    """The changes of a campaign's files, the last one at the end; none where they are not kept, or
    cannot be understood."""
    if not (folder / FILE).is_file():
        return ()
    try:
        top = read_toml(folder / FILE, CampaignError)
        top.format()
        return tuple(
            Edit(
                table.text("title"),
                tuple(
                    Rewritten(
                        each.text("file"), *map("\n".join, map(each.texts, ("before", "after")))
                    )
                    for each in table.tables("file", "file")
                ),
            )
            for table in top.tables("edit", "title")
        )
    except InputError:
        return ()


def planned(campaign: Campaign, changes: Sequence[Change]) -> list[Rewritten]:
    """What changes make of a campaign's files. Raises CampaignError."""
    vehicle = campaign.vehicle_file.relative_to(campaign.folder).as_posix()
    named = [replace(c, file=vehicle) if c.file == VEHICLE else c for c in changes]
    return rewritten(campaign.folder, [c for c in named if c.file != SESSION])


def make(campaign: Campaign, title: str, files: Sequence[Rewritten]) -> None:
    """Write files as they were planned, and keep how they were. Raises CampaignError, and then all
    is as before."""
    rewrite(campaign.folder, files, _check(campaign))
    _keep(campaign.folder, (*read_edits(campaign.folder), Edit(title, tuple(files))))


def take_back(campaign: Campaign) -> Edit:
    """Make the files what they were before the last change. Raises CampaignError, also where
    somebody else has changed one since."""
    *before, last = read_edits(campaign.folder)
    rewrite(
        campaign.folder,
        [Rewritten(each.file, each.after, each.before) for each in last.files],
        lambda file, draft: None,
    )
    _keep(campaign.folder, before)
    return last


def _check(campaign: Campaign) -> Check:
    first = next((run.id for run in campaign.runs if run.role == "fit"), campaign.runs[0].id)

    def check(file: Path, draft: Path) -> None:
        from wheelhop.vehicle import read_vehicle  # what computes is loaded when it is needed

        try:
            if file.name == CAMPAIGN:
                check_run(campaign.folder, read_text(draft, CampaignError), first)
            else:
                read_vehicle(draft)
        except CampaignError as error:
            raise CampaignError(str(error).replace(str(draft), str(file))) from None

    return check


def _keep(folder: Path, edits: Sequence[Edit]) -> None:
    document = {
        "format": 1,
        "edit": [
            {
                "title": edit.title,
                "file": [
                    {
                        "file": each.file,
                        "before": each.before.split("\n"),
                        "after": each.after.split("\n"),
                    }
                    for each in edit.files
                ],
            }
            for edit in edits[-MOST:]
        ],
    }
    write_text(folder / FILE, to_toml(document), CampaignError)
