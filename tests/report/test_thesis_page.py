"""The thesis's figures on one page: every one there, and what they show is what they say."""

import re
from pathlib import Path

import numpy as np
import pytest

from wheelhop.identify.thesis_tables import table_rows
from wheelhop.report import thesis_figures
from wheelhop.report.thesis import STUDIES, write_thesis
from wheelhop.report.thesis_figures import FIGURES, on_frame, printed_atv


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("thesis")
    rows = list(table_rows())
    return rows, write_thesis(folder / "new", rows)


def test_every_figure_is_a_picture_and_on_the_page(page):
    rows, files = page
    *pictures, html = files
    assert html.name == "thesis.html"
    for picture in pictures:
        assert picture.read_bytes().startswith(b"\x89PNG")
    text = html.read_text(encoding="utf-8")
    assert text.count("data:image/png;base64,") == len(pictures)
    for number in (*FIGURES, *STUDIES):
        assert f"igure {number}" in text
    assert f"of {len(rows)} printed numbers" in text


def test_every_row_stands_once(page):
    rows, (*_, html) = page
    cells = re.findall(r"<tr><td>(.*?)</td>", html.read_text(encoding="utf-8"))
    assert len(cells) == len(rows)


def test_reduction_keeps_what_is_below_wheel_hop():
    """Sixth order for chapter 2, eighth for chapter 5, as the thesis has it."""
    for whole, order in ((thesis_figures._g11(), 6), (thesis_figures._h_n_11(), 8)):
        reduced, _ = thesis_figures.balanced_reduction(whole, order)
        s = 2j * np.pi * np.geomspace(0.2, 15.0, 60)
        off = np.abs(reduced(s) - whole(s))[:, 0, 0].max() / np.abs(whole(s)).max()
        assert off < 0.06


def test_a_frame_twists_where_one_side_is_lifted_and_only_there(monkeypatch):
    def change():
        rigid, flexible = (thesis_figures._acceleration(flexible) for flexible in (False, True))
        return np.abs(flexible - rigid).max() / np.abs(rigid).max()

    assert 0.01 < change() < 0.5
    monkeypatch.setattr(thesis_figures, "TRACK", "washboard/high")
    assert change() < 1e-9


def test_a_frame_that_bends_shows_on_the_thesis_s_own_track():
    """Figure 6.1: both sides are lifted alike, and what differs is bending."""
    file = Path(__file__).parents[2] / "examples/frame/baja.toml"
    (draw, caption) = on_frame(file)["6.1"]
    rigid, flexible = (line.get_ydata() for line in draw().axes[0].lines)
    assert 0.02 < np.abs(flexible - rigid).max() / np.abs(rigid).max() < 0.1
    assert "27.0 Hz" in caption and "26.49" in caption


def test_the_vehicle_is_the_printed_one():
    values = printed_atv().values
    assert values["wheel.front.radius_m"] == pytest.approx(22 * 0.0254 / 2, abs=1e-3)
    assert values["suspension.rear.stiffness_N_m"] == 6500.0
