"""What a file of another recorder seems to hold, and a first mapping for it that the user corrects.

What the file does not say is a question, and a blank key of the mapping; it is never made up.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from wheelhop.files import did_you_mean, quoted
from wheelhop.files.units import SPELT, is_measured, to_si
from wheelhop.formats import cells
from wheelhop.formats.asked import answered, resample_keys, timing_keys, uneven, uneven_stamps
from wheelhop.formats.digits import Digits
from wheelhop.formats.error import ExchangeError, guarded
from wheelhop.formats.grid import RESAMPLE
from wheelhop.formats.labels import apart, is_unit, name_and_unit
from wheelhop.formats.layout import Layout, find_layout
from wheelhop.formats.mapping import ASKED, SEPARATORS, Map, parse_mapping
from wheelhop.formats.places import likely_points
from wheelhop.formats.registry import is_text, load
from wheelhop.formats.resample import side_by_side
from wheelhop.formats.stamps import Stamps, of_texts
from wheelhop.formats.stated import stated_rates
from wheelhop.formats.table import POINTS, clocks_are_known
from wheelhop.formats.timing import Column, Question, Timing, find_timing
from wheelhop.logger.recording import ACCELERATION

CHANNEL, TIME, LEFT_OUT = "a channel", "time", "left out"
UNNAMED = re.compile(r"[\s,\"]*[,\"][\s,\"]*")
"""What a name cannot hold in every format that is written."""


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
        notes = [f"# left out: {_short(column.label)}, {column.why}" for column in left_out]
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


def draft_mapping(path: Path) -> str:
    """The text of a mapping file for `path`. Raises `ExchangeError` if no numbers are found."""
    return understand(path).text()


def understand(path: Path, answers: Mapping[str, str] | None = None) -> Understood:
    """What a file seems to hold; `answers` are to questions of before, by their keys.

    Raises `ExchangeError` for a file without columns of numbers, and for an answer that is none.
    """
    answers = answers or {}
    for key, answer in answers.items():
        if key not in ASKED:
            raise ExchangeError(f"{key} = {answer}: only {', '.join(ASKED)} can be answered")
    if not is_text(path):
        return _of_tables(path, answers)
    if not path.exists():
        raise ExchangeError(f"{path}: there is no such file")
    with guarded(path, "be understood"):
        text = cells.read_ends(path)
        layout = find_layout(text, str(path))
        found = _of_text(path, text, layout, answers)
    return replace(found, remarks=(*text.remarks, *found.remarks))


def _of_text(
    path: Path, text: cells.Text, layout: Layout, answers: Mapping[str, str]
) -> Understood:
    questions: list[Question] = []
    digits = layout.digits
    if "decimal" in answers:
        digits = Digits(answers["decimal"])
    elif digits.asked:
        questions.append(Question("decimal", f"the decimal sign: {digits.asked}"))
    columns = _columns(layout, digits)
    above = [k for k in range(1, layout.first_row) if k not in layout.header_rows]
    head = range(1, layout.first_row)
    stated = stated_rates([text.lines[k - 1] if k in above else "" for k in head])
    blank = bool(questions)  # the numbers cannot be read yet, nor the time
    try:
        timing = Timing() if blank else answered(find_timing(columns, stated), answers)
    except ExchangeError as error:
        raise ExchangeError(f"{path}: {error}") from None
    questions += timing.questions
    words = ""
    if timing.index is not None and not questions:
        column = _first_rows(columns[timing.index], text.begun)
        words = uneven_stamps(column, timing, path, layout.first_row)
    resampling, asked = resample_keys(words, answers)
    questions += asked
    names = _keys(layout.labels)
    mark = {text: name for name, text in SEPARATORS.items() if name not in ("\t", " ")}
    heads = layout.header_rows
    keys = [
        ("separator", quoted(mark[layout.separator]), ""),
        (
            "decimal",
            quoted("" if blank else digits.decimal),
            f"{digits.asked}; draft again with --answer decimal=…" if blank else "",
        ),
        ("thousands", quoted(digits.thousands), "") if digits.thousands else None,
        (
            "header_row",
            str(heads[0] if len(heads) == 1 else list(heads) or 0),
            "the line that names the columns, 0: none",
        ),
        ("units_row", str(layout.units_row), "the line with their units, 0: none"),
        ("first_row", str(layout.first_row), "the line of the first numbers"),
        (
            ("last_row", str(layout.last_row), f"below it: {_short(layout.below)}")
            if layout.last_row
            else None
        ),
        *timing_keys(timing, names),
        *resampling,
    ]
    return Understood(
        path,
        tuple(key for key in keys if key is not None),
        tuple(_found(layout, columns, timing, names)),
        tuple(questions),
        (*filter(None, [timing.guess]), *_by_endings(layout, columns, timing)),
    )


def _by_endings(layout: Layout, columns: Sequence[Column], timing: Timing) -> Iterator[str]:
    """Units that only the one letter behind a name's last _ says: the g of z_g may be the
    ground."""
    for k, column in enumerate(columns):
        said = layout.units[k] if layout.units else ""
        by_name = column.unit and not said and not name_and_unit(column.label, endings=False)[1]
        if by_name and k != timing.index and re.search(r"_[A-Za-z]$", column.label):
            yield f"{column.label} is in {column.unit}, by the end of its name"


def _first_rows(column: Column, begun: int) -> Column:
    """The rows of a large text's beginning, of which lines in the middle were passed over."""
    if not begun or column.values is None:
        return column
    return replace(column, values=column.values[:begun])


