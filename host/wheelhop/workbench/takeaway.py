"""What a session leaves in the campaign's folder; the commands and the script that repeat it."""

from __future__ import annotations

import shlex
from pathlib import Path

from wheelhop.campaign import Campaign
from wheelhop.workbench.session import Choice

REPORT, PDF, MODEL, SCRIPT = "report.html", "report.pdf", "model.toml", "repeat.py"
FIGURES, TABLES = "figures", "tables"


def commands(campaign: Campaign, choice: Choice, effects_file: Path | None) -> list[str]:
    """The commands that come to the same model and report; `effects_file` holds the user's own
    effects, if there are any."""
    folder = shlex.quote(str(campaign.folder))
    own = f" --effects {shlex.quote(str(effects_file.resolve()))}" if effects_file else ""
    lines = [f"wheelhop diagnose {folder}{own} --report report.html"]
    if choice.added:
        names = " ".join(map(shlex.quote, choice.added))
        added = " ".join(f"--add {shlex.quote(name)}" for name in choice.added)
        lines.append(f"wheelhop compare {folder} {added}{own} --report report.html")
        lines.append(f"wheelhop add {folder} {names}{own}")
    return lines


def script(campaign: Campaign, choice: Choice, effects_file: Path | None) -> str:
    """A Python program that comes to the same model, and writes its report, figures and tables."""
    folder = str(campaign.folder.resolve())
    own = f", effects={str(effects_file.resolve())!r}" if effects_file else ""
    return f"""\
\"\"\"The session of the workbench, repeated: python {SCRIPT}\"\"\"

import wheelhop as wh
from wheelhop.workbench.session import Choice
from wheelhop.workbench.export import write_figures, write_tables

choice = {choice!r}

campaign = choice.applied(wh.read({folder!r}))
result = wh.compare(campaign, choice.added{own})
print(result)
print(result.ladder())
print(result.parameters())
result.write_report(campaign.folder / "report.html")
write_figures(campaign.folder / {FIGURES!r}, result)
write_tables(campaign.folder / {TABLES!r}, result)
"""
