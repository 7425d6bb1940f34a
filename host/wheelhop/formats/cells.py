"""Text files of numbers: their encoding, their cells, and what is wrong with one."""

from __future__ import annotations

import codecs
import csv
import math
from collections.abc import Callable, Sequence
from datetime import date, datetime, time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import TABLE, read_bytes, read_text_bytes
from wheelhop.formats.error import ExchangeError

BOMS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
EMPTY = frozenset(("", "nan", "na", "n/a", "-", "null", "none"))
"""What recorders write where there is no value."""
NO_DATE = date.min


def read_lines(file: Path, encoding: str = "") -> list[str]:
    """The lines of a text file, without those at the end that are blank.

    Without an `encoding` it is the byte order mark's, UTF-8, or else what Windows calls ANSI.
    """
    data = (
        read_bytes(file, ExchangeError, TABLE) if encoding else read_text_bytes(file, ExchangeError)
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
    return text.replace("\r\n", "\n").replace("\r", "\n").rstrip().split("\n")


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


def instant(stamp: str) -> datetime:
    """A date and time of ISO 8601, or a time of day, at `NO_DATE`; raises ValueError else."""
    try:
        return datetime.fromisoformat(stamp)
    except ValueError:
        return datetime.combine(NO_DATE, time.fromisoformat(stamp))


def parse(
    cells: Sequence[str], decimal: str, where: Callable[[int], str], name: str
) -> NDArray[np.float64]:
    """(n,) the numbers of one column, NaN for empty cells.

    Raises `ExchangeError` for the first cell that is something else.
    """
    if decimal == ",":
        cells = [cell.replace(",", ".") for cell in cells]
    try:
        numbers = np.fromiter(map(float, cells), np.float64, len(cells))
    except ValueError:
        numbers = np.array([_parse_cell(k, cell, where, name) for k, cell in enumerate(cells)])
    if "_" in "".join(cells):  # Python reads 1_000
        row = next(k for k, cell in enumerate(cells) if "_" in cell)
        raise ExchangeError(f"{where(row)}: {name}: '{cells[row][:20]}' is not a number")
    return numbers


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
