"""`wheelhop thesis`: chapters 2 and 5 recomputed, beside the printed numbers."""

from __future__ import annotations

from argparse import Namespace
from math import isnan

from rich import box
from rich.table import Table

from wheelhop.campaign import CampaignError
from wheelhop.cli.output import open_console, write_json
from wheelhop.identify import Row, thesis_rows
from wheelhop.identify.row import KINDS


def run(arguments: Namespace) -> int:
    """Print each number with how ours came about, and a reason where it differs; raises
    CampaignError."""
    if arguments.frame and not arguments.figures:
        raise CampaignError("--frame: is for figure 6.1: give --figures FOLDER")
    rows = thesis_rows()
    console = open_console()
    table = Table(box=box.SIMPLE_HEAD)
    for name in ("table", "", "printed", "ours", "kind", "differs"):
        is_number = name in ("printed", "ours")
        table.add_column(name, justify="right" if is_number else "left", no_wrap=True)
    notes: dict[str, int] = {}
    for row in rows:
        mark = f"({notes.setdefault(row.reason, len(notes) + 1)})" if row.reason else ""
        numbers = f"{row.printed:.4g}", _ours(row)
        table.add_row(row.table, row.what, *numbers, row.kind, mark)
    console.print(table)
    for kind, what in KINDS.items():
        console.print(f"{kind}: {what}", markup=False, soft_wrap=True)
    for reason, number in notes.items():
        console.print(f"({number}) {reason}", markup=False, soft_wrap=True)
    if arguments.json:
        plain = [{**vars(row), "ours": None if isnan(row.ours) else row.ours} for row in rows]
        write_json(arguments.json, {"format": 1, "rows": plain})
    if arguments.figures:
        from wheelhop.report.thesis import write_thesis

        for path in write_thesis(arguments.figures, rows, arguments.frame):
            console.print(f"drawn: {path}", markup=False, soft_wrap=True)
    return 0


def _ours(row: Row) -> str:
    return "none" if isnan(row.ours) else f"{row.ours:.4g}"
