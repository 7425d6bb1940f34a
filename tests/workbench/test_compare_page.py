"""Compare in a browser: what was clicked is what is shown, and both panels show the same time."""

import shutil

import pytest

from tests.workbench.conftest import workbench

FITTED = "table.heat td:is(.h0, .h1, .h2, .h3, .h4)"
ALL = "all runs, one after the other"
CHART = "getElement(Number(document.querySelector('.bench-chart').id.slice(1))).chart"
WINDOWS = f"""() => {CHART} && {CHART}.getModel().queryComponents({{mainType: "xAxis"}}).map(
  (axis) => axis.axis.scale.getExtent())"""
"""From when to when either panel shows, s."""
SHARE = f"() => {{const {{start, end}} = {CHART}.getOption().dataZoom[0]; return end - start;}}"
"""How much of the record is looked at, per cent."""
BOTH = f"""() => {{
  const shown = ({WINDOWS})();
  return shown && shown.length === 2 && shown[0][1] - shown[0][0] < 9.9 && shown;
}}"""
"""The windows of two panels, once they show less than a record of 10 s."""


def chosen(page, label):
    """What a field of Compare says."""
    return page.get_by_label(label, exact=True).input_value()


@pytest.mark.parametrize("place", [(0, 6), (2, 3), (1, 0)])
def test_a_cell_of_the_heat_map_shows_its_run_and_channel(small_open, open_page, place):
    page = open_page(small_open)
    page.wait_for_selector(FITTED)
    page.wait_for_selector("[data-view=compare] .bench-chart canvas", state="attached")
    i, k = place
    cell = page.locator(f"table.heat button[data-act=look][data-run='{i}'][data-channel='{k}']")
    run, channel = cell.get_attribute("aria-label").split(", ")
    cell.click()
    page.locator("[data-view=compare]:not(.asleep)").wait_for()
    page.wait_for_function(
        "([run, channel]) => document.querySelector('[aria-label=run]').value === run",
        arg=[run, channel],
    )
    assert (chosen(page, "run"), chosen(page, "channel")) == (run, channel)


def test_both_panels_show_the_same_time(small, tmp_path, open_page):
    """Of a page that was made ready before the model was fitted."""
    folder = shutil.copytree(small, tmp_path / "campaign")
    with workbench(folder) as (address, _):
        page = open_page(address)
        page.wait_for_selector("[data-view=compare] .bench-chart canvas", state="attached")
        page.wait_for_function(f"{CHART}?.getOption().series.length === 1")  # nothing is fitted yet
        page.wait_for_selector(FITTED)
        page.get_by_role("tab", name="Compare").click()
        page.wait_for_function(f"({WINDOWS})().length === 2")
        box = page.locator(".bench-chart").first.bounding_box()
        page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 3)
        page.mouse.wheel(0, -300)
        upper, lower = page.wait_for_function(BOTH).json_value()
        assert lower == pytest.approx(upper)


def test_another_run_is_shown_whole(small_open, open_page):
    page = open_page(small_open)
    page.wait_for_selector(FITTED)
    page.get_by_role("tab", name="Compare").click()
    page.wait_for_selector("[data-view=compare] .bench-chart canvas")
    page.wait_for_function(f"{CHART}?.getOption().series.length > 1")
    page.locator(".bench-chart").first.focus()
    for _ in range(3):
        page.keyboard.press("+")
    page.wait_for_function(f"({SHARE})() < 30")
    before = chosen(page, "run")
    page.get_by_role("button", name="Next run").click()
    page.wait_for_function(
        "(run) => document.querySelector('[aria-label=run]').value !== run", arg=before
    )
    page.wait_for_function(f"({SHARE})() === 100", timeout=10_000)
