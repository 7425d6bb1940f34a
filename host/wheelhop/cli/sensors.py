"""What a campaign's sensors show that the vehicle may have done as well: a line each."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from wheelhop.campaign import Campaign, ComponentCampaign
from wheelhop.gate.sensors import OF_THE_VEHICLE, examined


def print_sensors(campaign: Campaign, console: Console) -> None:
    """Print what an examination of all recordings finds possible and the gate leaves unsaid;
    nothing for a component on a rig."""
    if isinstance(campaign, ComponentCampaign):
        return
    found = list(examined(campaign))
    if not found:
        console.print("sensors   nothing found wrong with them", markup=False)
    for run, symptom in found:
        if symptom.kind in OF_THE_VEHICLE:
            who = ", ".join(symptom.channels) or "all channels"
            where = f" in {run.id}" if run else ""
            console.print(
                Text(f"sensors   {who}{where}: {symptom.what} ({symptom.sure}); {symptom.remedy}")
            )
