"""Everybody can use the page: contrast, names for what is read aloud, keys for what is clicked."""

import pytest
from axe_playwright_python.sync_playwright import Axe

from tests.workbench.conftest import CHROMIUM, workbench
from wheelhop.workbench.compare_view import WHOLE, moved

RULES = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]}
TABS = ("Overview", "Record", "Compare", "What is missing", "Vehicle", "Take away")
NARROW = ((1280, 720), (820, 1180))


def violations(page):
    found = Axe().run(page, options=RULES).response["violations"]
    here = {rule["id"]: [node["html"] for node in rule["nodes"]] for rule in found}
    return {rule: html for rule, html in here.items() if "q-loading-bar" not in html[0]}


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")
def test_contrast_names_and_room(small, browser, tmp_path):
    """WCAG 2.1, A and AA, as far as a program can tell; light and dark, on a tablet too."""
    with workbench(small, home=tmp_path) as (address, _):
        for size, scheme in zip(NARROW, ("light", "dark"), strict=True):
            width, height = size
            context = browser.new_context(
                viewport={"width": width, "height": height}, color_scheme=scheme
            )
            page = context.new_page()
            page.goto(address)
            page.wait_for_selector("table.heat td:is(.h0, .h1, .h2, .h3, .h4)", timeout=180_000)
            for tab in TABS:
                page.get_by_role("tab", name=tab).click()
                page.wait_for_timeout(800)
                if violations(page):  # what is still fading in has no contrast yet
                    page.wait_for_timeout(2000)
                assert violations(page) == {}, (tab, scheme)
                assert page.evaluate("document.documentElement.scrollWidth") <= width, tab
            context.close()


def test_a_sensor_is_reached_by_keys(small, open_page):
    with workbench(small) as (address, _):
        page = open_page(address)
        page.locator("svg.plan [role=button]").first.focus()
        page.keyboard.press("Enter")
        page.wait_for_selector("[data-view=compare] .bench-chart canvas")
        page.locator(".bench-chart").first.focus()
        page.keyboard.press("+")
        page.keyboard.press("ArrowRight")


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
