"""Compare in a browser: what was clicked is what is shown, all panels show the same time, and an
address leads there again."""

import shutil

import pytest

from tests.workbench.conftest import settle, workbench

FITTED = "table.heat td:is(.h0, .h1, .h2, .h3, .h4)"
CHART = "getElement(Number(document.querySelector('.bench-chart')?.id.slice(1)))?.chart"
WINDOWS = f"""() => {CHART} && {CHART}.getModel().queryComponents({{mainType: "xAxis"}}).map(
  (axis) => axis.axis.scale.getExtent())"""
"""From when to when each panel shows, s."""
BOTH = f"""() => {{
  const shown = ({WINDOWS})();
  return shown && shown.length === 2 && shown[0][1] - shown[0][0] < 2.4 && shown;
}}"""
"""The windows of two panels, once they show less than the 2.5 s of the beginning."""
MARKED = f"{CHART}?.getOption().series.some((one) => one.markLine?.data.length === 2)"
"""Whether the cursors stand in the chart."""
PLACES = [(0, 6), (2, 3)]


def chosen(page, label):
    """What a field of Compare says."""
    return page.locator(f"label:has([aria-label='{label}']) .q-field__native").inner_text().strip()


def wait_for_hash(page, text):
    page.wait_for_function("(text) => location.hash.startsWith(text)", arg=text)


@pytest.mark.parametrize("place", PLACES)
def test_a_cell_of_the_heat_map_shows_its_run_and_channel(small_open, open_page, place):
    page = open_page(small_open)
    page.wait_for_selector(FITTED)
    i, k = place
    cell = page.locator(f"table.heat button[data-act=look][data-run='{i}'][data-channel='{k}']")
    run, channel = cell.get_attribute("aria-label").split(", ")
    cell.click()
    page.locator("[data-view=compare]:not(.asleep)").wait_for()
    wait_for_hash(page, f"#compare/{run}/{channel}/time")
    settle(page)
    assert (chosen(page, "runs"), chosen(page, "channels")) == (run, channel)
    page.go_back()
    page.locator("[data-view=overview]:not(.asleep)").wait_for()
    page.go_forward()
    page.locator("[data-view=compare]:not(.asleep)").wait_for()
    page.reload()
    page.locator("[data-view=compare]:not(.asleep)").wait_for()
    settle(page)
    assert (chosen(page, "runs"), chosen(page, "channels")) == (run, channel)


def test_all_panels_show_the_same_time_and_cursors_are_dragged(small, tmp_path, open_page):
    """Of a page that was made ready before the model was fitted."""
    folder = shutil.copytree(small, tmp_path / "campaign")
    with workbench(folder) as (address, _):
        page = open_page(address)
        page.wait_for_selector("[data-view=compare] .bench-chart canvas", state="attached")
        page.wait_for_function(f"{CHART}?.getOption().series.length === 1")  # nothing is fitted yet
        page.wait_for_selector(FITTED)
        page.get_by_role("tab", name="Compare").click()
        page.wait_for_function(f"({WINDOWS})()?.length === 2")
        box = page.locator(".bench-chart").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 3
        page.mouse.move(x, y)
        page.mouse.wheel(0, -300)
        upper, lower = page.wait_for_function(BOTH).json_value()
        assert lower == pytest.approx(upper)

        page.mouse.move(x + 20, y)
        tip = page.locator(".bench-chart", has_text="m/s²").inner_text()
        assert " s\n" in tip and "measured" in tip and "residual" in tip

        page.get_by_role("button", name="Set cursors").click()
        page.wait_for_function(MARKED)
        settle(page)
        before = page.locator("[data-view=compare] table td").all_inner_texts()
        page.mouse.move(x - 100, y)
        page.mouse.down()
        page.mouse.move(x, y, steps=4)
        page.mouse.move(x + 100, y, steps=4)
        page.mouse.up()
        page.wait_for_function(
            "(old) => document.querySelector('[data-view=compare] td:nth-child(3)').innerText"
            " !== old",
            arg=before[2],
        )
        assert page.evaluate(MARKED)


def test_an_address_of_several_runs_and_channels_is_drawn(small_open, open_page, pictures):
    page = open_page(small_open)
    page.wait_for_selector(FITTED)
    runs = page.locator("table.runs td.name").all_inner_texts()
    page.evaluate("(to) => { location.hash = to }", f"#compare/{runs[0]},{runs[2]}/B1,A1/time/1-2")
    page.wait_for_function(f"({WINDOWS})()?.length === 4")
    for window in page.evaluate(WINDOWS):
        assert window == pytest.approx([1.0, 2.0])
    for kind, panels in (
        ("Distance", 2),
        ("Spectrogram", 4),
        ("Spectrum", 2),
        ("Transfer function", 1),
        ("XY", 2),
        ("Histogram", 2),
    ):
        page.get_by_role("button", name=kind, exact=True).click()
        page.wait_for_function(f"({WINDOWS})()?.length === {panels}")
        settle(page)
        page.screenshot(path=pictures / f"compare-{kind}.png", full_page=True)
