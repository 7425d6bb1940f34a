"""The pages as a site: whole, without warnings, and without a network."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import wheelhop

pytest.importorskip("mkdocs")
ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)],
        cwd=ROOT,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in folder.rglob("*.html")
    }


def test_every_page_is_there(site):
    assert {f"{p.stem}.html" for p in (ROOT / "docs").glob("*.md")} | {"index.html"} <= site.keys()
    assert {f"firmware/{p.stem}.html" for p in (ROOT / "firmware").glob("[A-Z]*.md")} - {
        "firmware/README.html"
    } <= site.keys()


def test_nothing_is_fetched(site):
    loaded = (
        r"<(?:script|img|iframe)\b[^>]*\bsrc=\"?(https?:|//)|<link\b[^>]*stylesheet[^>]*https?:"
    )
    for name, page in site.items():
        assert not re.search(loaded, page), name


def test_formulas_are_set(site):
    for name, page in site.items():
        assert "```" not in page and "language-math" not in page, name
    assert site["theory.html"].count("<math") == (ROOT / "docs" / "theory.md").read_text(
        encoding="utf-8"
    ).count("```math")


def test_the_reference_holds_every_public_name(site):
    names = set(wheelhop.__all__) - {"__version__"}
    shown = set(re.findall(r'<h3 id="wheelhop\.[\w.]*?(\w+)" class="doc', site["reference.html"]))
    assert shown == names
