"""`wheelhop export`: a known car for other programs."""

from __future__ import annotations

from argparse import Namespace

from wheelhop.api.exporting import export
from wheelhop.cli.output import open_console
from wheelhop.files.words import listed


def run(arguments: Namespace) -> int:
    """Write the file and print its signals; raises CampaignError."""
    plant = export(arguments.car, arguments.file, arguments.effects, effects=arguments.library)
    console = open_console()
    console.print(
        f"{arguments.file}: {len(plant.states)} states, {len(plant.inputs)} inputs,"
        f" {len(plant.outputs)} outputs",
        markup=False,
    )
    if plant.laws:
        console.print(f"laws: {listed(plant.laws)}", markup=False)
    return 0
