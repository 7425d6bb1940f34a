"""Real modes from Nastran's print-out (.f06): its tables of eigenvalues and of eigenvectors.

The tables of MSC and NX Nastran are read, of one subcase, as solution 103 prints them for
DISP = ALL, or a set that holds the corners.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import read_text
from wheelhop.frame.error import FrameError

Array = NDArray[np.float64]
VALUES = "R E A L   E I G E N V A L U E S"
VECTOR = re.compile(r"R E A L   E I G E N V E C T O R   N O \.\s+(\d+)")
GRID_POINT = "G"


@dataclass(frozen=True, eq=False)
class PrintedModes:
    """Frequencies (k,), Hz, generalised masses (k,), in the model's unit of mass, and vertical
    motions T3 (points, k)."""

    frequency_hz: Array
    mass: Array
    height: Array


def read_f06(file: Path, points: Sequence[str]) -> PrintedModes:
    """The modes at some grid points.

    Raises `FrameError`, one line, for a file without these tables, a point that is not printed,
    more than one subcase, and numbers that are none.
    """
    values: dict[int, tuple[float, float]] = {}
    heights: dict[int, dict[str, float]] = {}
    table, mode = "", 0
    for number, line in enumerate(read_text(file, FrameError).splitlines(), start=1):
        vector = VECTOR.search(line)
        words = line.split()
        if vector:
            table, mode = "vector", int(vector[1])
            heights.setdefault(mode, {})
        elif VALUES in line:
            table = "values"
        elif line.startswith("1") or "***" in line or "* * *" in line:
            table = ""  # a new page, or a message
        elif table == "values" and len(words) == 7 and words[0].isdigit():
            cycles, mass = (_number(words[i], file, number) for i in (4, 5))
            if values.setdefault(int(words[0]), (cycles, mass)) != (cycles, mass):
                raise FrameError(f"{file}: line {number}: another subcase: print one alone")
        elif table == "vector" and words[1:2] == [GRID_POINT] and words[0] in points:
            if len(words) != 8:
                raise FrameError(f"{file}: line {number}: six motions of point {words[0]} expected")
            if words[0] in heights[mode]:
                raise FrameError(
                    f"{file}: line {number}: point {words[0]} has mode {mode} twice: print one"
                    " subcase alone"
                )
            heights[mode][words[0]] = _number(words[4], file, number)
    return _checked(file, points, values, heights)


def _checked(
    file: Path,
    points: Sequence[str],
    values: dict[int, tuple[float, float]],
    heights: dict[int, dict[str, float]],
) -> PrintedModes:
    if not values or not heights:
        missing = "eigenvalues" if not values else "eigenvectors"
        raise FrameError(f"{file}: prints no table of real {missing}: is it of solution 103?")
    for mode in values:
        absent = [point for point in points if point not in heights.get(mode, {})]
        if absent:
            raise FrameError(
                f"{file}: mode {mode} is not printed at point {absent[0]}: DISP = ALL prints all"
            )
        if values[mode][1] <= 0.0:
            raise FrameError(f"{file}: mode {mode} has a generalised mass of {values[mode][1]:g}")
    modes = sorted(values)
    return PrintedModes(
        np.array([values[mode][0] for mode in modes]),
        np.array([values[mode][1] for mode in modes]),
        np.array([[heights[mode][point] for mode in modes] for point in points]),
    )


def _number(word: str, file: Path, line: int) -> float:
    try:
        value = float(word)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise FrameError(f"{file}: line {line}: '{word}' is not a number")
    return value
