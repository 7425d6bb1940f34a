"""`wheelhop health`: is what was recorded fit for use?"""

from argparse import Namespace
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from wheelhop.calibration.health.checklist import PASS, check_commissioning
from wheelhop.calibration.health.examine import Health, examine, examine_relations
from wheelhop.cli.output import open_console, write_json
from wheelhop.formats import read
from wheelhop.logger.error import LoggerError
from wheelhop.logger.recording import Recording

UNHEALTHY = 1
STYLE = {"certain": "bold red", "likely": "red", "possible": "yellow"}
VERDICT_STYLE = {"pass": "green", "fail": "bold red", "open": "yellow"}
TOGETHER = "all together"


def run(arguments: Namespace) -> int:
    """Examine each recording, and all together; the exit status is 1 if anything is found.

    With `checklist`, go through the steps of commissioning instead: 1 if one has not passed.
    """
    for option in ("figure", "checklist"):
        if getattr(arguments, option) and len(arguments.recordings) > 1:
            raise LoggerError(f"--{option}: is for one recording, give only one")
    if arguments.figure and arguments.checklist:
        raise LoggerError("--figure: not together with --checklist, run health twice")
    console = open_console()
    if arguments.checklist:
        return _go_through_checklist(console, arguments)
    recordings = [read(file) for file in arguments.recordings]
    reports: dict[str, Health] = {}
    if len(recordings) == 1:
        reports[str(arguments.recordings[0])] = examine(recordings[0])
    else:
        for file, recording in zip(arguments.recordings, recordings, strict=True):
            reports[str(file)] = examine(recording, relations=False)
        known = [finding for health in reports.values() for finding in health.findings]
        reports[TOGETHER] = Health(*examine_relations(recordings, known))
    for name, health in reports.items():
        _show(console, name, health)
    if arguments.figure is not None:
        _draw(recordings[0], next(iter(reports.values())), arguments.figure)
        console.print(f"{arguments.figure} has the picture")
    if arguments.json is not None:
        write_json(arguments.json, {name: as_json(health) for name, health in reports.items()})
    return 0 if all(health.healthy for health in reports.values()) else UNHEALTHY


def _go_through_checklist(console: Console, arguments: Namespace) -> int:
    file = arguments.recordings[0]
    recording = read(file)
    try:
        checks = check_commissioning(recording)
    except LoggerError as error:
        raise LoggerError(f"{file}: {error}") from None
    passed = all(check.verdict == PASS for check in checks)
    for check in checks:
        verdict = f"[{VERDICT_STYLE[check.verdict]}]{check.verdict}[/]"
        console.print(f"{check.step:<10}{verdict}  {escape(check.seen)}")
        for remedy in check.remedies:
            console.print(f"{'':<16}→ {escape(remedy)}")
    console.print(f"{file}: {'ready to drive' if passed else 'not ready yet'}")
    if arguments.json is not None:
        write_json(arguments.json, {"passed": passed, "checks": [vars(check) for check in checks]})
    return 0 if passed else UNHEALTHY


def as_json(health: Health) -> dict[str, object]:
    """The result for programs."""
    findings = [
        {**vars(finding), "channels": list(finding.channels)} for finding in health.findings
    ]
    return {"healthy": health.healthy, "findings": findings, "untold": list(health.untold)}


def _draw(recording: Recording, health: Health, file: Path) -> None:
    from wheelhop.calibration.health.figure import draw_health

    draw_health(recording, health, file)


def _show(console: Console, name: str, health: Health) -> None:
    if health.healthy:
        console.print(f"{name}: [green]nothing found[/]")
    else:
        table = Table(
            box=None, header_style="bold", pad_edge=False, title=name, title_justify="left"
        )
        for title in ("channel", "what", "sure", "when s", "what to do"):
            table.add_column(title)
        for f in health.findings:
            who = ", ".join(f.channels) or "all"
            sure, when = f"[{STYLE[f.sure]}]{f.sure}[/]", f"{f.start_s:.1f}-{f.stop_s:.1f}"
            table.add_row(who, f.what, sure, when, f.remedy)
        console.print(table)
    for line in health.untold:
        console.print(f"not told: {line}", style="dim")
