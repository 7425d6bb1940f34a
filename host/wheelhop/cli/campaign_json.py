"""What `check --json` says of a campaign."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from wheelhop.campaign import Campaign, Channel, ComponentCampaign, find_duplicates
from wheelhop.campaign.known import asked_by
from wheelhop.gate import Finding
from wheelhop.gate import to_json as findings_to_json


def campaign_to_json(campaign: Campaign, findings: Sequence[Finding]) -> dict[str, Any]:
    """Plain dictionaries, lists, strings and numbers, in SI; what is not known is None."""
    names = [channel.name for channel in campaign.channels]
    return {
        "format": 1,
        "title": campaign.title,
        "kind": "component" if isinstance(campaign, ComponentCampaign) else "vehicle",
        "sample_rate_hz": campaign.sample_rate_hz,
        "band_hz": list(campaign.band_hz),
        "averaging_s": campaign.averaging_s,
        "channels": [
            {"name": c.name, "quantity": c.quantity, "unit": c.unit, "place": c.point}
            | {"noise_rms": _noise(campaign, c), "filter": "" if of is None else str(of)}
            for c, of in zip(campaign.channels, campaign.filters, strict=True)
        ],
        "known": [
            {"name": c.name, "quantity": c.quantity, "unit": c.unit, "asked_by": asked_by(c)}
            for c in campaign.known
        ],
        "runs": [
            {
                "id": run.id,
                "role": run.role,
                "track": run.track.kind,
                "speed_m_s": run.speed_m_s,
                "duration_s": len(run.time_s) / campaign.sample_rate_hz,
                "samples": len(run.time_s),
                "rms": dict(zip(names, run.record.std(axis=0).tolist(), strict=True)),
            }
            for run in campaign
        ],
        "findings": findings_to_json(findings),
        "duplicates": [str(duplicate) for duplicate in find_duplicates(campaign)],
    }


def _noise(campaign: Campaign, channel: Channel) -> float | None:
    """Its noise in band, in its unit; None where nothing is stated of it."""
    of_leading = channel.quantity == campaign.leading.quantity
    stated = campaign.noise_rms if of_leading else None
    return stated if channel.noise_rms is None else channel.noise_rms
