"""What a session leaves in the campaign's folder; the commands and the script that repeat it."""

from __future__ import annotations

import io
import shlex
import zipfile
from importlib.util import find_spec
from pathlib import Path

from wheelhop.campaign import Campaign
from wheelhop.files import read_bytes
from wheelhop.workbench.session import Choice

REPORT, PDF, MODEL, SCRIPT = "report.html", "report.pdf", "model.toml", "repeat.py"
SUMMARY, SUMMARY_PDF = "summary.html", "summary.pdf"
FIGURES, TABLES, WORKBOOK = "figures", "tables", "tables.xlsx"
SIGNALS, MDF = "signals.parquet", "signals-mdf4"
WRITTEN = {
    "report": REPORT,
    "report as PDF": PDF,
    "summary": SUMMARY,
    "summary as PDF": SUMMARY_PDF,
    "model": MODEL,
    "figures": FIGURES,
    "tables": TABLES,
    "tables as XLSX": WORKBOOK,
    "signals": SIGNALS,
    "signals as MDF4": MDF,
}
"""What the process that computes writes, and under which name in the campaign's folder."""
WHAT = {
    REPORT: "the whole story, one page that needs no network",
    PDF: "the same, printed by the Chromium, Chrome or Edge of this computer",
    SUMMARY: "one page in plain words: what is missing, how sure, what it changes, what to do next",
    SUMMARY_PDF: "the same, printed",
    MODEL: "the fitted model, for wheelhop and other programs",
    FIGURES: "SVG and PNG",
    TABLES: "CSV, units in the columns’ names, and the signals as Parquet",
    WORKBOOK: "all tables in one workbook",
    SIGNALS: "measured and modelled in band, every run",
    MDF: "the same, a file for each run",
    SCRIPT: "a Python program that comes to the same numbers",
}
NEEDS = {WORKBOOK: "openpyxl", MDF: "asammdf"}
"""Libraries without which a thing is not offered."""


def offered() -> dict[str, str]:
    """What can be written here, by its name on the page."""
    return {
        name: file
        for name, file in WRITTEN.items()
        if file not in NEEDS or find_spec(NEEDS[file]) is not None
    }


def packed(path: Path) -> bytes:
    """A folder that was written as one zip archive, to be downloaded."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(path.iterdir()):
            if file.is_file():
                archive.writestr(f"{path.name}/{file.name}", read_bytes(file))
    return made.getvalue()


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
