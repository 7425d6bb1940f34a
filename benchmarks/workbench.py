"""How fast the workbench answers, measured in a browser: python -m benchmarks.workbench [CAMPAIGN]

Needs Chromium. The campaign is copied, so that nothing is written into it. In place of a campaign
`--large` makes one of 18 runs, 12 channels and 100 s at 1000 Hz, `--many` one of 250 short runs;
of these the page is measured before anything is fitted.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import pandas as pd
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).parents[1]
VIEWS = ("compare", "where", "missing", "between", "model", "vehicle", "out", "overview")
SCROLLED_S = 3.0
MANY_RUNS = 3  # with every channel of each, stacked

SHOWN = """async (view) => {
  const tabs = [...document.querySelectorAll('[role=tab]')];
  const panels = [...document.querySelectorAll('[data-view]')];
  const at = panels.findIndex(panel => panel.dataset.view === view);
  const shown = () => getComputedStyle(panels[at]).visibility === 'visible';
  if (shown()) {
    const other = tabs[at ? 0 : 1];
    other.click();
    while (shown()) await new Promise(requestAnimationFrame);
    await new Promise(requestAnimationFrame);
  }
  const began = performance.now();
  tabs[at].click();
  while (!shown()) await new Promise(requestAnimationFrame);
  await new Promise(requestAnimationFrame);
  return performance.now() - began;
}"""
"""From a click on a tab to its view on the screen, ms; the server is asked in between."""

FRAMES = """async ([seconds]) => {
  const canvas = document.querySelector('.bench-chart canvas');
  const box = canvas.getBoundingClientRect();
  const at = {clientX: box.x + box.width / 2, clientY: box.y + box.height / 3, bubbles: true};
  const times = [];
  const began = performance.now();
  for (let i = 0; performance.now() - began < 1000 * seconds; i++) {
    const deltaY = Math.floor(i / 20) % 2 ? 60 : -60;
    canvas.dispatchEvent(new WheelEvent('wheel', {...at, deltaY, wheelDelta: -deltaY}));
    await new Promise(requestAnimationFrame);
    times.push(performance.now());
  }
  return times;
}"""
"""The wheel is turned in every frame; when each frame was drawn, ms."""


@contextmanager
def served(folder: Path) -> Iterator[tuple[str, float]]:
    """A workbench on a campaign: its address, and when it was started."""
    command = [sys.executable, "-m", "wheelhop.cli.main", "workbench", "--no-browser", str(folder)]
    began = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT)
    try:
        assert process.stdout is not None
        yield process.stdout.readline().split()[-1], began
    finally:
        process.terminate()
        process.wait(10)


def main() -> None:
    """Print every figure with what is asked."""
    chosen = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "examples/open-driver-seat")
    made = MADE.get(chosen)
    chromium = shutil.which("chromium") or sys.exit("no Chromium: apt-get install chromium")
    with tempfile.TemporaryDirectory() as other, sync_playwright() as playwright:
        folder = Path(other) / "campaign"
        if made is not None:
            _make(folder, *made)
        else:
            shutil.copytree(chosen, folder)
            folder.chmod(0o755)
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.set_default_timeout(120_000)
        with served(folder) as (address, began):
            scripts = _scripts(page)
            _first(page, address, began)
            if made is None:
                _measure(page, began)
            else:
                _zoom(page)
            _say("JavaScript loaded", sum(scripts.values()) / 1e6, "MB", "3 MB")
        browser.close()


MADE = {"--large": (18, 100.0, 1000.0), "--many": (250, 10.0, 100.0)}
"""Runs, seconds and samples a second."""
TWELVE = tuple(f"{place}{i}" for place in "ABS" for i in (1, 2, 3, 4))


def _make(folder: Path, runs: int, seconds: float, rate_hz: float) -> None:
    """A campaign of noise: nothing in it is to be found."""
    rng = np.random.default_rng(1)
    (folder / "runs").mkdir(parents=True)
    n = round(seconds * rate_hz)
    time_s = np.arange(n) / rate_hz
    places = [f'{name} = "{name}"' for name in TWELVE[:8]]
    places += [f'{name} = {{ quantity = "travel", corner = {name[1]} }}' for name in TWELVE[8:]]
    text = (
        f'format = 1\ntitle = "{runs} runs"\nsample_rate_hz = {rate_hz}\nband_hz = [0.5, 30.0]\n\n'
        "[channels]\n" + "\n".join(places) + "\n"
    )
    for i in range(runs):
        values = rng.normal(0.0, 1.0, (n, 12)) * np.repeat([1.0, 0.01], [8, 4])
        table = pd.DataFrame(values, columns=list(TWELVE))
        table.insert(0, "time_s", time_s)
        table.to_parquet(folder / f"runs/{i}.parquet", index=False)
        role = "validate" if i % 3 == 2 else "fit"
        text += (
            f'\n[[run]]\nid = "run-{i}"\nfile = "runs/{i}.parquet"\nrole = "{role}"\n'
            'speed_kmph = 20.0\ntrack.kind = "unknown"\n'
        )
    (folder / "campaign.toml").write_text(text)
    shutil.copy(ROOT / "examples/clean/vehicle.toml", folder)


def _scripts(page: Any) -> dict[str, int]:
    """The size of every script that is loaded, by its address, as it goes on."""
    found: dict[str, int] = {}

    def seen(response: Any) -> None:
        if "javascript" in response.headers.get("content-type", ""):
            with suppress(Exception):  # a page that is left has no body any more
                found[response.url] = len(response.body())

    page.on("response", seen)
    return found


def _first(page: Any, address: str, began: float) -> None:
    """From the command, and from the address alone, as of a server that runs already."""
    page.goto(address)
    page.wait_for_selector(".bench-head h1")
    page.evaluate(SHOWN, "compare")
    _say("from the command to a page that answers", time.perf_counter() - began, "s", "2 s")
    again = time.perf_counter()
    page.reload()
    page.wait_for_selector("table.runs td.name")
    _say("first view, of a server that runs", time.perf_counter() - again, "s", "1 s")


def _zoom(page: Any) -> None:
    """Clicks and zoom before anything is fitted."""
    views = ("compare", "missing", "vehicle", "files", "out", "overview")
    for view in views:
        page.evaluate(SHOWN, view)
    _say_clicks("a click on a tab", {v: [page.evaluate(SHOWN, v) for _ in range(5)] for v in views})
    _stacked(page)


def _measure(page: Any, began: float) -> None:
    page.evaluate(SHOWN, "overview")
    page.wait_for_selector("table.heat td.h0, table.heat td.h4")
    _say("until the baseline is fitted", time.perf_counter() - began, "s", "")
    page.evaluate(SHOWN, "vehicle")
    page.wait_for_timeout(4000)
    times = {view: [page.evaluate(SHOWN, view) for _ in range(5)] for view in VIEWS}
    _say_clicks("a click on a tab", times)

    _stacked(page)
    page.evaluate(SHOWN, "missing")
    page.get_by_role("button", name="Find out what is missing").click()
    page.wait_for_selector("text=diagnosing:")
    page.wait_for_timeout(6000)
    times = {view: [page.evaluate(SHOWN, view) for _ in range(5)] for view in VIEWS}
    _say_clicks("a click while a diagnosis runs", times)
    before = time.perf_counter()
    page.get_by_role("button", name="Stop", exact=True).click()
    page.wait_for_selector("text=given up")
    _say("until a diagnosis is given up", time.perf_counter() - before, "s", "1 s")


def _stacked(page: Any) -> None:
    """Zoom in some runs with all their channels, stacked."""
    runs = page.locator("table.runs td.name").all_inner_texts()[:MANY_RUNS]
    channels = page.locator("table.runs th button[data-act='leave channel']").all_inner_texts()
    place = f"compare/{','.join(runs)}/{','.join(channels)}/time/all"
    page.evaluate("(place) => { location.hash = place }", place)
    page.wait_for_timeout(4000)
    frames = page.evaluate(FRAMES, [SCROLLED_S])
    steps = sorted(b - a for a, b in pairwise(frames))
    _say("zoom, stacked runs: frames a second", 1000 / (sum(steps) / len(steps)), "", "30")
    _say("  of the slowest twentieth", 1000 / steps[-max(len(steps) // 20, 1)], "", "")


def _say_clicks(what: str, times: dict[str, list[float]]) -> None:
    everything = [time for found in times.values() for time in found]
    worst = max(times, key=lambda view: max(times[view]))
    _say(f"{what}, median", median(everything), "ms", "100 ms")
    _say(f"{what}, slowest of {len(everything)}", max(everything), "ms", f"100 ms; {worst}")


def _say(what: str, value: float, unit: str, asked: str) -> None:
    print(f"{what:48s} {value:8.3g} {unit:2s}  {f'asked {asked}' if asked else ''}", flush=True)


if __name__ == "__main__":
    main()
