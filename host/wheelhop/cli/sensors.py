"""Are a campaign's sensors fit for use? A line for each thing that is not."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import Console
from rich.text import Text

from wheelhop.calibration.health.examine import examine, examine_relations
from wheelhop.calibration.health.finding import Finding
from wheelhop.campaign import Campaign, ComponentCampaign, Run
from wheelhop.logger.recording import Channel, Recording


def print_sensors(campaign: Campaign, console: Console) -> None:
    """Print what an examination of all recordings finds; nothing for a component on a rig."""
    if isinstance(campaign, ComponentCampaign):
        return
    found = list(_findings(campaign))
    if not found:
        console.print("sensors   nothing found wrong with them", markup=False)
    for run, finding in found:
        who = ", ".join(finding.channels) or "all channels"
        where = f" in {run}" if run else ""
        console.print(
            Text(f"sensors   {who}{where}: {finding.what} ({finding.sure}); {finding.remedy}")
        )


def _findings(campaign: Campaign) -> Iterator[tuple[str, Finding]]:
    recordings = [_recording(campaign, run) for run in campaign.runs]
    for finding in examine_relations(recordings)[0]:
        yield "", finding
    for run, recording in zip(campaign.runs, recordings, strict=True):
        for finding in examine(recording, relations=False).findings:
            yield run.id, finding


def _recording(campaign: Campaign, run: Run) -> Recording:
    channels = tuple(Channel(item.name, item.unit, item.point) for item in campaign.channels)
    return Recording(run.record, campaign.sample_rate_hz, channels, float(run.time_s[0]))
