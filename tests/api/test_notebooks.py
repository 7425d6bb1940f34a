"""The notebooks, and the pages that show what they do."""

import os
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "examples/notebooks").glob("*.ipynb"))


@pytest.fixture(scope="module")
def make():
    sys.path.insert(0, str(ROOT / "docs"))
    import make_notebooks

    return make_notebooks


def test_each_notebook_has_its_page_and_each_page_its_notebook():
    pages = sorted((ROOT / "docs/notebooks").glob("*.md"))
    assert [page.stem for page in pages] == [file.stem for file in NOTEBOOKS] and NOTEBOOKS
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert all(f"notebooks/{file.stem}.md" in nav for file in NOTEBOOKS)


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_page_shows_the_cells_of_its_notebook_in_their_order(file, make):
    page, at = (ROOT / f"docs/notebooks/{file.stem}.md").read_text(encoding="utf-8"), 0
    for _, source in make.cells(file):
        at = page.index(source, at) + len(source)


@pytest.mark.slow
@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_runs_and_draws_as_many_figures_as_its_page_shows(
    file, make, tmp_path, monkeypatch
):
    monkeypatch.setitem(os.environ, "MPLBACKEND", "agg")
    page = make.rendered(file, tmp_path)
    shown = (ROOT / f"docs/notebooks/{file.stem}.md").read_text(encoding="utf-8")
    assert page.count("![") == shown.count("![") == len(list(tmp_path.glob("*.png")))
