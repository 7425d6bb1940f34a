"""The tour leads through the example, and a word says what it means."""

import re

from tests.workbench.conftest import workbench
from wheelhop.workbench.glossary import lines, term
from wheelhop.workbench.page import VIEWS
from wheelhop.workbench.tour import STOPS


def test_every_word_has_its_line():
    assert lines()["floor"].startswith("The error that the sensors' noise alone would leave")
    assert "](" not in " ".join(lines().values())
    assert term("noise floor", "floor").startswith('<dfn tabindex="0" title="The error')
    assert term("<b>") == "&lt;b&gt;"


def test_the_tour_stops_at_views_that_are_there():
    assert {stop.view for stop in STOPS} <= {key for key, *_ in VIEWS}


def test_the_tour_and_the_theme(tmp_path, open_page, pictures):
    home = tmp_path / "home"
    with workbench(home=home) as (address, _):
        page = open_page(address)
        page.get_by_role("button", name=re.compile("Take the tour")).click()
        page.locator(".bench-tour", has_text=STOPS[0].title).wait_for()
        for stop in STOPS[1:]:
            page.get_by_role("button", name="Next", exact=True).click()
            page.locator(".bench-tour", has_text=stop.title).wait_for()
            page.locator(f"[data-view={stop.view}]:not(.asleep)").wait_for()
        page.screenshot(path=pictures / "tour.png")
        page.get_by_role("button", name="Theme").click()
        page.get_by_text("Dark", exact=True).click()
        dark = "getComputedStyle(document.documentElement).backgroundColor === 'rgb(21, 24, 28)'"
        page.wait_for_function(dark)
        page.reload()
        page.wait_for_function(dark)
        page.get_by_role("button", name="End the tour").click()
        page.locator(".bench-tour").wait_for(state="detached")
        assert (home / "wheelhop/tour/open-dry-friction/campaign.toml").is_file()
