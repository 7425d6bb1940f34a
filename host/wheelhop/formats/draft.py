"""What a file of another recorder seems to hold, and a first mapping for it that the user corrects.

What the file does not say is a question, and a blank key of the mapping; it is never made up.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from wheelhop.files import quoted
from wheelhop.files.units import seconds_in, to_si
from wheelhop.formats import cells
from wheelhop.formats.asked import answered, resample_keys, timing_keys, uneven_stamps
from wheelhop.formats.columns import Column, Question, Timing
from wheelhop.formats.digits import Digits, is_numeric
from wheelhop.formats.error import ExchangeError, guarded
from wheelhop.formats.labels import apart, is_doubtful, name_and_unit
from wheelhop.formats.layout import Layout, find_layout
from wheelhop.formats.long_form import is_key
from wheelhop.formats.mapping import ASKED, SEPARATORS
from wheelhop.formats.registry import is_text, load
from wheelhop.formats.stamps import Stamps, of_texts
from wheelhop.formats.stated import stated_rates
from wheelhop.formats.timing import find_timing
from wheelhop.formats.understood import (
    CHANNEL,
    LEFT_OUT,
    TIME,
    Found,
    Understood,
    places_of,
    short,
    why_of,
)
from wheelhop.formats.understood_tables import of_tables

ROW_EACH = "a row holds a value of one channel"
UNNAMED = re.compile(r"[\s,\"]*[,\"][\s,\"]*")
"""What a name cannot hold in every format that is written."""


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
        return of_tables(path, load(path), answers)
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
    key = _key_column(layout, columns)
    if key is not None:  # in long form: the rows of one channel tell the time
        columns = _columns(_rows_of_one(layout, key), digits)
    above = [k for k in range(1, layout.first_row) if k not in layout.header_rows]
    head = range(1, layout.first_row)
    shown = any(digits.decimal in cell for k in layout.numeric for cell in layout.column(k))
    decimal = digits.decimal if shown else ""
    stated = stated_rates([text.lines[k - 1] if k in above else "" for k in head], decimal)
    blank = bool(questions)  # the numbers cannot be read yet, nor the time
    try:
        timing = Timing() if blank else answered(find_timing(columns, stated), answers)
    except ExchangeError as error:
        raise ExchangeError(f"{path}: {error}") from None
    questions += timing.questions
    words = ""
    if timing.index is not None and not questions and key is None:
        column = _first_rows(columns[timing.index], text.begun - layout.first_row + 1)
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
            ("last_row", str(layout.last_row), f"below it: {short(layout.below)}")
            if layout.last_row
            else None
        ),
        *timing_keys(timing, names),
        *resampling,
        ("by", names[key], "says which channel a row is of") if key is not None else None,
    ]
    said = tuple(item for item in keys if item is not None)
    granted = tuple(filter(None, [timing.guess]))
    if key is not None and not questions:
        return replace(_in_long_form(path, said, answers), guesses=(*granted, ROW_EACH))
    return Understood(
        path,
        said,
        tuple(_found(layout, columns, timing, names)),
        tuple(questions),
        (*granted, *_guesses(layout, columns, timing)),
    )


def _key_column(layout: Layout, columns: Sequence[Column]) -> int | None:
    """The column of words that say which channel a row is of, None if there is none."""
    numbers = [column.values for column in columns if column.values is not None]
    words = (k for k in range(len(columns)) if k not in (*layout.numeric, *layout.stamps))
    return next((k for k in words if is_key(layout.column(k), numbers)), None)


def _rows_of_one(layout: Layout, key: int) -> Layout:
    """The rows of the channel that has most."""
    most, _ = Counter(layout.column(key)).most_common(1)[0]
    return replace(layout, rows=tuple(row for row in layout.rows if row[key] == most))


def _in_long_form(
    path: Path, keys: tuple[tuple[str, str, str], ...], answers: Mapping[str, str]
) -> Understood:
    """What is understood of a table with a row for each value, once its time is known."""
    without = tuple(item for item in keys if item[0] != "resample_hz")
    tables = load(path, Understood(path, without, ()).mapping())
    return of_tables(path, tables, answers, without)


def _guesses(layout: Layout, columns: Sequence[Column], timing: Timing) -> Iterator[str]:
    """What is taken for granted of the table: the names in its first line, what stands above its
    rows is not applied to them, columns that are left out though some cells are numbers, and units
    that only the end of a name says."""
    if layout.counted_names:
        yield f"line {layout.header_rows[0]} names the columns, by numbers"
    for number, line in layout.aside:
        yield f"line {number} is not applied to the rows: {short(line.strip())[:40]}"
    for k, column in enumerate(columns):
        if column.values is None and column.stamps is None and (word := _no_number(layout, k)):
            yield f"{short(column.label)} is left out: {word}"
    for k, column in enumerate(columns):
        said = layout.units[k] if layout.units else ""
        inside = name_and_unit(column.label, endings=False)[1]
        if said and inside and _means(said) != _means(inside):
            yield f"{column.label} is in {said}, as line {layout.units_row} says"
        by_name = column.unit and not said and not inside
        if by_name and k != timing.index and is_doubtful(column.label):
            yield f"{column.label} is in {column.unit}, by the end of its name"


def _means(unit: str) -> tuple[str, float]:
    """A unit whatever it is spelt like."""
    seconds = seconds_in(unit)
    return to_si(unit) if seconds is None else ("s", seconds)


def _no_number(layout: Layout, k: int) -> str:
    """What keeps a column in which there are numbers from being one of numbers; "" for words."""
    there = [cell for cell in layout.column(k) if cell.strip().lower() not in cells.EMPTY]
    wrong = next((cell for cell in there if not is_numeric(cell)), "")
    return f"'{short(wrong.strip())[:20]}' is no number" if any(map(is_numeric, there)) else ""


def _first_rows(column: Column, rows: int) -> Column:
    """The first rows of a large text, of which lines in the middle were passed over; all of one
    that was read whole, where `rows` is not above 0."""
    if rows <= 0 or column.values is None:
        return column
    return replace(column, values=column.values[:rows])


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
    points = places_of([(names[k], columns[k].unit) for k in taken])
    for k, column in enumerate(columns):
        if k == timing.index:
            unit = timing.unit or column.unit
            yield Found(keys[k], column.label, column.name, unit, TIME, timing.why)
        elif k in names:
            point = points[taken.index(k)]
            name, why = names[k], why_of(names[k], column.unit)
            yield Found(keys[k], column.label, name, column.unit, CHANNEL, why, point)
        else:
            plain = "a clock, too" if column.stamps else _no_number(layout, k) or "no numbers"
            why = timing.aside.get(k, plain)
            yield Found(keys[k], column.label, column.name, column.unit, LEFT_OUT, why)


def _keys(labels: Sequence[str]) -> list[str]:
    """How a mapping names each column: by its label, or by number where the label will not do."""
    count = Counter(labels)
    return [
        str(k) if label == f"column {k}" or count[label] > 1 else quoted(label)
        for k, label in enumerate(labels, start=1)
    ]
