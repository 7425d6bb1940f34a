"""What the verbs are given: a campaign or its folder."""

from __future__ import annotations

from pathlib import Path

from wheelhop.campaign import Campaign, read_campaign

ONE_EACH = 1
"""Threads of linear algebra: every run is worked on by a thread of ours, more are in the way."""

Folder = Campaign | str | Path


def campaign_of(given: Folder) -> Campaign:
    """The campaign, read if only its folder is given."""
    return given if isinstance(given, Campaign) else read_campaign(given)
