"""Rows of plain text parsed by pyarrow: what `cells` makes of them, in less time and room.

Whatever is not plain is left to `cells`, which says where it is wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import read_bytes
from wheelhop.formats import cells
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.mapping import Map

LEAST_BYTES = 1 << 20
"""Shorter files are not worth the loading of a library."""
ROOM = 3.5
"""Bytes of memory for each byte of a text of six characters a number: the text, its columns, and
the table made of them."""
HEAD_BYTES = 1 << 20  # that names and units stand in, with the first rows
EMPTY = sorted({form for cell in cells.EMPTY for form in (cell, cell.upper(), cell.title())})


@dataclass(frozen=True, eq=False)
class Body:
    """The bytes of a text's rows, the number of the first line and of lines, whether lines below
    were `cut` off, and the `head`: the lines above the rows and the first of these."""

    data: memoryview
    first: int
    count: int
    cut: bool
    head: Sequence[str]
    separator: str
    decimal: str


def plain_body(path: Path, mapping: Map) -> Body | None:
    """The rows of a large file, None if it is small, or not plain: another encoding than UTF-8,
    signs that group digits, runs of blanks as separators, or letters that are not ASCII below the
    names. Raises `ExchangeError` for a file that takes more memory than is free."""
    plain = mapping.separator is not None and not mapping.thousands
    if not plain or mapping.encoding or path.stat().st_size < LEAST_BYTES:
        return None
    data = read_bytes(path, ExchangeError, ROOM).rstrip(b"\r\n")
    if not data[data.rfind(b"\n") + 1 :].strip():
        return None
    try:
        head = data[:HEAD_BYTES].decode("utf-8-sig", "ignore").replace("\r\n", "\n").split("\n")
    except UnicodeDecodeError:
        return None
    start = _offset(data, mapping.first)
    if start is None or len(head) <= mapping.first + 1:
        return None
    stop, last = len(data), data.count(b"\n") + 1
    while mapping.last_row and last > mapping.last_row:
        stop, last = data.rfind(b"\n", 0, stop), last - 1
    body = memoryview(data)[start:stop]
    pieces = range(start, stop, HEAD_BYTES)
    if not all(data[k : min(k + HEAD_BYTES, stop)].isascii() for k in pieces) or b"\0" in data:
        return None
    if not data[:start].isascii() and not _is_utf_8(data[:start]):
        return None
    separator = mapping.separator or ""
    count, cut = last - mapping.first + 1, stop < len(data)
    return Body(body, mapping.first, count, cut, head, separator, mapping.decimal)


def _is_utf_8(data: bytes) -> bool:
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True


def _offset(data: bytes, line: int) -> int | None:
    """Where a line begins, from 1."""
    at = 0
    for _ in range(line - 1):
        at = data.find(b"\n", at) + 1
        if not at:
            return None
    return at


def parse_body(
    body: Body, width: int, numbers: Sequence[int], texts: Sequence[int]
) -> tuple[NDArray[np.float64], list[list[str]]] | None:
    """The columns of `numbers` (n, c) and those of `texts`, each by its index; None if a line is no
    row of so many cells, or a cell no number."""
    import pyarrow
    from pyarrow import csv

    kinds = {str(k): pyarrow.float64() for k in numbers} | {str(k): pyarrow.string() for k in texts}
    try:
        table = csv.read_csv(
            pyarrow.py_buffer(body.data),
            csv.ReadOptions(column_names=[str(k) for k in range(width)]),
            csv.ParseOptions(delimiter=body.separator, newlines_in_values=False),
            csv.ConvertOptions(
                column_types=kinds,
                include_columns=list(kinds),
                decimal_point=body.decimal,
                null_values=EMPTY,
                check_utf8=False,
            ),
        )
    except pyarrow.ArrowException:
        return None
    if table.num_rows != body.count:  # blank lines are passed over
        return None
    words = [[text or "" for text in table.column(str(k)).to_pylist()] for k in texts]
    values = np.empty((table.num_rows, len(numbers)), order="F")
    for at, k in enumerate(numbers):
        values[:, at] = table.column(str(k)).to_numpy()
        table = table.drop_columns(str(k))  # gives its memory back
    return values, words
