"""The glossary's line on a word, shown where it is pointed at."""

from __future__ import annotations

import re
from functools import cache
from html import escape
from pathlib import Path

from wheelhop.files import InputError, read_text

PLACES = (Path(__file__).parent / "glossary.md", Path(__file__).parents[3] / "docs/glossary.md")
"""In an installed wheel, and in the repository."""


@cache
def lines() -> dict[str, str]:
    """What the glossary says of every word, by the word in lower case, in plain text."""
    place = next((place for place in PLACES if place.is_file()), None)
    try:
        text = "" if place is None else read_text(place)
    except InputError:
        return {}
    found = {}
    for heads, said in re.findall(r"^\*\*(.+?)\.\*\* (.+?)(?=\n\n|\Z)", text, re.M | re.S):
        plain = re.sub(r"\s*\[[^\]]*\]\([^)]*\)\.?", "", " ".join(said.split()))
        for head in heads.split(", "):
            found[head.lower()] = re.sub(r"[`*]", "", plain).strip()
    return found


def term(words: str, entry: str = "") -> str:
    """Words as HTML with the line of their entry, themselves if none is named, on hover; keys reach
    it, too."""
    line = lines().get((entry or words).lower(), "")
    if not line:
        return escape(words)
    return f'<dfn tabindex="0" title="{escape(line)}">{escape(words)}</dfn>'
