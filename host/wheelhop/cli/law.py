"""`wheelhop law`: the force a model is missing, as a curve and as a formula."""

from __future__ import annotations

from argparse import Namespace

from rich.console import Console

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.cli.output import open_console, write_json
from wheelhop.cli.progress import stages
from wheelhop.cli.show import print_findings
from wheelhop.effects import load_effects, pick
from wheelhop.files import write_text
from wheelhop.gate import gate
from wheelhop.law import Formula, Found, find_law, source_of
from wheelhop.report.law import law_lines, law_to_json, write_law_figure
from wheelhop.report.law_page import write_law_report
from wheelhop.vehicle import read_nominal

SAVED_ID = "found-law"


def run(arguments: Namespace) -> int:
    """Find, print, write JSON, report, figure and effect file; raises CampaignError."""
    library = load_effects(arguments.effects)
    accepted = pick(arguments.accepted, library)
    if arguments.save and arguments.save.suffix != ".py":
        raise CampaignError(f"{arguments.save}: an effect is a Python file; end its name in .py")
    campaign = read_campaign(arguments.campaign)
    vehicle = read_nominal(campaign)
    gated = gate(campaign, vehicle)
    campaign = gated.campaign
    with stages() as progress:
        found = find_law(campaign, vehicle, accepted, list(library.values()), progress)
    console = open_console()
    print_findings(gated.findings, console)
    print_law(found, console)
    if arguments.json:
        write_json(arguments.json, law_to_json(found))
    if arguments.report:
        write_law_report(arguments.report, campaign, found)
        console.print(f"report: {arguments.report}", markup=False)
    if found.free is not None and arguments.figure:
        if found.moved is None:
            console.print("no figure: nothing recorded tells how that place moved", markup=False)
        else:
            write_law_figure(found, arguments.figure)
            console.print(f"figure: {arguments.figure}", markup=False)
    if found.formula is not None and arguments.save:
        model = found.formula.rung.model
        formula = next(e for e in model.effects if isinstance(e, Formula))
        text = source_of(formula, model.values, campaign.title, SAVED_ID)
        write_text(arguments.save, text)
        console.print(f"formula kept in {arguments.save}", markup=False)
    elif arguments.save:
        console.print(f"{arguments.save} not written: there is no formula", markup=False)
    return 0


def print_law(found: Found, console: Console) -> None:
    """Where, what, and how well, laws with the lowest held-out error first."""
    for line in law_lines(found):
        console.print(line, markup=False, highlight=False)
