"""What a campaign's sensors show that the vehicle may have done as well: a line each."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.text import Text

from wheelhop.gate.sensors import OF_THE_VEHICLE, Seen


def print_sensors(symptoms: Sequence[Seen] | None, console: Console) -> None:
    """Print what an examination of all recordings finds possible and the gate leaves unsaid;
    nothing where none was made (None)."""
    if symptoms is None:
        return
    if not symptoms:
        console.print("sensors   nothing found wrong with them", markup=False)
    for run, symptom in symptoms:
        if symptom.kind in OF_THE_VEHICLE:
            who = ", ".join(symptom.channels) or "all channels"
            where = f" in {run.id}" if run else ""
            console.print(
                Text(f"sensors   {who}{where}: {symptom.what} ({symptom.sure}); {symptom.remedy}")
            )
