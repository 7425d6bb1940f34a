"""A workbench in a process of its own, and a browser that looks at it."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from tests.patience import PATIENCE_S
from tests.truth.campaign import write_campaign
from tests.truth.effects import make_effects
from tests.truth.presets import PRESETS, planned_runs

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
PATIENCE_MS = 1000 * PATIENCE_S
POLICY = "Content Security Policy"  # in what a browser says of what it does not run
VEHICLE = {"front wheels": 130, "rear wheels": 160, "wheelbase": 1.42, "track width": 1.18}


SETTLED = """async () => {
  for (let frame = 0; frame < 3; frame++) await new Promise(requestAnimationFrame);
  const finite = document.getAnimations().filter(
    one => one.effect.getComputedTiming().endTime !== Infinity);
  await Promise.allSettled(finite.map(one => one.finished));
}"""


def settle(page: object) -> None:
    """Wait until nothing on the page moves or fades any longer."""
    page.evaluate(SETTLED)


def describe_vehicle(page: object) -> None:
    """Fill in the four numbers that the guide needs."""
    for words, number in VEHICLE.items():
        page.get_by_label(words).first.fill(str(number))


@contextmanager
def workbench(
    *arguments: object, home: Path | None = None
) -> Iterator[tuple[str, subprocess.Popen]]:
    """`wheelhop workbench` as a user starts it: its address, and the process. It has a home of its
    own, where no other program's emulated logger or draft is in the way."""
    with ExitStack() as stack:
        home = home or Path(stack.enter_context(TemporaryDirectory(ignore_cleanup_errors=True)))
        yield from _served(arguments, home)


def _served(arguments: tuple[object, ...], home: Path) -> Iterator[tuple[str, subprocess.Popen]]:
    environment = {**os.environ, "HOME": str(home), "XDG_CACHE_HOME": str(home / ".cache")}
    command = [sys.executable, "-m", "wheelhop.cli.main", "workbench", "--no-browser"]
    process = subprocess.Popen(
        [*command, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    )
    try:
        line = process.stdout.readline()
        assert "http" in line, process.stderr.read()
        yield line.split()[-1], process
    finally:
        process.terminate()
        print(process.communicate(timeout=PATIENCE_S)[1])  # seen only where a test fails


@pytest.fixture(scope="session")
def browser() -> Iterator[object]:
    if CHROMIUM is None:
        pytest.skip("no Chromium: on Debian or Ubuntu, apt-get install chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield found
        found.close()


@pytest.fixture
def open_page(browser) -> Iterator[Callable[[str], object]]:
    """A new tab at an address; whatever its console complains of fails the test. What stands on the
    pages in the end is printed: it shows where a test fails."""
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    complaints: list[str] = []

    def opened(address: str) -> object:
        page = context.new_page()
        page.set_default_timeout(PATIENCE_MS)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("console", lambda line: complaints.append(line.text) if POLICY in line.text else 0)
        page.goto(address)
        page.wait_for_selector(".bench-head h1")
        return page

    yield opened
    for page in context.pages:
        print(page.url, page.locator("body").inner_text(), sep="\n")
    context.close()
    assert complaints == []


@pytest.fixture
def pictures(tmp_path_factory) -> Path:
    """Where screenshots go, to be looked at."""
    folder = Path(tmp_path_factory.getbasetemp()) / "workbench-pictures"
    folder.mkdir(exist_ok=True)
    return folder


def a_few_runs(folder, kept, hidden, seed, **more):
    """A campaign of some runs of the short one, quickly made."""
    planned = planned_runs(PRESETS["atv"], short=True, lateral_offset_mm=0.0)
    others = [run.id for run in planned if run.id not in kept]
    physics = make_effects(hidden)
    settings = {"seed": seed, "short": True, "draft": True, "without": others, **more}
    return write_campaign(folder, PRESETS["atv"], physics, **settings)


FITTED = ("washboard-low-slow", "washboard-high-fast", "herringbone-low-fast")
HELD_OUT = ("washboard-high-slow", "herringbone-high-fast")


@pytest.fixture(scope="session")
def friction(tmp_path_factory):
    hidden = {"dry-friction": {"coulomb_front_N": 75.0, "coulomb_rear_N": 55.0}}
    kept = (*FITTED, *HELD_OUT)
    return a_few_runs(tmp_path_factory.mktemp("friction"), kept, hidden, seed=101, seconds=3.2)


LONG = "a campaign whose name is as long as people make them, so that no line holds it"


@pytest.fixture(scope="session")
def small(tmp_path_factory):
    """Three runs, nothing hidden: for tests of the page, where a fit is only to be there soon."""
    kept = ("washboard-low-slow", "washboard-high-slow", "herringbone-low-fast")
    return a_few_runs(tmp_path_factory.mktemp("small"), kept, {}, seed=102)


@pytest.fixture(scope="session")
def small_open(small, tmp_path_factory):
    """The address of a workbench on a copy of it that is fitted but once."""
    folder = shutil.copytree(small, tmp_path_factory.mktemp("open") / LONG)
    with workbench(folder) as (address, _):
        yield address


@pytest.fixture(scope="session")
def clean(tmp_path_factory):
    kept = (*FITTED, *HELD_OUT)
    return a_few_runs(tmp_path_factory.mktemp("clean"), kept, {}, seed=102, seconds=3.2)
