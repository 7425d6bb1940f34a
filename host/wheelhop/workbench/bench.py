"""The bench: which campaign is on it, and what may be put there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from wheelhop.campaign import Campaign, CampaignError, read_campaign
from wheelhop.campaign.change import Rewritten
from wheelhop.files import Source, claimed
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.edits import make, take_back
from wheelhop.workbench.places import remember
from wheelhop.workbench.recorder import Recorder
from wheelhop.workbench.session import unread

if TYPE_CHECKING:
    from wheelhop.workbench.draft import Draft


class Workbench:
    """At most one campaign at a time; its folder is claimed as long as it is open. The file with
    effects of the user's own is read once; raises CampaignError if it cannot be."""

    def __init__(self, effects_file: Path | None = None) -> None:
        self.desk: Desk | None = None
        self.recorder = Recorder()
        self.touring = False
        self._draft: Draft | None = None
        self._effects = None if effects_file is None else Source.read(effects_file, CampaignError)
        self._claims = ExitStack()

    @property
    def draft(self) -> Draft:
        """The runs in the making: of a new campaign, or for the one that is open."""
        from wheelhop.workbench.kept import draft_folder, resume  # they know every format

        if self._draft is None:
            into = None if self.desk is None else self.desk.campaign.folder
            self._draft = resume(draft_folder(into, self._claims), into)
        return self._draft

    def put(self, folder: Path, progress: Callable[[str], None] = lambda text: None) -> None:
        """Open a campaign in place of the one that is there; raises CampaignError, and then that
        one stays. `progress` is told how far reading is."""
        campaign = read_campaign(folder, (), progress, lambda runs: unread(folder, runs))
        if self.desk is None or not same(self.desk.campaign, campaign):
            claims = ExitStack()
            claims.enter_context(claimed(folder, "workbench", CampaignError))
            self.clear()
            self._claims = claims
        elif self.desk is not None:
            self.desk.close()
        self.desk = Desk(campaign, self._effects)
        self._draft = None
        remember(folder)

    def change(self, title: str, files: Sequence[Rewritten]) -> None:
        """Change files of the campaign that is open as planned, and open it as it is then. Raises
        CampaignError, and then all is as before."""
        campaign = self._open
        make(campaign, title, files)
        try:
            self.put(campaign.folder)
        except CampaignError:
            take_back(campaign)
            raise
        assert self.desk is not None
        self.desk.can_take_back = True
        self.desk.say(f"{title}: done")

    def take_back(self) -> None:
        """Make the files what they were before the last change; raises CampaignError."""
        last = take_back(self._open)
        self.put(self._open.folder)
        assert self.desk is not None
        self.desk.say(f"{last.title}: taken back")

    @property
    def _open(self) -> Campaign:
        if self.desk is None:
            raise CampaignError("no campaign is open any more")
        return self.desk.campaign

    def clear(self) -> None:
        """Put the campaign away."""
        if self.desk is not None:
            self.desk.close()
            self.desk = None
        self.touring = False
        self._draft = None
        self._claims.close()

    def close(self) -> None:
        """Put everything away, at the end."""
        self.recorder.close()
        self.clear()


def same(one: Campaign, other: Campaign) -> bool:
    """Whether two campaigns are in the same folder."""
    return one.folder.resolve() == other.folder.resolve()
