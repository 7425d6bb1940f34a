"""`wheelhop recover`: save what can be saved of a damaged log or card."""

from argparse import Namespace

from rich.table import Table

from wheelhop.cli.output import open_console
from wheelhop.cli.progress import stages
from wheelhop.logger import read_log, recover

ALL, SOME = 0, 1  # exit status; 2, as for every input that is of no use: nothing


def run(arguments: Namespace) -> int:
    """Write the sessions that are found, and show them in a table; raises LoggerError."""
    like = read_log(arguments.header_from) if arguments.header_from else None
    table = Table("file", "due", "written", "lost", "damaged", "what is not as it was", box=None)
    complete = True
    with stages() as stage:
        found = recover(
            arguments.file,
            arguments.into,
            header_from=like,
            progress=lambda done: stage(f"recovering {arguments.file}: {done:.0%}"),
        )
        for one in found:
            stage(f"{one.path} is written, read back and the same")
            complete &= one.complete
            counts = (str(n) for n in (one.due, one.written, one.lost, one.damaged))
            table.add_row(str(one.path), *counts, "; ".join(one.troubles) or "nothing")
    open_console().print(table)
    return ALL if complete else SOME
