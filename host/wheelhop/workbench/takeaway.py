"""What a session leaves in the campaign's folder; the commands and the script that repeat it."""

from __future__ import annotations

import shlex

from wheelhop.campaign import Campaign
from wheelhop.workbench.session import Choice

REPORT, PDF, MODEL, SCRIPT = "report.html", "report.pdf", "model.toml", "repeat.py"
FIGURES, TABLES = "figures", "tables"


def commands(campaign: Campaign, choice: Choice) -> list[str]:
    """The commands that come to the same model and report."""
    folder = shlex.quote(str(campaign.folder))
    lines = [f"wheelhop diagnose {folder} --report report.html"]
    if choice.added:
        names = " ".join(map(shlex.quote, choice.added))
        added = " ".join(f"--add {shlex.quote(name)}" for name in choice.added)
        lines.append(f"wheelhop compare {folder} {added} --report report.html")
        lines.append(f"wheelhop add {folder} {names}")
    return lines


def script(campaign: Campaign, choice: Choice) -> str:
    """A Python program that comes to the same model, and writes its report, figures and tables."""
    folder = str(campaign.folder.resolve())
    return f"""\
\"\"\"The session of the workbench, repeated: python {SCRIPT}\"\"\"

import wheelhop as wh
from wheelhop.workbench.session import Choice
from wheelhop.workbench.export import write_figures, write_tables

choice = {choice!r}

campaign = choice.applied(wh.read({folder!r}))
result = wh.compare(campaign, choice.added)
print(result)
print(result.ladder())
print(result.parameters())
result.write_report(campaign.folder / "report.html")
write_figures(campaign.folder / {FIGURES!r}, result)
write_tables(campaign.folder / {TABLES!r}, result)
"""
