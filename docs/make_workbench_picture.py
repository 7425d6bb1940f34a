"""Draw docs/workbench.png, a picture of the workbench in README.md: a real browser looks at it.

Needs Chromium. Run it from the repository: python docs/make_workbench_picture.py
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import Page, ViewportSize, sync_playwright

DOCS = Path(__file__).parent
EXAMPLE = DOCS.parent / "examples/open-driver-seat"
SIZE: ViewportSize = {"width": 1280, "height": 860}


def main() -> None:
    """Diagnose in the browser, and take a picture when the verdict is there."""
    chromium = shutil.which("chromium") or sys.exit("no Chromium: apt-get install chromium")
    with tempfile.TemporaryDirectory() as other, sync_playwright() as playwright:
        folder = Path(shutil.copytree(EXAMPLE, Path(other) / EXAMPLE.name))
        arguments = ["workbench", "--no-browser", str(folder)]
        command = [sys.executable, "-m", "wheelhop.cli.main", *arguments]
        server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        try:
            assert server.stdout is not None
            address = server.stdout.readline().split()[-1]
            browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
            take(browser.new_page(viewport=SIZE), address)
            browser.close()
        finally:
            server.terminate()
            server.wait(10)


def take(page: Page, address: str) -> None:
    """From the address to the picture."""
    page.set_default_timeout(900_000)
    page.goto(address)
    page.get_by_role("tab", name="What is missing").click()
    page.get_by_role("button", name="Find out what is missing").click()
    page.wait_for_selector(".verdict")
    page.wait_for_timeout(1500)
    page.screenshot(path=DOCS / "workbench.png")


if __name__ == "__main__":
    main()
