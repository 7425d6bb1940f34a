"""Text files of numbers: their encoding, their cells, and what is wrong with one."""

from __future__ import annotations

import codecs
import csv
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import TABLE, check_plain, read_bytes, read_text_and_zeros
from wheelhop.formats.error import ExchangeError

BEGIN_BYTES, END_BYTES = 1 << 24, 1 << 20
"""Of a large file that is looked at, how much of either end."""
UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
BOMS = ((codecs.BOM_UTF8, "utf-8-sig"), *((mark, "utf-16") for mark in UTF_16))
EMPTY = frozenset(("", "nan", "na", "n/a", "#n/a", "#nv", "-", "--", "---", "null", "none"))
"""What recorders write where there is no value."""


@dataclass(frozen=True)
class Text:
    """The lines of a text file, and what is worth a line in the history. Of a large one that is
    only looked at, `passed_over` lines are missing after the first `begun`."""

    lines: list[str]
    remarks: tuple[str, ...] = ()
    begun: int = 0
    passed_over: int = 0

    def number(self, index: int) -> int:
        """The number, from 1, of a line by its index."""
        return index + 1 + (self.passed_over if index >= self.begun else 0)


def read_lines(file: Path, encoding: str = "") -> Text:
    """The lines of a text file, without those at the end that are blank.

    Without an `encoding` it is the byte order mark's, UTF-8, or else what Windows calls ANSI. Zero
    bytes at the end, of room that a logger had reserved, are left out.
    """
    data, zeros = (
        (read_bytes(file, ExchangeError, TABLE), 0)
        if encoding
        else read_text_and_zeros(file, ExchangeError)
    )
    marked = next((name for mark, name in BOMS if data.startswith(mark)), "")
    for name in [encoding] if encoding else [marked or "utf-8", "cp1252", "latin-1"]:
        try:
            text = data.decode(name)
            break
        except LookupError:
            raise ExchangeError(f'{file}: there is no encoding "{name}"') from None
        except UnicodeDecodeError as error:
            if name == encoding:
                raise ExchangeError(
                    f"{file}: byte {error.start} (0x{data[error.start]:02x}) is not {name}: "
                    "give another encoding in the mapping"
                ) from None
    text = text.replace("\u2212", "-")  # the minus of typesetters
    left_out = f"zero bytes behind the text, of room that was reserved: {zeros}; left out"
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    while len(lines) > 1 and not lines[-1].strip():
        lines.pop()
    return Text(lines, (left_out,) if zeros else ())


def first_lines(file: Path) -> list[str]:
    """The first two lines, or less where there are not so many."""
    head = b""
    if file.stat().st_size > END_BYTES:
        with file.open("rb") as stream:
            head = stream.read(END_BYTES)
    plain = head and b"\0" not in head
    return (_lines(head) if plain else read_lines(file).lines)[:2]


def names_in(line: str) -> list[str]:
    """The cells of a line, between commas, as our own tables have them."""
    return [name.strip().strip('"').strip() for name in line.split(",")]


def read_ends(file: Path) -> Text:
    """As `read_lines`, but of a large file the lines of both ends alone."""
    check_plain(file, ExchangeError)
    if file.stat().st_size < 2 * (BEGIN_BYTES + END_BYTES):
        return read_lines(file)
    with file.open("rb") as stream:
        left = os.fstat(stream.fileno()).st_size - BEGIN_BYTES - END_BYTES
        begin, passed_over = stream.read(BEGIN_BYTES), 0
        while left > 0 and (piece := stream.read(min(END_BYTES, left))):
            passed_over += piece.count(b"\n")
            left -= len(piece)
        end = stream.read()
    kept, cut, rest = begin.rpartition(b"\n")
    _, newline, tail = end.partition(b"\n")
    if not cut or not newline or b"\0" in begin or b"\0" in end:
        return read_lines(file)
    lines, below = _lines(kept), _lines(tail)
    while len(below) > 1 and not below[-1].strip():
        below.pop()
    passed_over += rest.count(b"\n") + 1
    return Text(lines + below, (), len(lines), passed_over)


def _lines(data: bytes) -> list[str]:
    """The lines of bytes in UTF-8, or else what Windows calls ANSI."""
    for name in ("utf-8-sig", "cp1252", "latin-1"):
        try:
            text = data.decode(name)
            break
        except UnicodeDecodeError:
            pass
    return text.replace("\u2212", "-").replace("\r\n", "\n").replace("\r", "\n").split("\n")


def split(lines: Sequence[str], separator: str | None) -> list[list[str]]:
    """The cells of each line; quotes protect a separator. None separates at runs of blanks."""
    if separator is None:
        return [line.split() for line in lines]
    rows = list(csv.reader(lines, delimiter=separator))
    if len(rows) != len(lines):
        raise ValueError("a quote is opened and not closed in the same line")
    return rows


def split_head(line: str, separator: str | None) -> list[str]:
    """The cells of a line above the numbers, which may be marked as a comment."""
    return split([line.lstrip("#% ") if line.startswith(("#", "%")) else line], separator)[0]


def is_remark(line: str, separator: str | None) -> bool:
    """Whether a line is a remark, marked by # or %; "#N/A" is a cell without a value."""
    marked = line.lstrip().startswith(("#", "%"))
    return marked and line.strip().split(separator)[0].strip().lower() not in EMPTY


def parse(
    cells: Sequence[str],
    decimal: str,
    where: Callable[[int], str],
    name: str,
    thousands: str = "",
) -> NDArray[np.float64]:
    """(n,) the numbers of one column, NaN for empty cells.

    Raises `ExchangeError` for the first cell that is something else: also for a decimal sign that
    is not `decimal`, or `thousands` that do not stand between groups of three digits.
    """
    joined = "\n".join(cells)
    if "_" in joined or (decimal == "," and "." in joined) or (thousands and thousands in joined):
        return np.array(
            [_exact(k, cell, decimal, where, name, thousands) for k, cell in enumerate(cells)]
        )
    if decimal == ",":
        cells = joined.replace(",", ".").split("\n") if cells else cells
    try:
        return np.fromiter(map(float, cells), np.float64, len(cells))
    except ValueError:
        return np.array([_parse_cell(k, cell, where, name) for k, cell in enumerate(cells)])


def _exact(
    row: int, cell: str, decimal: str, where: Callable[[int], str], name: str, thousands: str
) -> float:
    """One number, its marks checked."""
    whole, mark, fraction = cell.strip().partition(decimal)
    first, *groups = whole.split(thousands) if thousands else [whole]
    grouped = not groups or (0 < len(first.lstrip("+-")) <= 3 and all(len(g) == 3 for g in groups))
    strange = {"_", "." if decimal == "," else ","} & {*first, *fraction, *"".join(groups)}
    if strange or not grouped:  # Python reads 1_000
        raise ExchangeError(f"{where(row)}: {name}: '{cell.strip()[:20]}' is not a number")
    return _parse_cell(row, f"{first}{''.join(groups)}{mark and '.'}{fraction}", where, name)


def _parse_cell(row: int, cell: str, where: Callable[[int], str], name: str) -> float:
    if cell.strip().lower() in EMPTY:
        return math.nan
    if not is_number(cell):
        raise ExchangeError(f"{where(row)}: {name}: '{cell.strip()[:20]}' is not a number")
    return float(cell)


def is_number(cell: str, decimal: str = ".") -> bool:
    """Whether a cell holds a number."""
    try:
        float(cell.replace(decimal, "."))
    except ValueError:
        return False
    return "_" not in cell
