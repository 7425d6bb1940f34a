"""Everybody can use the page: contrast, names for what is read aloud, keys for what is clicked."""

import pytest
from axe_playwright_python.sync_playwright import Axe

from tests.workbench.conftest import CHROMIUM, PATIENCE_MS, settle

RULES = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]}
TABS = ("Overview", "Record", "Compare", "What is missing", "Vehicle", "Files", "Take away")
NARROW = ((1280, 720), (390, 844))


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
