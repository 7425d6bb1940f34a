"""How a text file is laid out, found from its look: separator, names, units, first and last row."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from wheelhop.formats import cells
from wheelhop.formats.digits import Digits, is_numeric, tell
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.labels import NO_UNITS, bare_unit, is_unit, joined_heads
from wheelhop.formats.stamps import is_stamp

LOOK = 200  # lines in which the table has to begin
TAIL = 200  # lines below it that may be something else
SPREAD = 300  # lines of the rest that are looked at
SAMPLE_ROWS = 100_000
SHOWN = 5000  # cells of a column
DIGITS = frozenset("0123456789+-.")
HEAD_LINES = 4  # of names and units, at most
SEPARATORS = (";", "\t", ",", "|", None)
"""The ones first that stand between cells and nowhere else. None: runs of blanks."""


@dataclass(frozen=True)
class Layout:
    """How a text file is laid out; lines count from 1, 0: there is none.

    `rows` are the cells of the first `SAMPLE_ROWS` rows. `numeric` are the columns of numbers,
    `stamps` those of dates or times of day. `below` is what stands under the table, "" for nothing;
    `aside` are lines of numbers between the names and the rows, such as ranges and factors, with
    their own numbers. Names may be `counted_names`: 0, 1, 2, …
    """

    separator: str | None
    digits: Digits
    header_rows: tuple[int, ...]
    units_row: int
    first_row: int
    last_row: int
    labels: tuple[str, ...]
    units: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numeric: tuple[int, ...]
    stamps: tuple[int, ...]
    below: str = ""
    aside: tuple[tuple[int, str], ...] = ()
    counted_names: bool = False

    def column(self, k: int) -> list[str]:
        """The cells of one column."""
        return [row[k] for row in self.rows]


@dataclass(frozen=True)
class _Style:
    """A separator, how many cells a row has with it, and which columns hold numbers or stamps."""

    separator: str | None
    width: int
    numeric: tuple[int, ...]
    stamps: tuple[int, ...]
    score: float

    def cells(self, line: str) -> list[str] | None:
        """The cells of a line, None if they are not as many as a row has."""
        try:
            found = cells.split_head(line, self.separator)
        except (ValueError, IndexError):
            return None
        if len(found) == self.width + 1 and not found[-1].strip():
            found.pop()
        return found if len(found) == self.width else None

    def is_row(self, line: str) -> bool:
        """Whether a line is a row: values or nothing in all columns that hold values."""
        found = self.cells(line)
        if found is None or cells.is_remark(line, self.separator):
            return False
        kinds = [_kind(found[k]) for k in (*self.numeric, *self.stamps)]
        return "word" not in kinds and kinds.count("empty") < len(kinds)

    def values_in(self, line: str) -> int:
        """How many cells of columns of values hold one."""
        found = self.cells(line)
        return 0 if found is None else sum(_kind(found[k]) == "number" for k in self.numeric)


def find_layout(text: cells.Text, where: str) -> Layout:
    """The layout of a text file's lines, in which most cells are numbers.

    Raises `ExchangeError`, whose message begins with `where`, for a file without columns of
    numbers, one with a second table, and one whose separators are decimal signs as well.
    """
    lines = text.lines
    step = max(1, len(lines) // SPREAD)
    looked = [line for line in (*lines[: 2 * LOOK], *lines[2 * LOOK :: step]) if line.strip()]
    styles = [style for narrowest in (2, 1) for style in _styles(looked, narrowest)]
    doubled = ""
    for style in sorted(styles, key=lambda style: (style.width == 1, -style.score)):
        if (first := _first_row(lines, style, where)) is None:
            continue
        layout = _described(text, style, first, where)
        if not _splits_numbers(lines, layout):
            return layout
        doubled = (
            f"{where}: line {first + 1}: commas stand between the columns and inside the numbers:"
            " save it with another separator, or with quotes around the numbers"
        )
    if doubled:
        raise ExchangeError(doubled)
    raise ExchangeError(f"{where}: no columns of numbers are found in its first {LOOK} lines")


def _kind(cell: str) -> str:
    cell = cell.strip()
    if cell.lower() in cells.EMPTY:
        return "empty"
    if is_numeric(cell):
        return "number"
    return "stamp" if cell[:1].isdigit() and is_stamp(cell) else "word"


def _all_values(line: str, separator: str | None) -> bool:
    """Whether a line holds values alone, several of them."""
    try:
        kinds = [_kind(cell) for cell in cells.split_head(line, separator)]
    except (ValueError, IndexError):
        return False
    return "word" not in kinds and len(kinds) - kinds.count("empty") > 1


def _styles(lines: Sequence[str], narrowest: int) -> list[_Style]:
    found: list[_Style] = []
    for separator in SEPARATORS:
        if separator is None and (
            found or _stands_in_most(lines, ";") or _stands_in_most(lines, "|")
        ):
            break  # nearly every line has blanks in it
        style = _style(lines, separator, narrowest)
        if style is not None:
            found.append(style)
    return found


def _style(lines: Sequence[str], separator: str | None, narrowest: int) -> _Style | None:
    """What the lines look like with this separator, None if few of them are rows then."""
    rows: list[list[str]] = []
    for line in lines:
        try:
            row = cells.split_head(line, separator)
        except (ValueError, IndexError):
            continue
        kinds = [_kind(cell) for cell in row]
        values = kinds.count("number") + kinds.count("stamp")
        if len(row) >= narrowest and values > (len(row) - kinds.count("empty")) // 2:
            rows.append(row[:-1] if len(row) > 1 and not row[-1].strip() else row)
    if not rows:
        return None
    # A separator at the end of a line ends no cell; a last column that is mostly empty is one.
    width = Counter(len(row) for row in rows).most_common(1)[0][0]
    fuller = sum(len(row) == width + 1 for row in rows)
    width += fuller > 0 and _ends_open(lines, separator, width + 1)
    same = [row + [""] * (width - len(row)) for row in rows if width - 1 <= len(row) <= width]
    numeric, stamps, values = [], [], 0
    for k in range(width):
        count = Counter(_kind(row[k]) for row in same)
        there = len(same) - count["empty"]
        if there and count["number"] >= 0.8 * there:
            numeric.append(k)
        elif there and count["stamp"] >= 0.8 * there:
            stamps.append(k)
        values += count["number"] + count["stamp"]
    if not numeric:
        return None
    share = values / sum(len(row) for row in same)
    return _Style(separator, width, tuple(numeric), tuple(stamps), values * share)


def _stands_in_most(lines: Sequence[str], mark: str) -> bool:
    return sum(mark in line for line in lines) > len(lines) / 2


def _ends_open(lines: Sequence[str], separator: str | None, width: int) -> bool:
    """Whether most lines have so many cells, with the last one empty in some."""
    mark = "\0" if separator is None else separator
    return sum(line.count(mark) == width - 1 for line in lines) > len(lines) / 2


def _first_row(lines: Sequence[str], style: _Style, where: str) -> int | None:
    """The index of the first row: from there on there are rows only, but for damaged ones, remarks
    and repeated names."""
    head = lines[: 2 * LOOK]
    rows = [style.is_row(line) for line in head]
    last = max((k for k, row in enumerate(rows) if row), default=-1)
    begins = [k for k in range(last + 1) if rows[k] and not (k and rows[k - 1])]
    for start in begins:
        if start >= LOOK:
            break
        above = {line.strip() for line in head[:start]}
        wrong = next(
            (
                k
                for k in range(start, last + 1)
                if not rows[k]
                and head[k].strip()
                and not cells.is_remark(head[k], style.separator)
                and head[k].strip() not in above
                and not style.values_in(head[k])
            ),
            None,
        )
        due = sum(bool(line.strip()) for line in head[start:])
        if wrong is None and 2 * sum(rows[start:]) < due:
            return None  # prose with a number in it
        if wrong is None:
            return start
        if sum(rows[start:wrong]) > HEAD_LINES:
            raise ExchangeError(
                f"{where}: line {wrong + 1} begins something else than the rows above it: "
                "cut the file there"
            )
    return None


def _described(text: cells.Text, style: _Style, first: int, where: str) -> Layout:
    lines = text.lines
    bottom = max(first, len(lines) - TAIL)
    last = next((k for k in range(len(lines) - 1, bottom - 1, -1) if style.is_row(lines[k])), None)
    if last is None:
        raise ExchangeError(
            f"{where}: its last {len(lines) - bottom} lines are no rows of the table that begins in"
            f" line {first + 1}: cut the file"
        )
    header, units_row, labels, units, aside = _heads(lines, style, first)
    if counted := not header and _counts_columns(lines, style, first):
        header, labels, first = (first + 1,), tuple(style.cells(lines[first]) or ()), first + 1
        labels = tuple(label.strip() or f"column {k}" for k, label in enumerate(labels, start=1))
    rows = _rows(lines[first : last + 1], style)
    columns = [[row[k] for row in rows] for k in style.numeric]
    below = [line for line in lines[last + 1 :] if line.strip()]
    other = [k for k in range(last + 1, len(lines)) if _all_values(lines[k], style.separator)]
    if len(other) > HEAD_LINES:
        raise ExchangeError(
            f"{where}: line {text.number(other[0])} begins another table, below the one that ends"
            f" in line {text.number(last)}: cut the file there"
        )
    return Layout(
        separator=style.separator,
        digits=tell([_some(column) for column in columns], style.separator),
        header_rows=header,
        units_row=units_row,
        first_row=first + 1,
        last_row=text.number(last) if below else 0,
        labels=labels,
        units=units,
        rows=rows,
        numeric=style.numeric,
        stamps=style.stamps,
        below=below[0].strip()[:40] if below else "",
        aside=aside,
        counted_names=counted,
    )


def _counts_columns(lines: Sequence[str], style: _Style, row: int) -> bool:
    """Whether a row counts the columns, 0, 1, 2, …, and the next one does not go on counting."""
    here, after = (style.cells(line) or [] for line in (*lines[row : row + 2], "")[:2])
    numbers = [cell.strip() for cell in here]
    numbers = numbers[1:] if numbers[:1] == [""] else numbers
    counted = any(numbers == [str(k + n) for k in range(len(numbers))] for n in (0, 1))
    return counted and len(numbers) > 2 and not all(cell.strip().isdigit() for cell in after)


def _rows(lines: Sequence[str], style: _Style) -> tuple[tuple[str, ...], ...]:
    """The cells of the first rows."""
    sample = lines[:SAMPLE_ROWS]
    key = (*style.numeric, *style.stamps)[0]
    rows = []
    for line, row in zip(sample, cells.split(sample, style.separator), strict=True):
        wide = len(row) - (len(row) == style.width + 1 and not row[-1].strip())
        # What begins like a number is taken for a row here; a cell that is none is told on reading.
        if wide == style.width and (row[key].strip()[:1] in DIGITS or style.is_row(line)):
            rows.append(tuple(row[:wide]))
    return tuple(rows)


def _some(column: Sequence[str]) -> Sequence[str]:
    """Cells of a column that show how its numbers are written: the first, and some of the rest."""
    return [*column[:SPREAD], *column[SPREAD :: max(1, len(column) // SHOWN)]]


def _heads(
    lines: Sequence[str], style: _Style, first: int
) -> tuple[tuple[int, ...], int, tuple[str, ...], tuple[str, ...], tuple[tuple[int, str], ...]]:
    """Lines of names, the line of units, names and units, and lines of numbers below the names:
    above the rows, of as many cells."""
    above: list[tuple[int, list[str]]] = []
    for k in range(first - 1, -1, -1):
        if not lines[k].strip():
            continue
        found = style.cells(lines[k]) or style.cells(lines[k].rpartition(style.separator or " ")[0])
        if found is None or style.is_row(lines[k]) or len(above) == HEAD_LINES:
            break
        if any(cell.strip().lower() not in NO_UNITS for cell in found):
            above.append((k + 1, [cell.strip() for cell in found]))
    units_row = 0
    units: tuple[str, ...] = ()
    words = [k for k, (_, found) in enumerate(above) if not any(map(is_numeric, found))]
    last = next((k for k in words if len(set(above[k][1])) == style.width), 0)
    aside = tuple((n, lines[n - 1]) for k, (n, _) in enumerate(above[:last]) if k not in words)
    above = [head for k, head in enumerate(above) if k >= last or k in words]
    if above:
        heads = [found for _, found in above]
        at = next((i for i in range(len(heads)) if _is_units(heads[i], heads[i + 1 :])), None)
        if at is not None:
            units_row, units = above[at][0], tuple(bare_unit(cell) for cell in above[at][1])
            above = above[:at] + above[at + 1 :]
    if not above:
        return (), units_row, tuple(f"column {k + 1}" for k in range(style.width)), units, aside
    used = above[:1]
    for more in range(2, len(above) + 1):
        if _distinct(_joined(used)):
            break
        if _distinct(_joined(above[:more])):
            used = above[:more]
    labels = _joined(used)
    named = tuple(label or f"column {k}" for k, label in enumerate(labels, start=1))
    return tuple(sorted(k for k, _ in used)), units_row, named, units, aside


def _joined(heads: Sequence[tuple[int, list[str]]]) -> list[str]:
    return joined_heads([found for _, found in reversed(heads)])


def _distinct(labels: Sequence[str]) -> bool:
    named = [label for label in labels if label]
    return len(set(named)) == len(named)


def _is_units(found: Sequence[str], above: Sequence[Sequence[str]]) -> bool:
    """Whether a line holds units: most of its cells are known ones or in brackets, or half of them
    with the first; or the first is, and cells repeat, or there are blanks, where a line `above` has
    a name of its own in every column. A line with none above holds units only if all its cells
    do."""
    there = [cell for cell in found if cell.lower() not in NO_UNITS]
    known = [is_unit(bare_unit(cell)) or bare_unit(cell) != cell for cell in there]
    if not there or not above:
        return bool(there) and all(known)
    blanks = len(there) < len(found)
    named = any(all(other) and _distinct(other) for other in above)
    half = 2 * sum(known) - len(there)
    again = named and not _distinct(there)
    return (blanks and named) or half > 0 or (known[0] and (half == 0 or again))


def _splits_numbers(lines: Sequence[str], layout: Layout) -> bool:
    """Whether commas stand between the columns and, unquoted, inside the numbers as well: there are
    half as many names, or the halves behind the commas begin with zeros."""
    cells_there = [row[k] for row in layout.rows for k in layout.numeric]
    if layout.separator != "," or any("." in cell or "," in cell for cell in cells_there):
        return False
    above = next((line for line in reversed(lines[: layout.first_row - 1]) if line.strip()), "")
    halved = 2 * len(cells.split_head(above, ",")) == len(layout.labels) if above else False
    padded = any(re.fullmatch(r"[+-]?0\d+", cell.strip()) for cell in cells_there)
    return padded or (halved and not layout.header_rows)
