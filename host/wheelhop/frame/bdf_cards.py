"""Nastran's bulk data as cards: free, small (8 columns) and large (16 columns) fields."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from wheelhop.frame.error import FrameError

SMALL, LARGE, PER_LINE = 8, 16, 8
BEGIN = ["BEGIN", "BULK"]
NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[eEdD]?([+-]?\d+))?", re.ASCII)
"""1.5, 1.5E-3, 1.5D-3, and Nastran's own 1.5-3."""


@dataclass(frozen=True)
class Card:
    """One card: its name, the fields behind it without blanks, and where it begins."""

    file: Path
    line: int
    name: str
    fields: tuple[str, ...]

    def error(self, what: str) -> FrameError:
        """The line to tell the user."""
        return FrameError(f"{self.file}: line {self.line}: {self.name}: {what}")

    def text(self, place: int) -> str:
        """Field `place`, empty if it is not there: 2 to 9 behind the name, 10 to 17 in the second
        line, and so on."""
        return self.fields[place - 2] if place - 2 < len(self.fields) else ""

    def number(self, place: int, default: float | None = None) -> float:
        """A number; `default` where the field is blank."""
        text = self.text(place)
        if not text and default is not None:
            return default
        found = NUMBER.fullmatch(text)
        value = float(f"{found[1]}e{found[2] or 0}") if found else float("nan")
        if not isfinite(value):
            raise self.error(f"{_where(place)} = '{text}' is not a number")
        return value

    def positive(self, place: int) -> float:
        """A number above 0."""
        value = self.number(place)
        if value <= 0.0:
            raise self.error(f"{_where(place)} = {value:g} must be greater than 0")
        return value

    def id(self, place: int) -> str:
        """The number of a grid point, property or material, as text."""
        text = self.text(place)
        if not text.isascii() or not text.isdigit() or int(text) == 0:
            raise self.error(f"{_where(place)} = '{text}' is not the number of anything")
        return str(int(text))


def _where(place: int) -> str:
    line, field = divmod(place - 2, PER_LINE)
    return f"field {field + 2}" + (f" of its line {line + 1}" if line else "")


def read_cards(file: Path, text: str) -> Iterator[Card]:
    """All cards of the bulk data: between BEGIN BULK, if that is there, and ENDDATA.

    Raises `FrameError` for a continuation of nothing, and for INCLUDE.
    """
    lines = list(enumerate(text.splitlines(), start=1))
    begins = [i for i, (_, line) in enumerate(lines) if line.upper().split()[:2] == BEGIN]
    open_card: tuple[int, str, list[str]] | None = None
    behind = 0
    for number, raw in lines[begins[0] + 1 if begins else 0 :]:
        line = raw.partition("$")[0].expandtabs().rstrip()
        if not line.strip():
            continue
        name, fields, wide = _split(line)
        if name == "ENDDATA":
            break
        if name == "INCLUDE" or line.upper().startswith("INCLUDE"):
            raise FrameError(f"{file}: line {number}: INCLUDE: put all cards into one file")
        if name:
            if open_card is not None:
                yield Card(file, open_card[0], open_card[1], tuple(open_card[2]))
            open_card, behind = (number, name, fields), PER_LINE // 2 if wide else PER_LINE
        elif open_card is None:
            raise FrameError(f"{file}: line {number}: continues a card, and there is none before")
        else:
            # What continues begins behind all fields of the line before, written or not.
            if not wide:
                behind += -behind % PER_LINE
            written = open_card[2]
            written += [""] * (behind - len(written))
            written += fields
            behind += PER_LINE // 2 if wide else PER_LINE
    if open_card is not None:
        yield Card(file, open_card[0], open_card[1], tuple(open_card[2]))


def _split(line: str) -> tuple[str, list[str], bool]:
    """Name, empty for a continuation, and fields of a line; whether they are large."""
    if "," in line:
        first, *fields = (part.strip() for part in line.split(","))
        wide = first.endswith("*") or first.startswith("*")
        count = PER_LINE // 2 if wide else PER_LINE
        return _name(first), fields[:count], wide
    first, rest = line[:SMALL].strip(), line[SMALL:]
    wide = first.endswith("*") or first.startswith("*")
    width, count = (LARGE, PER_LINE // 2) if wide else (SMALL, PER_LINE)
    fields = [rest[i : i + width].strip() for i in range(0, width * count, width)]
    return _name(first), fields[: -(-len(rest) // width)], wide


def _name(first: str) -> str:
    return "" if first.startswith(("+", "*")) else first.rstrip("*").upper()
