"""`wheelhop add`: make effects part of the model and keep it in the campaign's folder."""

from __future__ import annotations

from argparse import Namespace

from wheelhop.api import MODEL_FILE, add
from wheelhop.cli.output import open_console, write_json
from wheelhop.cli.progress import stages
from wheelhop.cli.show import print_findings, print_ladder, print_parameters


def run(arguments: Namespace) -> int:
    """Refit, print the ladder, store CAMPAIGN/model.toml; raises CampaignError."""
    with stages() as progress:
        result = add(
            arguments.campaign,
            *arguments.effects,
            effects=arguments.effects_file,
            progress=progress,
        )
    console = open_console()
    print_findings(result.findings, console)
    print_ladder(result.steps, console)
    print_parameters(result.last, console)
    if arguments.json:
        write_json(arguments.json, result.to_json())
    console.print(f"stored in {arguments.campaign / MODEL_FILE}", markup=False)
    return 0
