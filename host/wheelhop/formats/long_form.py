"""Tables in long form: a row for each value, and a column that says whose it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from wheelhop.formats.groups import together
from wheelhop.formats.table import Table, plain_channel

FEWEST_EACH = 3
"""Rows that every channel has at least, on average: notes come once."""
INTERLEAVED = 0.5
"""Share of rows whose key is not that of the row before, above which channels take turns: the state
of a car, or its lap, lasts for many rows."""


def is_key(words: Sequence[str], columns: Sequence[NDArray[np.float64]]) -> bool:
    """Whether these words, one a row, say which channel the row is of: they take turns, or each
    has one block of rows and one of the `columns` of numbers begins again with every block."""
    names = set(words)
    if "" in names or len(names) < 2 or len(words) < FEWEST_EACH * len(names):
        return False
    changes = np.array([one != two for one, two in pairwise(words)])
    if changes.mean() > INTERLEAVED:
        return True
    blocks = int(changes.sum()) == len(names) - 1
    return blocks and any(bool((np.diff(values)[changes] < 0).all()) for values in columns)


def split(table: Table, words: Sequence[str]) -> list[Table]:
    """The channels of a table in long form, by the words of its rows: those with the same stamps
    together, each called by its word, and by its column where there are several."""
    keys = list(dict.fromkeys(words))
    rows_of: dict[str, list[int]] = {key: [] for key in keys}
    for row, word in enumerate(words):
        rows_of[word].append(row)
    found = []
    for key in keys:
        rows = rows_of[key]
        name = key_name(key)
        found.append(
            replace(
                table,
                channels=tuple(
                    plain_channel(channel_name(name, c.name, len(table.channels)), c.unit)
                    for c in table.channels
                ),
                values=table.values[rows],
                time_s=None if table.time_s is None else table.time_s[rows],
                lines=[table.lines[row] for row in rows],
                numbers=(),
                group=name,
                same_clock=True,
            )
        )
    return together(found)


def key_name(word: str) -> str:
    """A channel's name, from the word that says whose a row is."""
    return word.strip().rstrip(":").strip()


def channel_name(key: str, column: str, columns: int) -> str:
    """What a channel is called whose rows have so many columns of numbers."""
    return key if columns == 1 else f"{key}/{column}"
