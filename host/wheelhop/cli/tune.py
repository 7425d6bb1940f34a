"""`wheelhop tune`: the best settings of a known car, before and after."""

from __future__ import annotations

from argparse import Namespace

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from wheelhop.api.tuning import tune
from wheelhop.campaign import CampaignError
from wheelhop.cli.output import open_console, write_json
from wheelhop.cli.progress import stages
from wheelhop.files.words import significant
from wheelhop.report.tune_words import amount, change, sentences, to_json
from wheelhop.tune.tuning import Tuning


def run(arguments: Namespace) -> int:
    """Search, print, and write what was asked for; raises CampaignError."""
    if arguments.seed < 0:
        raise CampaignError(f"--seed {arguments.seed}: must be a whole number from 0 up")
    with stages() as progress:
        found = tune(
            arguments.car,
            arguments.vary,
            arguments.tracks,
            arguments.speed,
            arguments.objective.split(","),
            effects=arguments.library,
            settings=arguments.settings,
            seconds=arguments.seconds,
            seed=arguments.seed,
            progress=progress,
        )
    console = open_console()
    _show(console, found)
    if arguments.json is not None:
        write_json(arguments.json, to_json(found))
    if arguments.report is not None:
        from wheelhop.report.tune import write_tune_report

        write_tune_report(arguments.report, found)
        console.print(f"report: {arguments.report}", markup=False)
    return 0


def _show(console: Console, found: Tuning) -> None:
    first, name = found.front[0], "proposed" if found.proposed else "compromise"
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("")
    for heading in ("now", name, "change (95 %)"):
        table.add_column(heading, justify="right")
    for o, now, score, gain in zip(
        found.objectives, found.now.scores, first.scores, first.gains, strict=True
    ):
        table.add_row(o.name, amount(now, o), amount(score, o), change(gain, o))
    table.add_section()
    for v in found.variables:
        table.add_row(Text(v.name), significant(v.now), significant(first.values[v.name]), "")
    console.print(table)
    for sentence in sentences(found):
        console.print(sentence, markup=False)
