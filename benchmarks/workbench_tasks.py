"""Five tasks done in the workbench as a new user would: python -m benchmarks.workbench_tasks [WORD]

Real Chromium, from the first page to the answer. Clicks, fields filled in and seconds are counted,
and of each task what had to be done outside the browser. The script knows the way: wrong turns are
those of whoever reads the page, and are not counted here. WORD chooses tasks by their names.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pandas as pd
from playwright.sync_api import sync_playwright

from tests.component.cases import DAMPER
from tests.component.rig import make_campaign as make_rig
from tests.truth.campaign import write_campaign
from tests.truth.presets import PRESETS, planned_runs
from tests.workbench.test_draft import write_foreign

ROOT = Path(__file__).parents[1]
CLEAN, FRICTION = ROOT / "examples/clean", ROOT / "examples/open-dry-friction"
KEPT = (
    *("washboard-low-slow", "washboard-high-fast"),
    *("herringbone-low-fast", "herringbone-high-fast"),
)
PATIENCE_MS = 600_000


@dataclass
class User:
    """Someone at the page: every click and every field is counted."""

    page: Any
    clicks: int = 0
    fields: int = 0

    def click(self, name: str, role: str = "button", *, exact: bool = True) -> None:
        """Press something by its name."""
        self.page.get_by_role(role, name=name, exact=exact).first.click()
        self.clicks += 1

    def fill(self, label: str, text: str, at: int = 0) -> None:
        """Fill in a field by its label."""
        self.page.get_by_label(label).nth(at).fill(text)
        self.fields += 1

    def see(self, selector: str, text: str | re.Pattern[str] = "") -> str:
        """Wait for something to be there."""
        found = self.page.locator(selector, has_text=text).first
        found.wait_for()
        return str(found.inner_text())

    def open(self, folder: Path) -> None:
        """Open a campaign by its folder's name."""
        self.fill("its folder", str(folder))
        self.click("Open")
        self.see("[role=tab]", "Overview")

    def find_out(self) -> str:
        """Diagnose; the verdict."""
        self.click("What is missing", "tab")
        self.click("Find out what is missing")
        return self.see(".verdict h2")


def friction(user: User, folder: Path) -> str:
    """Friction in a campaign that is in order."""
    user.open(shutil.copytree(FRICTION, folder / "friction"))
    verdict = user.find_out()
    user.click("Add dry-friction to the model")
    user.see("dl.key", "baseline + dry-friction")
    return verdict


def swapped(user: User, folder: Path) -> str:
    """Two sensors exchanged."""
    campaign = shutil.copytree(CLEAN, folder / "swapped")
    for file in campaign.glob("runs/*.csv"):
        table = pd.read_csv(file)
        table.assign(A1=table.A3, A3=table.A1).to_csv(file, index=False)
    user.open(campaign)
    said = user.see("li", "exchanged")
    user.click("Write A1 at A3 and A3 at A1 …")
    user.click("Make this change")
    user.see(".bench-notice", "done")
    user.see("table.heat td.h0")
    return said.split(":")[0]


def damper(user: User, folder: Path) -> str:
    """A damper on a rig."""
    numbers = {"asymmetry": 0.4}
    part = replace(DAMPER, hidden="asymmetric-damper", numbers=numbers)
    user.open(make_rig(folder / "rig", "displacement", part, seed=1, noise=0.01))
    return user.find_out()


def three_files(user: User, folder: Path) -> str:
    """Three CSV files of a student's car."""
    files = write_foreign(folder)
    user.page.set_input_files("input[type=file]", [str(file) for file in files])
    user.clicks += 1
    user.page.get_by_label("speed, km/h").nth(2).wait_for()
    for i in range(3):
        user.fill("speed, km/h", "10", i)
    known = {"front wheels": 130, "rear wheels": 160, "wheelbase": 1.42, "track width": 1.18}
    for label, number in known.items():
        user.fill(label, str(number))
    user.click("Make the campaign")
    user.see("[role=tab]", "Overview")
    user.see("table.heat td:is(.h0, .h1, .h2, .h3, .h4)")
    return "a campaign whose baseline is fitted"


def new_damper(user: User, folder: Path) -> str:
    """Is the new damper better? Runs with the old and the new one, over the same tracks."""
    user.open(_two_settings(folder))
    user.click("Settings", "tab")
    user.click("Compare the settings")
    return user.see("[data-view=settings] h2")


def _two_settings(folder: Path) -> Path:
    """One vehicle with two dampers in front, each run driven with both."""
    preset = PRESETS["atv"]
    stiffer = dict(preset.vehicle)
    stiffer["suspension.front.damping_N_s_m"] *= 1.6
    planned = planned_runs(preset, short=True, lateral_offset_mm=0.0)
    others = [run.id for run in planned if run.id not in KEPT]
    more: dict[str, Any] = {
        "seed": 7,
        "short": True,
        "draft": True,
        "without": others,
        "seconds": 8.0,
    }
    made = {
        "old": write_campaign(folder / "old", preset, [], **more),
        "new": write_campaign(folder / "new", replace(preset, vehicle=stiffer), [], **more),
    }
    text = ""
    for setting, campaign in made.items():
        head, *runs = (campaign / "campaign.toml").read_text().split("[[run]]")
        text = text or head
        for run in runs:
            said = re.sub(r'(id = "|file = "runs/)', rf"\g<1>{setting}-", run)
            text += f'[[run]]{said.rstrip()}\nsetting = "{setting}"\n\n'
        for file in (campaign / "runs").iterdir():
            file.rename(made["old"] / "runs" / f"{setting}-{file.name}")
    (made["old"] / "campaign.toml").write_text(text)
    return made["old"]


TASKS: dict[str, tuple[Callable[[User, Path], str], str]] = {
    "friction in a clean campaign": (friction, ""),
    "a swapped sensor": (swapped, "before: an editor, and which columns was for the user to know"),
    "a damper on a rig": (damper, ""),
    "three CSV files": (three_files, ""),
    "is the new damper better?": (new_damper, ""),
}


@contextmanager
def served(home: Path) -> Iterator[str]:
    """A workbench without a campaign, with a home of its own."""
    command = [sys.executable, "-m", "wheelhop.cli.main", "workbench", "--no-browser"]
    environment = {**os.environ, "HOME": str(home)}
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, cwd=ROOT, env=environment
    )
    try:
        assert process.stdout is not None
        yield process.stdout.readline().split()[-1]
    finally:
        process.terminate()
        process.wait(10)


def main() -> None:
    """A line for each task."""
    word = sys.argv[1] if len(sys.argv) > 1 else ""
    chromium = shutil.which("chromium") or sys.exit("no Chromium: apt-get install chromium")
    print(f"{'task':32s} clicks fields seconds  what came of it", flush=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for name, (task, outside) in TASKS.items():
            if word not in name:
                continue
            with tempfile.TemporaryDirectory() as folder, served(Path(folder) / "home") as address:
                page = browser.new_page(viewport={"width": 1280, "height": 720})
                page.set_default_timeout(PATIENCE_MS)
                page.goto(address)
                page.wait_for_selector(".bench-head h1")
                user, began = User(page), time.perf_counter()
                found = task(user, Path(folder))
                seconds = time.perf_counter() - began
                print(f"{name:32s} {user.clicks:6d} {user.fields:6d} {seconds:7.0f}  {found}")
                print(f"{'':32s} {outside}" if outside else "", end="\n" if outside else "")
                sys.stdout.flush()
                page.close()
        browser.close()


if __name__ == "__main__":
    main()
