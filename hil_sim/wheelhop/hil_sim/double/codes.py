"""What the sensors would have put out in a campaign's run."""

from pathlib import Path

import numpy as np

from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.hil_sim.signals import CHANNELS, Signals

CODES_PER_G = 19.5  # an ADXL326 whose supply is the converter's reference
MIDDLE = 512.0
INPUTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
"""The points that the logger's inputs A0 … A7 have by default."""


def from_campaign(
    folder: Path | str,
    run: str,
    *,
    codes_per_g: float = CODES_PER_G,
    zero: float = MIDDLE,
    repeat: bool = True,
) -> Signals:
    """The accelerations of a run (m/s²) as codes at the eight inputs; points it lacks are at rest.

    Codes are left unrounded: rounding is what the converter does. Raises CampaignError, also for a
    run that the campaign does not have.
    """
    from wheelhop.campaign import CampaignError, read_campaign

    campaign = read_campaign(folder)
    runs = {item.id: item for item in campaign.runs}
    if run not in runs:
        raise CampaignError(f"{folder}: no run '{run}', there are {', '.join(runs)}")
    codes = np.full((len(runs[run].record), CHANNELS), zero)
    for column, channel in enumerate(campaign.channels):
        if channel.point in INPUTS:
            record = runs[run].record[:, column]
            codes[:, INPUTS.index(channel.point)] += record / STANDARD_GRAVITY_M_S2 * codes_per_g
    return Signals(codes, campaign.sample_rate_hz, repeat)
