"""The effects' pictures, as docs/effects.md shows them; the wheel brings them along."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from nicegui import app

ADDRESS = "/gallery"
PLACES = (Path(__file__).parent / "gallery", Path(__file__).parents[3] / "docs/effects")
"""In an installed wheel, and in the repository."""


@cache
def folder() -> Path | None:
    """Where the pictures are, served from then on; None where there are none."""
    found = next((place for place in PLACES if place.is_dir()), None)
    if found is not None:
        app.add_static_files(ADDRESS, found)
    return found


def picture_of(effect: str) -> str:
    """The address of an effect's picture; "" if it has none, as an effect of the user's own."""
    pictures = folder()
    if pictures is None or effect not in {path.stem for path in pictures.glob("*.png")}:
        return ""
    return f"{ADDRESS}/{effect}.png"
