"""Curves that people measure, read from CSV: columns named by quantity and unit."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign.types import CampaignError
from wheelhop.files import read_text

Array = NDArray[np.float64]

LENGTH = {"mm": 1e-3, "m": 1.0}
FORCE = {"N": 1.0, "kN": 1e3}
SPEED = {"mm_s": 1e-3, "m_s": 1.0}
FEWEST = 5
"""Points of a curve: its slope, how that changes, and something left to tell the scatter from."""


def read_curve(
    file: Path, units: Mapping[str, Mapping[str, float]], fewest: int = FEWEST
) -> dict[str, Array]:
    """Columns (n,) of a CSV file in SI, by the quantities of `units`, each of which gives the units
    that may stand at the end of a column's name; "" is no unit.

    Raises CampaignError for a quantity that is missing, twice there or in another unit, columns
    that are something else, fewer than `fewest` points, and cells that are not finite numbers.
    """
    rows, names = _rows(file), read_names(file)
    known = {
        quantity if not unit else f"{quantity}_{unit}": (quantity, size)
        for quantity, sizes in units.items()
        for unit, size in sizes.items()
    }
    wanted = ", ".join(_example(quantity, sizes) for quantity, sizes in units.items())
    for name in names:
        if name not in known:
            raise CampaignError(f'{file}: line 1: column "{name}" is not known; it takes {wanted}')
    quantities = [known[name][0] for name in names]
    if sorted(quantities) != sorted(units):
        raise CampaignError(f"{file}: line 1: it takes one column each of {wanted}")
    table = np.array([_row(file, line, row, names) for line, row in enumerate(rows[1:], start=2)])
    if len(table) < fewest:
        raise CampaignError(f"{file}: {len(table)} points are too few; give {fewest} or more")
    return {known[name][0]: known[name][1] * table[:, i] for i, name in enumerate(names)}


def read_names(file: Path) -> list[str]:
    """The names of a CSV file's columns; raises CampaignError for one that cannot be read."""
    return [name.strip() for name in _rows(file)[0]]


def _rows(file: Path) -> list[list[str]]:
    return list(csv.reader(read_text(file, CampaignError).rstrip().split("\n")))


def _example(quantity: str, sizes: Mapping[str, float]) -> str:
    names = [quantity if not unit else f"{quantity}_{unit}" for unit in sizes]
    return " or ".join(names)


def _row(file: Path, line: int, row: list[str], names: list[str]) -> list[float]:
    if len(row) != len(names):
        raise CampaignError(
            f"{file}: line {line}: {len(row)} values under {len(names)} columns; numbers have a"
            " point, and commas between them"
        )
    values = []
    for name, cell in zip(names, row, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = float("nan")
        if not isfinite(value):
            raise CampaignError(f'{file}: line {line}: {name}: "{cell[:20]}" is not a number')
        values.append(value)
    return values
