"""One self-contained HTML page: its frame, its style, and the few elements it is made of."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path

from wheelhop.files import write_text
from wheelhop.report.pdf import write_pdf

QUESTIONS = ("What is missing", "How sure that is", "What it changes", "What to do next")
"""What a summary answers, in this order."""


def write_page(path: Path, name: str, body: Iterable[str]) -> None:
    """Write a page with the report's style; where the file's name ends in .pdf, printed into it.
    Raises InputError."""
    if path.suffix.lower() == ".pdf":
        with tempfile.TemporaryDirectory() as other:
            page = Path(other) / "report.html"
            write_page(page, name, body)
            write_pdf(page, path)
        return
    style = (files(__package__) / "style.css").read_text(encoding="utf-8")
    parts = [
        "<!doctype html>",
        '<html lang="en">',
        "<head>",
        '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(name)}</title>",
        f"<style>\n{style}</style>",
        "</head>",
        "<body><main>",
        *body,
        "</main></body>",
        "</html>",
    ]
    write_text(path, "\n".join(parts) + "\n")


def title(text: str) -> str:
    """The page's main heading; names with a hyphen stay on one line."""
    words = re.sub(r"\w+(-\w+)+", r'<span class="whole">\g<0></span>', escape(text))
    return f"<h1>{words}</h1>"


def section(heading: str, *parts: str) -> str:
    """A section under its heading; without parts, nothing."""
    inner = "\n".join(part for part in parts if part)
    return f"<section>\n<h2>{escape(heading)}</h2>\n{inner}\n</section>" if inner else ""


def paragraph(text: str, kind: str = "") -> str:
    """Plain text as a paragraph of a CSS class."""
    return f"<p{_class(kind)}>{escape(text)}</p>" if text else ""


def bullets(sentences: Iterable[str]) -> str:
    """A list of sentences; those behind one that ends in a colon stand below it."""
    items, below = "", ""
    for sentence in sentences:
        items += f"<li>{escape(sentence)}"
        if sentence.endswith(":"):
            items, below = f"{items}<ul>", f"</ul></li>{below}"
        else:
            items += "</li>"
    return f"<ul>{items}{below}</ul>" if items else ""


def figure(drawing: str, caption: str) -> str:
    """A drawing (SVG or a table, already HTML) with a caption."""
    return (
        f'<figure><div class="scroll">{drawing}</div>'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def table(headings: Sequence[str], rows: Iterable[Sequence[str]], sides: str) -> str:
    """A table of cells that are HTML already; `sides` holds one letter a column: "l" left, "r"
    right, where numbers stand."""
    head = "".join(f"<th{_side(s)}>{h}</th>" for h, s in zip(headings, sides, strict=True))
    body = []
    for row in rows:
        cells = "".join(f"<td{_side(s)}>{c}</td>" for c, s in zip(row, sides, strict=True))
        body.append(f"<tr>{cells}</tr>")
    return (
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead>\n'
        f"<tbody>{chr(10).join(body)}</tbody></table></div>"
    )


def facts(pairs: Iterable[tuple[str, str]], kind: str = "facts") -> str:
    """Terms and what they are (plain text), as a description list."""
    items = "".join(f"<div><dt>{escape(k)}</dt><dd>{escape(v)}</dd></div>" for k, v in pairs)
    return f"<dl{_class(kind)}>{items}</dl>"


def _class(kind: str) -> str:
    return f' class="{kind}"' if kind else ""


def _side(side: str) -> str:
    return ' class="r"' if side == "r" else ""
