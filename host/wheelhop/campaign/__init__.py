"""The campaign folder on disk, read strictly into a `Campaign`."""

from wheelhop.campaign.averaging import Averaging
from wheelhop.campaign.channel import AXLE_POINTS, BODY_POINTS, Channel
from wheelhop.campaign.duplicates import Duplicate, find_duplicates
from wheelhop.campaign.read import read_campaign
from wheelhop.campaign.types import (
    Campaign,
    CampaignError,
    ComponentCampaign,
    RigRun,
    Run,
    TrackSpec,
)

__all__ = [
    "AXLE_POINTS",
    "BODY_POINTS",
    "Averaging",
    "Campaign",
    "CampaignError",
    "Channel",
    "ComponentCampaign",
    "Duplicate",
    "RigRun",
    "Run",
    "TrackSpec",
    "find_duplicates",
    "read_campaign",
]
