"""What was understood of a file: its columns, what it does not say, and the mapping of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from wheelhop.files import did_you_mean, quoted
from wheelhop.files.units import SPELT, is_measured, to_si
from wheelhop.formats.columns import Question
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.labels import is_unit
from wheelhop.formats.mapping import Map, parse_mapping
from wheelhop.formats.places import good_for, likely_points, likely_quantity
from wheelhop.formats.table import POINTS
from wheelhop.logger.recording import ACCELERATION

CHANNEL, TIME, LEFT_OUT = "a channel", "time", "left out"


@dataclass(frozen=True)
class Found:
    """One column: how a mapping names it (`key`, as TOML), what it is called, its unit as the file
    says, what it is taken for and why; and the place that its name means, "" for none."""

    key: str
    label: str
    name: str
    unit: str
    taken_for: str
    why: str
    point: str = ""

    @property
    def placed(self) -> bool:
        """Whether the place can be given: a channel in an unknown unit has none."""
        return bool(self.point) and is_measured(self.unit)


@dataclass(frozen=True)
class Understood:
    """What was understood of a file: the keys of its mapping with their comments, its columns, what
    it does not say (`questions`), and what was taken for granted (`guesses`)."""

    path: Path
    keys: tuple[tuple[str, str, str], ...]
    columns: tuple[Found, ...]
    questions: tuple[Question, ...] = ()
    guesses: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    def text(self) -> str:
        """The mapping; keys that are asked for are blank."""
        head = [
            f"# How to read {self.path.name}, guessed from its look: correct it, then",
            f"#     wheelhop import --map THIS.toml {self.path.name}",
            "# Delete the channels that are not wanted. point is A1 … A4 (axles), B1 … B4 or body.",
            "# A channel is column × scale + offset, in unit: add scale = … and offset = … as"
            " needed.",
            "format = 1",
        ]
        lines = [f"{k} = {v}{f'  # {note}' if note else ''}" for k, v, note in self.keys]
        channels = [column for column in self.columns if column.taken_for == CHANNEL]
        left_out = (c for c in self.columns if c.taken_for == LEFT_OUT)
        notes = [f"# left out: {short(column.label)}, {column.why}" for column in left_out]
        notes += [f"# taken for granted: {short(guess)}" for guess in self.guesses]
        entries = (line for column in channels for line in _entry(column))
        return "\n".join([*head, *lines, *notes, *entries]) + "\n"

    def words(self) -> str:
        """How the file is laid out and sampled, in a line."""
        said = {key: value for key, value, _ in self.keys if value not in ("0", '""')}
        kept = (
            *("separator", "decimal", "thousands", "header_row", "units_row", "first_row"),
            *("last_row", "time", "time_unit", "rate_hz", "resample_hz"),
        )
        return ", ".join(f"{key} {said[key]}" for key in kept if key in said)

    def granted(self, places: bool = True) -> tuple[str, ...]:
        """What was taken for granted, as a recording's history says it."""
        placed = [c for c in self.columns if places and c.placed and c.point != c.name]
        return (
            *(f"taken for granted: {guess}" for guess in self.guesses),
            *(f"{column.name}: taken for {column.point}, by its name" for column in placed),
        )

    def mapping(self, places: bool = True) -> Map:
        """The mapping, as it is read; without `places`, those that only names mean are left open.
        Raises `ExchangeError` if something has to be asked."""
        if self.questions:
            raise ExchangeError(f"{self.path}: {'; '.join(q.words for q in self.questions)}")
        found = parse_mapping(self.text(), self.path)
        if places:
            return found
        sure = tuple(
            pick if pick.point == pick.name else replace(pick, point="") for pick in found.picks
        )
        return replace(found, picks=sure)


def short(text: str) -> str:
    """A text without what cannot be printed."""
    return "".join(char if char.isprintable() else " " for char in text)


def why_of(name: str, unit: str) -> str:
    """What becomes of values in this unit, and what a channel so called is good for in a campaign
    if it is no acceleration."""
    word = likely_quantity(name, to_si(unit)[0])
    return "; ".join(filter(None, [_becomes(unit), word and f"{word} of a campaign"]))


def _becomes(unit: str) -> str:
    if not unit:
        return "its unit is not said"
    if is_unit(unit) and not is_measured(unit):
        return "a time"
    if not is_measured(unit):
        return f"its unit is not known{did_you_mean(unit, SPELT)}"
    si, factor = to_si(unit)
    return f"× {factor:g} = {si}" if factor != 1.0 else ""


def places_of(columns: Sequence[tuple[str, str]]) -> list[str]:
    """The places that names mean, of channels that are accelerations or may be."""
    felt = [k for k, (_, unit) in enumerate(columns) if to_si(unit)[0] in ("", ACCELERATION)]
    guessed = dict(zip(felt, likely_points([columns[k][0] for k in felt]), strict=True))
    return [
        "" if good_for(name, to_si(unit)[0]) else name if name in POINTS else guessed.get(k, "")
        for k, (name, unit) in enumerate(columns)
    ]


def _entry(column: Found) -> Iterator[str]:
    """The lines of a channel: how a mapping names it, its own name, its unit and its place."""
    unit = column.unit
    note = f"  # {column.why}" if column.why else ""
    if not unit:
        note = "  # not said: g, m/s²?"
    elif not is_unit(unit):
        note = f"  # not known here: it stays as it is{did_you_mean(unit, SPELT)}"
    point = column.point if column.placed else ""
    where = ""
    if column.point and not column.placed:
        where = f"  # {column.point} by its name, once its unit is said"
    elif point and point != column.name:
        where = "  # by its name: is it so?"
    yield from (
        "",
        "[[channel]]",
        f"column = {column.key}",
        f"name = {quoted(column.name)}",
        f"unit = {quoted(unit)}{note}",
        f"point = {quoted(point)}{where}",
    )
