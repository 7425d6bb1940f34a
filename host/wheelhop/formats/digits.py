"""Which mark is the decimal sign and which one groups thousands, told from the numbers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

GROUPS = " '’\u00a0\u202f"
"""Marks that can only group thousands."""
BARE = re.compile(r"[+-]?(?:\d+|inf(?:inity)?)(?:[eE][+-]?\d+)?", re.IGNORECASE)
MARKED = re.compile(rf"[+-]?(?P<digits>[\d.,{GROUPS}]*\d[\d.,{GROUPS}]*)(?P<power>[eE][+-]?\d+)?")


@dataclass(frozen=True)
class Digits:
    """How the numbers of a file are written; `asked` says why that cannot be told, "" if it can."""

    decimal: str = "."
    thousands: str = ""
    asked: str = ""


def is_numeric(cell: str) -> bool:
    """Whether a cell looks like a number, with whatever marks in it."""
    cell = cell.strip()
    return bool(BARE.fullmatch(cell) or _reading(cell))


def tell(columns: Iterable[Sequence[str]], separator: str | None) -> Digits:
    """The marks of numbers, from all the columns; each column may settle its own.

    A column whose every number could be either ("1,234") is settled by the others only if they
    use the same mark, in one of the two ways, for certain.
    """
    decimals: set[str] = set()
    groups: set[str] = set()
    open_columns: list[tuple[str, str]] = []
    for column in columns:
        found = {reading for cell in column if (reading := _reading(cell.strip()))}
        sure_decimals = {mark for mark, group, sure in found if sure and mark}
        sure_groups = {group for mark, group, sure in found if sure and group}
        decimals |= sure_decimals
        groups |= sure_groups
        unsure = sorted({mark for mark, _, sure in found if not sure})
        for mark in unsure:
            if mark not in sure_decimals | sure_groups:
                sample = next(c for c in column if _reading(c.strip()) == (mark, "", False))
                open_columns.append((mark, sample.strip()))
    if decimals & groups or len(decimals) > 1 or len(groups) > 1:
        return Digits(asked="some columns have decimal points, others decimal commas")
    for mark, sample in open_columns:
        other = "," if mark == "." else "."
        natural = mark == "." and separator == ","  # who writes decimal commas does not do that
        if mark in decimals | groups or (natural and other not in decimals | groups):
            continue
        return Digits(asked=f"'{sample}' may be {sample.replace(mark, '.')} or a thousand as much")
    marks = decimals or {mark for mark, _ in open_columns} - groups
    return Digits(next(iter(marks), "," if "." in groups else "."), next(iter(groups), ""))


def _reading(cell: str) -> tuple[str, str, bool] | None:
    """The decimal sign and the mark of thousands in a cell, and whether no other reading is
    possible; None for what holds no mark, or is no number."""
    match = MARKED.fullmatch(cell)
    if match is None or cell.isdigit():
        return None
    digits, power = match["digits"], match["power"] or ""
    marks = [char for char in digits if not char.isdigit()]
    kinds = list(dict.fromkeys(marks))
    if not marks or len(kinds) > 2:
        return None
    if len(kinds) == 2:
        group, mark = kinds
        if marks.count(mark) != 1 or mark in GROUPS or not _grouped(digits.split(mark)[0], group):
            return None
        return mark, group, True
    mark = kinds[0]
    grouped = _grouped(digits, mark) and not power
    if mark in GROUPS or len(marks) > 1:
        return ("", mark, True) if grouped else None
    return (mark, "", not grouped or digits.startswith("0"))


def _grouped(digits: str, mark: str) -> bool:
    first, *rest = digits.split(mark)
    return 1 <= len(first) <= 3 and all(len(part) == 3 for part in rest) and bool(rest)
