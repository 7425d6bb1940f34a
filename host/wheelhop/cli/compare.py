"""`wheelhop compare`: the fitted model against the measurements, effects added if wanted."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

from wheelhop.campaign import read_campaign
from wheelhop.cli.console import open_console
from wheelhop.cli.exchange import pick, write_json
from wheelhop.cli.progress import stages
from wheelhop.cli.show import print_ladder, print_parameters
from wheelhop.compare import print_comparison, to_json
from wheelhop.diagnose import Step
from wheelhop.diagnose.added import steps_with
from wheelhop.effects import load_effects
from wheelhop.report import write_comparison_report
from wheelhop.vehicle import read_vehicle


def run(arguments: Namespace) -> int:
    """Fit, print where the model fails, write JSON and report; raises CampaignError."""
    effects = pick(arguments.add, load_effects(arguments.effects))
    campaign = read_campaign(arguments.campaign)
    vehicle = read_vehicle(campaign.vehicle_file)
    with stages() as progress:
        steps = steps_with(campaign, vehicle, effects, progress)
    console = open_console()
    print_comparison(steps[-1].comparison, console)
    if effects:
        console.print()
        print_ladder(steps, console)
        print_parameters(steps[-1], console)
    if arguments.json:
        write_json(arguments.json, comparison_json(steps))
    if arguments.report:
        write_comparison_report(arguments.report, campaign, steps)
        console.print(f"report: {arguments.report}", markup=False)
    return 0


def comparison_json(steps: list[Step]) -> dict[str, Any]:
    """The last model's comparison, and the errors on the way to it."""
    ladder = [
        {
            "added": list(step.added),
            "error_fit": step.rung.error_fit,
            "error_validate": None if step.rung.validation is None else step.rung.error_validate,
        }
        for step in steps
    ]
    return {"format": 1, "ladder": ladder, **to_json(steps[-1].comparison)}
