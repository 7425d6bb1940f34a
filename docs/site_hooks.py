"""The pages outside docs/ in the site: hooks of mkdocs.yml.

README.md is the first page. Links between pages are those of the repository; what leads to a file
that is no page (source, an example) becomes the file's name.
"""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath
from posixpath import normpath, relpath

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[1]
OUTSIDE = ("README.md", "firmware", "hil_sim", "benchmarks", "tests/truth")
"""Pages and folders of pages and their pictures that are not in docs/."""

SHOWN = {".md", ".svg", ".png"}
FORMULA = re.compile(r"^```math\n(.*?)^```$", re.S | re.M)
LINK = re.compile(
    r"(?P<code>```.*?```|`[^`\n]*`)"
    r"|\[(?P<text>[^\]]*)\]\((?P<target>[^)\s:#]+)(?P<anchor>#[^)\s]*)?\)",
    re.S,
)


def uri_of(path: str) -> str:
    """A file's place in the site from its place in the repository."""
    return "index.md" if path == "README.md" else path.removeprefix("docs/")


def path_of(uri: str) -> str:
    """The opposite."""
    if uri == "index.md":
        return "README.md"
    return f"docs/{uri}" if (ROOT / "docs" / uri).exists() else uri


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages and pictures outside docs/."""
    for name in OUTSIDE:
        start = ROOT / name
        for path in [start] if start.is_file() else sorted(start.rglob("*")):
            if path.suffix in SHOWN and not any(p.startswith(".") for p in path.parts[1:]):
                uri = uri_of(path.relative_to(ROOT).as_posix())
                files.append(File.generated(config, uri, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Lead every link to where its page or picture is in the site, and set the formulas: browsers
    know MathML, so that none is fetched or run."""
    folder = PurePosixPath(path_of(page.file.src_uri)).parent

    def led(match: re.Match[str]) -> str:
        if match["code"]:
            return match["code"]
        path = normpath(str(folder / match["target"]))
        uri = uri_of(f"{path}/README.md" if (ROOT / path / "README.md").is_file() else path)
        if files.get_file_from_path(uri) is None:
            return (
                match["text"] if match["text"].strip("`") in path else f"{match['text']} (`{path}`)"
            )
        here = PurePosixPath(page.file.src_uri).parent
        return f"[{match['text']}]({relpath(uri, str(here))}{match['anchor'] or ''})"

    return FORMULA.sub(_set, LINK.sub(led, markdown))


def _set(formula: re.Match[str]) -> str:
    return f'<div class="formula">{convert(formula[1].strip(), display="block")}</div>'
