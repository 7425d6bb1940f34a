"""`wheelhop diagnose`: which effects are missing."""

from __future__ import annotations

from argparse import Namespace

from rich.console import Console

from wheelhop.campaign import read_campaign
from wheelhop.cli.console import open_console
from wheelhop.cli.exchange import write_json
from wheelhop.cli.progress import stages
from wheelhop.cli.show import (
    print_findings,
    print_ladder,
    print_limits,
    print_parameters,
    print_ranking,
    print_verdict,
)
from wheelhop.diagnose import Diagnosis, diagnose, to_json
from wheelhop.effects import load_effects
from wheelhop.report.reports import write_diagnosis_report
from wheelhop.report.words import next_run_words
from wheelhop.vehicle import read_nominal


def run(arguments: Namespace) -> int:
    """Diagnose, print, write JSON and report; raises CampaignError."""
    effects = load_effects(arguments.effects)
    campaign = read_campaign(arguments.campaign)
    vehicle = read_nominal(campaign)
    with stages() as progress:
        diagnosis = diagnose(
            campaign,
            vehicle,
            effects,
            max_effects=arguments.max_effects,
            jobs=arguments.jobs,
            progress=progress,
        )
    console = open_console()
    print_diagnosis(diagnosis, console)
    if arguments.json:
        write_json(arguments.json, to_json(diagnosis))
    if arguments.report:
        write_diagnosis_report(arguments.report, campaign, diagnosis, effects)
        console.print(f"report: {arguments.report}", markup=False)
    return 0


def print_diagnosis(diagnosis: Diagnosis, console: Console) -> None:
    """One screen: verdict, ranking, ladder, the accepted effects' numbers, what to record next."""
    print_findings([f for f in diagnosis.findings if f.when == "before"], console)
    print_verdict(diagnosis, console)
    print_findings([f for f in diagnosis.findings if f.when == "after"], console)
    print_ranking(diagnosis.ranking, console)
    print_ladder(diagnosis.ladder, console)
    print_parameters(diagnosis.ladder[-1], console)
    if diagnosis.verdict == ("none",):
        print_limits(diagnosis.limits, console)
    if diagnosis.next_run is not None:
        console.print(next_run_words(diagnosis.next_run), markup=False)
