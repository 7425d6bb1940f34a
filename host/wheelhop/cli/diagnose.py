"""`wheelhop diagnose`: which effects are missing."""

from __future__ import annotations

from argparse import Namespace

from rich.console import Console

from wheelhop.api import diagnose
from wheelhop.campaign import CampaignError
from wheelhop.cli.main import INTERRUPTED
from wheelhop.cli.output import open_console, write_json
from wheelhop.cli.progress import stages
from wheelhop.cli.show import (
    print_findings,
    print_ladder,
    print_limits,
    print_parameters,
    print_ranking,
    print_verdict,
)
from wheelhop.diagnose import Diagnosis
from wheelhop.law import LastRungs
from wheelhop.report.words import next_run_words


def run(arguments: Namespace) -> int:
    """Diagnose, print, write JSON and report; raises CampaignError. Interrupted, it says what is
    known by then.

    Of several campaigns the exit status is 1 if one has no verdict.
    """
    if arguments.more or arguments.out is not None:
        # Its tables are Arrow's: 25 MB that one campaign does without.
        from wheelhop.cli.diagnose_fleet import run_fleet

        return run_fleet(arguments)
    if arguments.cluster is not None:
        raise CampaignError("--cluster: is for several campaigns; one is diagnosed here")
    with stages() as progress:
        result = diagnose(
            arguments.campaign,
            effects=arguments.effects,
            max_effects=arguments.max_effects,
            to_the_end=arguments.all,
            budget_s=arguments.budget,
            jobs=arguments.jobs,
            progress=progress,
        )
    console = open_console()
    print_diagnosis(result.diagnosis, console, result.law)
    if arguments.json:
        write_json(arguments.json, result.to_json())
    if arguments.report:
        result.write_report(arguments.report)
        console.print(f"report: {arguments.report}", markup=False)
    ended = result.diagnosis.unfinished
    return INTERRUPTED if ended is not None and ended.ended_by == "interrupted" else 0


def print_diagnosis(diagnosis: Diagnosis, console: Console, law: LastRungs | None = None) -> None:
    """One screen: verdict, what was found beyond its names, ranking, ladder, the accepted effects'
    numbers, what to record next."""
    print_findings([f for f in diagnosis.findings if f.when == "before"], console)
    print_verdict(diagnosis, console)
    if law is not None:
        from wheelhop.report.law import beyond_names  # draws, and takes long to import

        for line in beyond_names(law):
            console.print(line, markup=False, highlight=False)
    print_findings([f for f in diagnosis.findings if f.when == "after"], console)
    print_ranking(diagnosis.ranking, console)
    print_ladder([*diagnosis.ladder, *([] if law is None else law.shown)], console)
    print_parameters(diagnosis.ladder[-1], console)
    if diagnosis.verdict == ("none",):
        print_limits(diagnosis.limits, console)
    if diagnosis.next_run is not None:
        console.print(next_run_words(diagnosis.next_run), markup=False)
