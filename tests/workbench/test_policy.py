"""Nothing that came with a campaign runs on the page, and nothing unasked for is served."""

import shutil
from pathlib import Path
from urllib.parse import urlsplit

import pytest

import wheelhop.workbench
from tests.workbench.conftest import workbench
from tests.workbench.test_guard import ask
from tests.workbench.test_names import spoil

TABS = (
    *("Record", "Overview", "Compare", "Where it fails", "Struts", "What is missing"),
    *("Axle to body", "The model", "Vehicle", "Files", "Take away"),
)
FORCED = """([html, click]) => new Promise((resolve) => {
  const told = (event) => resolve(event.violatedDirective);
  document.addEventListener("securitypolicyviolation", told, { once: true });
  document.body.append(document.createRange().createContextualFragment(html));
  if (click) document.querySelector(click).click();
})"""
"""Puts markup into the page, as if it had been escaped nowhere; gives the rule that stopped it."""
PAYLOADS = (
    '<img src="data:," onerror="window.ran = 1">',
    "<script>window.ran = 1</script>",
    '<svg onload="window.ran = 1"></svg>',
    '<a id="bait" href="javascript:window.ran = 1">x</a>',
    '<script src="https://evil.example/x.js"></script>',
)


@pytest.fixture(scope="module")
def cookie_of():
    def cookie(address):
        _, headers, _ = ask(address, f"/?{address.query}")
        return headers["set-cookie"].split(";")[0]

    return cookie


def test_names_of_a_stranger_run_nothing(small, tmp_path, open_page, pictures):
    """Titles, channels, runs and files with markup in them; and the console has no complaint."""
    folder = shutil.copytree(small, tmp_path / "nasty")
    spoil(folder)
    with workbench(folder) as (address, _):
        page = open_page(address)
        page.locator(".bench-head dt").first.wait_for()  # the baseline is fitted
        title = page.title()
        for tab in TABS:
            page.get_by_role("tab", name=tab, exact=True).click()
            page.locator("[data-view]:not(.asleep)").wait_for()
            page.screenshot(path=pictures / f"policy-{tab}.png")
        assert page.title() == title and title.startswith("wheelhop: <img")
        assert page.locator("img[src=x]").count() == 0
        assert page.evaluate("document.documentElement.lang") == "en-US"


@pytest.mark.parametrize("payload", PAYLOADS)
def test_markup_that_nobody_escaped_runs_nothing(small_open, browser, payload):
    page = browser.new_page()
    page.goto(small_open)
    page.locator(".bench-head h1").wait_for()
    page.evaluate("window.ran = 0")
    click = "#bait" if "bait" in payload else ""
    rule = page.evaluate(FORCED, [payload, click])
    assert rule.startswith("script-src")
    assert page.evaluate("window.ran") == 0
    page.close()


def test_what_the_policy_allows(small_open, cookie_of):
    here = urlsplit(small_open)
    cookie = cookie_of(here)
    answers = [ask(here, Cookie=cookie) for _ in range(2)]
    policies = [headers["content-security-policy"] for _, headers, _ in answers]
    assert policies[0] != policies[1]  # a nonce is used once
    for (_, headers, body), policy in zip(answers, policies, strict=True):
        rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
        assert "'unsafe-inline'" not in rules["script-src"]
        assert rules["object-src"] == rules["base-uri"] == rules["frame-ancestors"] == "'none'"
        nonce = rules["script-src"].split("'nonce-")[1].split("'")[0]
        assert len(nonce) > 20 and f'nonce="{nonce}"' in body
        assert headers["x-content-type-options"] == "nosniff"


@pytest.mark.parametrize("path", ["/docs", "/redoc", "/openapi.json", "/own/", "/own/server.py"])
def test_nothing_else_is_served(small_open, cookie_of, path):
    here = urlsplit(small_open)
    assert ask(here, path, Cookie=cookie_of(here))[0] == 404


def test_markup_is_shown_as_it_is_in_one_place_alone():
    """Everything else is text, or goes through the browser's purifier."""
    places = [
        f"{path.name}: {line.strip()}"
        for path in Path(wheelhop.workbench.__file__).parent.glob("*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if "sanitize=False" in line or "ui.html(" in line or "ui.markdown(" in line
    ]
    assert sorted(places) == [
        "view.py: return ui.html(content, sanitize=False)",
        "view.py: return ui.html(content, sanitize=True)",
    ]