def _short(text: str) -> str:
    return "".join(char if char.isprintable() else " " for char in text)


def _columns(layout: Layout, digits: Digits) -> list[Column]:
    """The columns as numbers or stamps; cells that are neither are passed over here, and told when
    the file is read."""
    inside = [name_and_unit(label) for label in layout.labels]
    found = []
    for k, (label, (name, unit)) in enumerate(zip(layout.labels, inside, strict=True)):
        unit = (layout.units[k] if layout.units else "") or unit
        column = Column(label, name, unit)
        if k in layout.numeric:
            column = replace(column, values=_values(layout.column(k), digits))
        elif k in layout.stamps:
            column = replace(column, stamps=_read_stamps(layout.column(k)))
        found.append(column)
    return found


def _values(texts: Sequence[str], digits: Digits) -> np.ndarray:
    try:
        return cells.parse(texts, digits.decimal, str, "", digits.thousands)
    except ExchangeError:
        plain = [t.replace(digits.thousands, "") if digits.thousands else t for t in texts]
        plain = [text.replace(digits.decimal, ".") for text in plain]
        return np.array([float(t) if cells.is_number(t) else np.nan for t in plain])


def _read_stamps(texts: Sequence[str]) -> Stamps | str:
    there = [text for text in texts if text.strip().lower() not in cells.EMPTY]
    try:
        return of_texts(there, "", lambda row: f"row {row + 1}")
    except ExchangeError as error:
        return str(error).partition(": ")[2]


def _found(
    layout: Layout, columns: Sequence[Column], timing: Timing, keys: Sequence[str]
) -> Iterator[Found]:
    taken = [
        k
        for k, column in enumerate(columns)
        if column.values is not None and k != timing.index and k not in timing.aside
    ]
    named = apart(
        [UNNAMED.sub(" ", columns[k].name).strip() or f"column {k + 1}" for k in taken],
        [columns[k].unit for k in taken],
        [k + 1 for k in taken],
    )
    names = dict(zip(taken, named, strict=True))
    points = _points([(names[k], columns[k].unit) for k in taken])
    for k, column in enumerate(columns):
        if k == timing.index:
            unit = timing.unit or column.unit
            yield Found(keys[k], column.label, column.name, unit, TIME, timing.why)
        elif k in names:
            point = points[taken.index(k)]
            name, why = names[k], _why(column.unit)
            yield Found(keys[k], column.label, name, column.unit, CHANNEL, why, point)
        else:
            why = timing.aside.get(k, "a clock, too" if column.stamps else "no numbers")
            yield Found(keys[k], column.label, column.name, column.unit, LEFT_OUT, why)


def _why(unit: str) -> str:
    if not unit:
        return "its unit is not said"
    if not is_measured(unit):
        return f"its unit is not known{did_you_mean(unit, SPELT)}"
    si, factor = to_si(unit)
    return f"× {factor:g} = {si}" if factor != 1.0 else ""


def _points(columns: Sequence[tuple[str, str]]) -> list[str]:
    """The places that names mean, of channels that are accelerations or may be."""
    felt = [k for k, (_, unit) in enumerate(columns) if to_si(unit)[0] in ("", ACCELERATION)]
    guessed = dict(zip(felt, likely_points([columns[k][0] for k in felt]), strict=True))
    return [name if name in POINTS else guessed.get(k, "") for k, (name, _) in enumerate(columns)]


def _of_tables(path: Path, answers: Mapping[str, str]) -> Understood:
    keys: list[tuple[str, str, str]] = []
    tables = load(path)
    if not tables:
        raise ExchangeError(f"{path}: holds no channels of numbers")
    table = tables[0]
    several: tuple[str, ...] = ()
    if len(tables) > 1 and "resample_hz" in answers:
        table = side_by_side(tables)
    elif len(tables) > 1:
        names = ", ".join(quoted(table.group) for table in tables)
        together = f"; or leave group out, and {RESAMPLE}" if clocks_are_known(tables) else ""
        said = f"one of {names}{together}"
        keys.append(("group", quoted(table.group), said))
        several = (f"of groups with clocks of their own, {names}, the first is shown",)
    timing = Timing()
    if table.time_s is None and table.rate_hz is None:
        words = table.asked or "the file has no time"
        timing = answered(Timing(questions=(Question("rate_hz", words),)), answers)
        keys += timing_keys(timing, ())
    resampling, asked = resample_keys(uneven(table), answers)
    keys += resampling
    count = Counter(channel.name for channel in table.channels)
    units = [channel.unit for channel in table.channels]
    bare = [name_and_unit(channel.name) for channel in table.channels]
    short = [
        name if unit and unit == channel.unit else channel.name
        for (name, unit), channel in zip(bare, table.channels, strict=True)
    ]
    named = apart(short, units, table.columns)
    points = _points(list(zip(named, units, strict=True)))
    columns = []
    for k, (number, channel) in enumerate(zip(table.columns, table.channels, strict=True)):
        key = quoted(channel.name) if count[channel.name] == 1 else str(number)
        why = _why(channel.unit)
        found = Found(key, channel.name, named[k], channel.unit, CHANNEL, why, points[k])
        columns.append(found)
    questions = (*timing.questions, *asked)
    return Understood(path, tuple(keys), tuple(columns), questions, (), (*several, *table.remarks))


def _keys(labels: Sequence[str]) -> list[str]:
    """How a mapping names each column: by its label, or by number where the label will not do."""
    count = Counter(labels)
    return [
        str(k) if label == f"column {k}" or count[label] > 1 else quoted(label)
        for k, label in enumerate(labels, start=1)
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
