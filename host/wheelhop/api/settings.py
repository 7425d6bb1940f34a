"""`compare_settings`: which setting differs from which, where, and in which band."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wheelhop.campaign import Campaign, read_campaign
from wheelhop.compare import settings as compared
from wheelhop.compare.settings_words import sentences, to_frame, to_json

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, eq=False, repr=False)
class SettingsResult:
    """What a comparison of settings found; `comparison` holds all of it."""

    comparison: compared.SettingsComparison

    @property
    def sentences(self) -> tuple[str, ...]:
        """What differs, in words, and what these drives leave open."""
        return sentences(self.comparison)

    def differences(self) -> DataFrame:
        """What differs, as a table.

        Returns
        -------
        DataFrame
            A row for every setting, channel and band: power over that of the reference in dB, its
            interval, and whether it differs.
        """
        return to_frame(self.comparison)

    def to_json(self) -> dict[str, Any]:
        """What `wheelhop settings --json` writes.

        Returns
        -------
        dict
            Dictionaries, lists, texts and numbers; what is undetermined is None.
        """
        return to_json(self.comparison)

    def write_report(self, file: str | Path) -> None:
        """Write the report, one self-contained HTML page.

        Parameters
        ----------
        file
            Such as "settings.html"; what stood there is replaced.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        from wheelhop.report.settings import write_settings_report

        write_settings_report(Path(file), self.comparison)

    def __repr__(self) -> str:
        return f"<SettingsResult: {' '.join(self.sentences)}>"


def compare_settings(campaign: Campaign | str | Path, reference: str = "") -> SettingsResult:
    """Compare the settings of one vehicle over one course, without a model.

    Parameters
    ----------
    campaign
        The campaign, or its folder; its runs say `setting = "…"`.
    reference
        The setting the others are compared with; the first one by default.

    Returns
    -------
    SettingsResult
        What differs, where, in which band and by how much.

    Raises
    ------
    CampaignError
        It holds no two settings of one course, no such reference, or too short records.
    """
    given = campaign if isinstance(campaign, Campaign) else read_campaign(campaign)
    return SettingsResult(compared.compare_settings(given, reference))
