"""A page on the screen and as PDF."""

from importlib.resources import files
from io import BytesIO

import numpy as np
import pytest

from wheelhop.report.page import paragraph, write_page
from wheelhop.report.pdf import find_browser
from wheelhop.report.svg import equation


@pytest.fixture(scope="module")
def chromium():
    if (found := find_browser()) is None:
        pytest.skip("no browser")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_an_equation_is_read_on_light_and_dark_paper(chromium, scheme):
    """Black on black it was in the workbench, whose style darkened it."""
    from matplotlib.image import imread

    styles = [files("wheelhop.report") / "style.css", files("wheelhop.workbench") / "workbench.css"]
    css = "\n".join(file.read_text(encoding="utf-8") for file in styles)
    page = chromium.new_page(color_scheme=scheme)
    body = f'<div class="bench-main"><p class="equation">{equation(r"F = c v^2")}</p></div>'
    page.set_content(f"<style>{css}</style><body>{body}</body>")
    picture = imread(BytesIO(page.locator(".equation svg").screenshot()))
    grey = picture[..., :3].mean(axis=2)
    paper = np.median(grey)
    ink = grey.max() if scheme == "dark" else grey.min()
    assert (paper < 0.2) if scheme == "dark" else (paper > 0.9)
    assert abs(ink - paper) > 0.5
    page.close()


def test_a_report_called_pdf_is_one(tmp_path):
    if find_browser() is None:
        pytest.skip("no browser")
    write_page(tmp_path / "report.PDF", "a <b>", [paragraph("text")])
    assert (tmp_path / "report.PDF").read_bytes().startswith(b"%PDF")
    assert [file.name for file in tmp_path.iterdir()] == ["report.PDF"]
