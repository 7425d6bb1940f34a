"""`wheelhop settings`: settings of one vehicle over one course, compared without a model."""

from __future__ import annotations

from argparse import Namespace

from wheelhop.api.settings import compare_settings
from wheelhop.cli.output import open_console, write_json


def run(arguments: Namespace) -> int:
    """Compare, print, write JSON and report; raises CampaignError."""
    found = compare_settings(arguments.campaign, arguments.reference)
    console = open_console()
    for sentence in found.sentences:
        console.print(sentence, markup=False)
    if arguments.json:
        write_json(arguments.json, found.to_json())
    if arguments.report:
        found.write_report(arguments.report)
        console.print(f"report: {arguments.report}", markup=False)
    return 0
