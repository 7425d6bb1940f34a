"""`wheelhop compare`: the fitted model against the measurements, effects added if wanted."""

from __future__ import annotations

from argparse import Namespace

from wheelhop.api import compare
from wheelhop.cli.output import open_console, write_json
from wheelhop.cli.progress import stages
from wheelhop.cli.sensors import print_sensors
from wheelhop.cli.show import print_findings, print_ladder, print_parameters
from wheelhop.compare import print_comparison
from wheelhop.report.words import chain_words


def run(arguments: Namespace) -> int:
    """Fit, print where the model fails, write JSON and report; raises CampaignError."""
    with stages() as progress:
        result = compare(
            arguments.campaign,
            arguments.add,
            effects=arguments.effects,
            by_axles=True,
            progress=progress,
        )
    console = open_console()
    print_findings(result.findings, console)
    print_comparison(result.comparison, console)
    print_sensors(result.symptoms, console)
    if arguments.add:
        console.print()
        print_ladder(result.steps, console)
        print_parameters(result.last, console)
    if result.axles is not None:
        console.print(chain_words(result.last, result.axles), markup=False)
    if arguments.json:
        write_json(arguments.json, result.to_json())
    if arguments.report:
        result.write_report(arguments.report)
        console.print(f"report: {arguments.report}", markup=False)
    return 0
