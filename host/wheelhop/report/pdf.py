"""A report as PDF: printed by a browser that is on this computer, as it would print it by hand."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from wheelhop.files import InputError, replacing

NAMES = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable"),
    *("microsoft-edge", "msedge", "chrome"),
)
PLACES = {
    "darwin": (
        "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
        "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
        "/Applications/Chromium.app/Contents/MacOS/Chromium",
    ),
    "win32": (
        r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
        r"C:\Program Files\Microsoft\Edge\Application\msedge.exe",
        r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    ),
}
"""Where they are if they are on no path."""
PATIENCE_S = 120.0


def find_browser() -> str | None:
    """A browser that can print without a window: Chromium, Chrome or Edge."""
    for name in NAMES:
        if found := shutil.which(name):
            return found
    return next((place for place in PLACES.get(sys.platform, ()) if Path(place).is_file()), None)


def write_pdf(html: Path, pdf: Path) -> None:
    """Print a self-contained page; it is fetched from nowhere but its file. Raises InputError where
    there is no browser, or it cannot."""
    browser = find_browser()
    if browser is None:
        raise InputError(
            f"{pdf}: no Chromium, Chrome or Edge to print it with: open {html.name} in your browser"
            " and print it into a PDF"
        )
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as other:
        printed = Path(other) / "report.pdf"
        command = [
            *(browser, "--headless", "--disable-gpu", "--disable-background-networking"),
            *("--no-first-run", f"--user-data-dir={other}/profile", "--no-pdf-header-footer"),
            *(("--no-sandbox",) if getattr(os, "geteuid", lambda: 1)() == 0 else ()),
            *(f"--print-to-pdf={printed}", html.resolve().as_uri()),
        ]
        try:
            subprocess.run(command, capture_output=True, timeout=PATIENCE_S, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise InputError(f"{pdf}: {browser} does not print: {error}") from None
        if not printed.is_file():
            raise InputError(f"{pdf}: {browser} printed nothing: open {html.name} and print it")
        with replacing(pdf, InputError) as draft:
            draft.write_bytes(printed.read_bytes())
