"""`wheelhop diagnose A B C …`: many campaigns, one table and one page."""

from __future__ import annotations

from argparse import Namespace
from collections import Counter
from contextlib import nullcontext

from wheelhop.api.fleet import diagnose_fleet
from wheelhop.campaign import CampaignError
from wheelhop.cli.output import open_console
from wheelhop.cli.progress import stages
from wheelhop.predict.cluster import cluster
from wheelhop.report.fleet import write_fleet_report

NO_VERDICT = 1


def run_fleet(arguments: Namespace) -> int:
    """Diagnose each, print how often each verdict was given, write table and overview; raises
    CampaignError. The exit status is 1 if one has no verdict."""
    if arguments.out is None or arguments.out.suffix.lower() != ".parquet":
        raise CampaignError("several campaigns make a table: say where to with --out TABLE.parquet")
    if arguments.json is not None:
        raise CampaignError("--json: is of one campaign; --out TABLE.parquet has all of them")
    if arguments.jobs is not None and arguments.cluster is not None:
        raise CampaignError("--jobs: a cluster has its own workers; leave one of the two out")
    at = arguments.cluster
    with (
        stages() as progress,
        nullcontext() if at is None else cluster(at, progress) as executor,
    ):
        rows = diagnose_fleet(
            [arguments.campaign, *arguments.more],
            arguments.out,
            effects=arguments.effects,
            max_effects=arguments.max_effects,
            to_the_end=arguments.all,
            budget_s=arguments.budget,
            jobs=arguments.jobs,
            executor=executor,
            progress=progress,
        )
    console = open_console()
    problems = [str(row["problem"]) for row in rows if row["problem"]]
    count = Counter(str(row["verdict"]) for row in rows if not row["problem"])
    for verdict, many in count.most_common():
        console.print(f"{many:5d}  {verdict}", markup=False)
    for problem in problems:
        console.print(f"       no verdict: {problem}", markup=False)
    console.print(f"table: {arguments.out}", markup=False)
    if arguments.report is not None:
        write_fleet_report(arguments.report, rows)
        console.print(f"overview: {arguments.report}", markup=False)
    return NO_VERDICT if problems else 0
