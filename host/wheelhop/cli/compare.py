"""`wheelhop compare`: the fitted model against the measurements, effects added if wanted."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from typing import Any

from wheelhop.campaign import Campaign, read_campaign
from wheelhop.cli.console import open_console
from wheelhop.cli.exchange import pick, write_json
from wheelhop.cli.progress import stages
from wheelhop.cli.sensors import print_sensors
from wheelhop.cli.show import print_findings, print_ladder, print_parameters
from wheelhop.compare import print_comparison, to_json
from wheelhop.diagnose import Progress, Step, axle_driven
from wheelhop.diagnose.added import steps_with
from wheelhop.effects import Effect, load_effects
from wheelhop.gate import Finding, gate
from wheelhop.gate import to_json as findings_to_json
from wheelhop.report.reports import write_comparison_report
from wheelhop.report.words import chain_words
from wheelhop.vehicle import Vehicle, read_nominal


def run(arguments: Namespace) -> int:
    """Fit, print where the model fails, write JSON and report; raises CampaignError."""
    effects = pick(arguments.add, load_effects(arguments.effects))
    campaign = read_campaign(arguments.campaign)
    vehicle = read_nominal(campaign)
    gated = gate(campaign, vehicle)
    findings, campaign = gated.findings, gated.campaign
    with stages() as progress:
        steps = steps_with(campaign, vehicle, effects, progress)
        axles = _driven_by_axles(campaign, vehicle, effects, progress)
    console = open_console()
    print_findings(findings, console)
    print_comparison(steps[-1].comparison, console)
    print_sensors(campaign, console)
    if effects:
        console.print()
        print_ladder(steps, console)
        print_parameters(steps[-1], console)
    if axles is not None:
        console.print(chain_words(steps[-1], axles), markup=False)
    if arguments.json:
        write_json(arguments.json, comparison_json(steps, axles, findings))
    if arguments.report:
        write_comparison_report(arguments.report, campaign, steps, axles, findings)
        console.print(f"report: {arguments.report}", markup=False)
    return 0


def _driven_by_axles(
    campaign: Campaign, vehicle: Vehicle, effects: Sequence[Effect], progress: Progress
) -> Step | None:
    """The same model with the measured axle motion driving the body; None where that is not
    possible, or is what was compared already."""
    driven = axle_driven(campaign)
    if driven is None or all(run.track.kind == "unknown" for run in campaign.runs):
        return None
    acting = [effect for effect in effects if not effect.needs_road]
    return steps_with(driven, vehicle, acting, lambda text: progress(f"measured axles: {text}"))[-1]


def comparison_json(
    steps: Sequence[Step], axles: Step | None, findings: Sequence[Finding] = ()
) -> dict[str, Any]:
    """The last model's comparison, the errors on the way to it, the comparison of the same model
    driven by the measured axles, and what the gate found."""
    ladder = [
        {
            "added": list(step.added),
            "error_fit": step.rung.error_fit,
            "error_validate": None if step.rung.validation is None else step.rung.error_validate,
        }
        for step in steps
    ]
    return {
        "format": 1,
        "ladder": ladder,
        **to_json(steps[-1].comparison),
        "findings": findings_to_json(findings),
        "axle_driven": None if axles is None else to_json(axles.comparison),
    }
