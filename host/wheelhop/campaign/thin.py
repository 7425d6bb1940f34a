"""A recording of far more samples a second than its band needs is made lighter before a fit."""

from __future__ import annotations

from dataclasses import replace

from wheelhop.campaign.common import frozen
from wheelhop.campaign.types import Campaign, ComponentCampaign, Run

LEAST_HZ, TOP_OF_BAND = 100.0, 0.3
"""The rate that is left, and the top of the band over it: at least those of our own logger."""


def thinning(campaign: Campaign) -> int:
    """How many samples may become one: 1 where the rate is not more than the band needs."""
    if isinstance(campaign, ComponentCampaign):  # its force is compared at every displacement
        return 1
    enough_hz = max(LEAST_HZ, campaign.band_hz[1] / TOP_OF_BAND)
    return max(1, int(campaign.sample_rate_hz / enough_hz + 1e-9))


def thinned(campaign: Campaign) -> Campaign:
    """The campaign with `thinning` samples in a row replaced by their mean.

    The model is averaged in the same way (`Campaign.averaging`), so what the means fold into the
    band, and by how much they lower its top, is the same on both sides.
    """
    n = thinning(campaign)
    if n == 1:
        return campaign
    return replace(
        campaign,
        sample_rate_hz=campaign.sample_rate_hz / n,
        means=n * campaign.means,
        runs=tuple(_thinned(run, n) for run in campaign.runs),
    )


def _thinned(run: Run, n: int) -> Run:
    rows = len(run.time_s) // n * n
    return replace(
        run,
        time_s=frozen(run.time_s[:rows].reshape(-1, n).mean(axis=1)),
        record=frozen(run.record[:rows].reshape(rows // n, n, -1).mean(axis=1)),
        known={k: frozen(v[:rows].reshape(-1, n).mean(axis=1)) for k, v in run.known.items()},
    )
