"""Rows of plain text parsed by pyarrow: what `cells` makes of them, in less time and room.

Whatever is not plain is left to `cells`, which says where it is wrong.
"""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import check_room
from wheelhop.formats import cells
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.mapping import Map

LEAST_BYTES = 1 << 20
"""Shorter files are not worth the loading of a library."""
ROOM = 2.5
"""Bytes of memory for each byte of a text of six characters a number: its numbers, in two tables,
and what the time stamps take."""
PIECE_BYTES = 1 << 20
EMPTY = sorted({form for cell in cells.EMPTY for form in (cell, cell.upper(), cell.title())})


@dataclass(frozen=True)
class Body:
    """Where in a file the bytes of its rows are, the number of their first line and how many lines
    they are, whether lines below are cut off, and the `head`: the lines above the rows and the
    first of these."""

    path: Path
    start: int
    stop: int
    first: int
    count: int
    cut: bool
    head: Sequence[str]


def plain_body(path: Path, mapping: Map) -> Body | None:
    """The rows of a large file, None if it is small, or not plain: another encoding than UTF-8,
    signs that group digits, runs of blanks as separators, or letters that are not ASCII below the
    names. Raises `ExchangeError` for a file that takes more memory than is free."""
    size = path.stat().st_size
    plain = mapping.separator is not None and not mapping.thousands and not mapping.encoding
    if not plain or size < LEAST_BYTES:
        return None
    check_room(path, ROOM * size, ExchangeError)
    with path.open("rb") as file:
        head = file.read(PIECE_BYTES)
        start = _after_lines(head, mapping.first - 1)
        try:
            lines = head[: head.rfind(b"\n") + 1].decode("utf-8-sig").splitlines()
        except UnicodeDecodeError:
            return None
        if start is None or b"\r" in head.replace(b"\r\n", b"") or len(lines) <= mapping.first:
            return None
        file.seek(start)
        at, number, stop = start, mapping.first, None
        last = b""
        while piece := file.read(PIECE_BYTES):
            if not piece.isascii() or b"\0" in piece:
                return None
            ends = piece.count(b"\n")
            if stop is None and mapping.last_row and number + ends > mapping.last_row:
                stop = at + (_after_lines(piece, mapping.last_row + 1 - number) or 0)
            at, number, last = at + len(piece), number + ends, piece
    if stop is not None:
        count = mapping.last_row - mapping.first + 1
        return Body(path, start, stop, mapping.first, count, True, lines)
    if not last.endswith(b"\n"):
        number += 1
    if last.endswith((b"\n\n", b"\n\r\n")) or not last.rstrip(b"\r\n").rpartition(b"\n")[2].strip():
        return None  # blank lines at the end
    return Body(path, start, at, mapping.first, number - mapping.first, False, lines)


def _after_lines(data: bytes, count: int) -> int | None:
    """Where so many lines have ended."""
    at = 0
    for _ in range(count):
        at = data.find(b"\n", at) + 1
        if not at:
            return None
    return at


class _Part(io.RawIOBase):
    """A file that begins and ends where the rows do."""

    def __init__(self, file: BinaryIO, body: Body) -> None:
        self._file, self._left = file, body.stop - body.start
        file.seek(body.start)

    def readable(self) -> bool:
        """It is."""
        return True

    def read(self, size: int = -1) -> bytes:
        """The next bytes."""
        data = self._file.read(self._left if size < 0 else min(size, self._left))
        self._left -= len(data)
        return data


def parse_body(
    body: Body, mapping: Map, width: int, numbers: Sequence[int], texts: Sequence[int]
) -> tuple[NDArray[np.float64], list[list[str]]] | None:
    """The columns of `numbers` (n, c) and those of `texts`, each by its index; None if a line is no
    row of so many cells, or a cell no number."""
    import pyarrow
    from pyarrow import csv

    kinds = {str(k): pyarrow.float64() for k in numbers} | {str(k): pyarrow.string() for k in texts}
    values = np.empty((body.count, len(numbers)), order="F")
    words: list[list[str]] = [[] for _ in texts]
    row = 0
    try:
        with body.path.open("rb") as file:
            reader = csv.open_csv(
                pyarrow.PythonFile(_Part(file, body), mode="r"),
                csv.ReadOptions(column_names=[str(k) for k in range(width)], block_size=1 << 22),
                csv.ParseOptions(delimiter=mapping.separator, newlines_in_values=False),
                csv.ConvertOptions(
                    column_types=kinds,
                    include_columns=list(kinds),
                    decimal_point=mapping.decimal,
                    null_values=EMPTY,
                    check_utf8=False,
                ),
            )
            for batch in reader:
                if row + batch.num_rows > body.count:
                    return None
                for at, k in enumerate(numbers):
                    values[row : row + batch.num_rows, at] = _numbers(batch.column(str(k)))
                for found, k in zip(words, texts, strict=True):
                    found += [text or "" for text in batch.column(str(k)).to_pylist()]
                row += batch.num_rows
    except pyarrow.ArrowException:
        return None
    return (values, words) if row == body.count else None  # blank lines are passed over


def _numbers(column: Any) -> NDArray[np.float64]:
    """A column of float64 as it lies in memory, NaN where it has no value; pyarrow's own way to
    NumPy loads pandas, 70 MB."""
    if column.null_count:
        column = column.fill_null(math.nan)
    held = np.frombuffer(column.buffers()[1], np.float64)
    return held[column.offset : column.offset + len(column)]
