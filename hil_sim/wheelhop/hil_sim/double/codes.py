"""What the sensors would have put out in a campaign's run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.hil_sim.signals import CHANNELS, CODES, Signals

if TYPE_CHECKING:
    from wheelhop.campaign import Campaign

STROKE_M = 0.1
"""Of a damper potentiometer across the converter's reference: its wiper is in the middle where it
shows 0."""
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
    """Accelerations (m/s²) and travel (m) of a run as codes at the eight inputs, `inputs_of` says
    which; other inputs are at rest.

    Codes are left unrounded: rounding is what the converter does. Raises CampaignError, also for a
    run that the campaign does not have.
    """
    from wheelhop.campaign import CampaignError, read_campaign

    campaign = read_campaign(folder)
    runs = {item.id: item for item in campaign.runs}
    if run not in runs:
        raise CampaignError(f"{folder}: no run '{run}', there are {', '.join(runs)}")
    record = runs[run].record
    codes = np.full((len(record), CHANNELS), zero)
    for column, place in inputs_of(campaign).items():
        if campaign.channels[column].is_acceleration:
            codes[:, place] += record[:, column] / STANDARD_GRAVITY_M_S2 * codes_per_g
        else:
            codes[:, place] += record[:, column] / STROKE_M * CODES
    return Signals(codes, campaign.sample_rate_hz, repeat)


def inputs_of(campaign: Campaign) -> dict[int, int]:
    """At which input each channel of a campaign is, by its column: the eight points where they are
    by default, potentiometers and other accelerometers at those left over, in order. Nothing else,
    and nothing for which there is no input, is recorded."""
    found = {
        column: INPUTS.index(channel.point)
        for column, channel in enumerate(campaign.channels)
        if channel.point in INPUTS
    }
    free = [place for place in range(CHANNELS) if place not in found.values()]
    others = [
        column
        for column, channel in enumerate(campaign.channels)
        if column not in found and (channel.is_acceleration or channel.quantity == "travel")
    ]
    return found | dict(zip(others, free, strict=False))
