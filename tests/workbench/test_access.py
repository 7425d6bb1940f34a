"""Everybody can use the page: contrast, names for what is read aloud, keys for what is clicked."""

import pytest
from axe_playwright_python.sync_playwright import Axe

from tests.workbench.conftest import CHROMIUM, PATIENCE_MS, settle
from wheelhop.workbench.charts import WHOLE
from wheelhop.workbench.compared import moved

RULES = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]}
TABS = ("Overview", "Record", "Compare", "What is missing", "Vehicle", "Take away")
NARROW = ((1280, 720), (820, 1180))


def violations(page):
    found = Axe().run(page, options=RULES).response["violations"]
    here = {rule["id"]: [node["html"] for node in rule["nodes"]] for rule in found}
    return {rule: html for rule, html in here.items() if "q-loading-bar" not in html[0]}


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")
def test_contrast_names_and_room(small_open, browser):
    """WCAG 2.1, A and AA, as far as a program can tell; light and dark, on a tablet too."""
    for size, scheme in zip(NARROW, ("light", "dark"), strict=True):
        width, height = size
        context = browser.new_context(
            viewport={"width": width, "height": height}, color_scheme=scheme
        )
        page = context.new_page()
        page.set_default_timeout(PATIENCE_MS)
        page.goto(small_open)
        page.wait_for_selector("table.heat td:is(.h0, .h1, .h2, .h3, .h4)")
        for tab in TABS:
            page.get_by_role("tab", name=tab).click()
            settle(page)  # what is still fading in has no contrast yet
            assert violations(page) == {}, (tab, scheme)
            assert page.evaluate("document.documentElement.scrollWidth") <= width, tab
        context.close()


def test_a_sensor_is_reached_by_keys(small_open, open_page):
    page = open_page(small_open)
    page.locator("svg.plan [role=button]").first.focus()
    page.keyboard.press("Enter")
    page.wait_for_selector("[data-view=compare] .bench-chart canvas")
    page.locator(".bench-chart").first.focus()
    page.keyboard.press("+")
    page.keyboard.press("ArrowRight")


DRAWN = """() => {
  const id = Number(document.querySelector(".bench-chart").id.slice(1));
  const option = getElement(id).chart.getOption();
  const {start, end, startValue, endValue} = option.dataZoom[0];
  const inside = ([x]) => startValue <= x && x <= endValue;
  return {share: (end - start) / 100, count: option.series[0].data.filter(inside).length};
}"""
"""How much of the record is looked at, and how many points of the first curve are drawn there."""


def test_detail_comes_with_zooming_in(small_open, open_page):
    """All runs in a row have more samples than are drawn; a small part of them is drawn whole."""
    page = open_page(small_open)
    page.wait_for_selector("table.heat td:is(.h0, .h1, .h2, .h3, .h4)")
    page.get_by_role("tab", name="Compare").click()
    page.get_by_label("run", exact=True).click()
    page.get_by_text("all runs, one after the other").click()
    samples = 3 * 1024
    page.wait_for_function(f"({DRAWN})().count > 1000")
    assert page.evaluate(DRAWN)["count"] < samples / 2
    page.locator(".bench-chart").first.focus()
    for _ in range(5):
        page.keyboard.press("+")
    page.wait_for_function(
        f"(({{share, count}}) => share < 0.1 && count > 0.9 * {samples} * share)(({DRAWN})())"
    )


def test_keys_zoom_and_move_within_the_record():
    near = moved(WHOLE, "+")
    assert WHOLE[0] < near[0] < near[1] < WHOLE[1]
    right = moved(near, "ArrowRight")
    assert right[0] > near[0]
    assert right[1] - right[0] == pytest.approx(near[1] - near[0])
    assert moved(right, "ArrowLeft") == pytest.approx(near)
    for _ in range(20):
        right = moved(right, "ArrowRight")
        near = moved(near, "+")
    assert right[1] == pytest.approx(100.0)
    assert near[1] > near[0]
    assert moved(near, "0") == WHOLE
    for _ in range(40):
        near = moved(near, "-")
    assert near == pytest.approx(WHOLE)
