"""Every channel in units of its noise: what lets travel and acceleration count beside each other.

A record is divided by its channel's `noise_scale`, the channel's noise over that of the campaign's
leading quantity. What is left is in the leading quantity's unit, and all of it is as noisy: sums of
squares are weighed by 1/σ² of every channel, as least squares ask for. Where every channel is an
acceleration of the campaign's noise the scales are 1.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wheelhop.campaign import Campaign, CampaignError
from wheelhop.compare.band import InBand
from wheelhop.compare.floor import estimate_noise
from wheelhop.compare.records import Record


def weighed(campaign: Campaign) -> Campaign:
    """The campaign with the noise scale of each of its channels.

    Noise that is not stated, of a channel or of its quantity, is estimated of the quantity from the
    quietest parts of the records.
    """
    leading = campaign.leading
    if all(c.quantity == leading.quantity and c.noise_rms is None for c in campaign.channels):
        return campaign
    noise = {leading.quantity: campaign.noise_rms}
    for quantity in campaign.quantities:
        of_it = [c.quantity == quantity for c in campaign.channels]
        stated = [c.noise_rms for c in campaign.channels if c.quantity == quantity]
        if noise.get(quantity) is None and (None in stated or quantity == leading.quantity):
            noise[quantity] = _estimated(campaign, np.array(of_it))
    reference = noise[leading.quantity] or 0.0
    scales = [
        (c.noise_rms or noise[c.quantity] or 0.0) / (reference or 1.0) for c in campaign.channels
    ]
    channels = zip(campaign.channels, scales, strict=True)
    return replace(
        campaign, channels=tuple(replace(c, noise_scale=scale or 1.0) for c, scale in channels)
    )


def with_noise(campaign: Campaign) -> Campaign:
    """The campaign with the noise of each of its channels stated, estimated as `weighed` does where
    it was not.

    Raises
    ------
    CampaignError
        It is not stated, and the records hold none.
    """
    counted, first = weighed(campaign), campaign.leading
    leading = np.array([c.quantity == first.quantity for c in campaign.channels])
    reference = campaign.noise_rms or _estimated(campaign, leading)
    if reference == 0.0:
        raise CampaignError(
            f"{campaign.folder / 'campaign.toml'}: the recordings hold no noise where they are"
            f" quietest: state {campaign.noise_key}"
        )
    channels = tuple(replace(c, noise_rms=c.noise_scale * reference) for c in counted.channels)
    return replace(counted, noise_rms=reference, channels=channels)


def _estimated(campaign: Campaign, columns: np.ndarray) -> float:
    """Noise in band of one of these channels, in the mean; 0 if they hold nothing."""
    records = []
    for run in campaign.runs:
        band = InBand(len(run.time_s), campaign.sample_rate_hz, campaign.band_hz)
        measured = band.coefficients(run.record[:, columns])
        predicted = np.ones(measured.shape[1], bool)
        records.append(Record(run, band, predicted, measured, measured, None))
    return float(np.sqrt(np.mean(estimate_noise(records) ** 2)))
