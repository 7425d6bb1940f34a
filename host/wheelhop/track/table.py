"""What is done at every point of a wheel's path, compiled: where it touches, and what its table
says of a place."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Function = TypeVar("Function", bound=Callable[..., Any])


def _compiled(function: Function) -> Function:
    return cast(Function, numba.njit(cache=True, nogil=True, error_model="numpy")(function))


@_compiled
def highest(z: Array, disc: Array, n: int) -> NDArray[np.intp]:
    """For each of n windows of z, one beginning at every point, where z + disc is largest.

    A disc is concave: the place that a wheel touches never moves back while the wheel rolls on. So
    the windows halfway between two known ones need to be searched between their two places alone.
    """
    place = np.zeros(n, dtype=np.intp)  # in z
    stride = 1
    while stride < n:
        stride *= 2
    while stride >= 1:
        for i in range(0 if stride >= n else stride, n, 2 * stride):
            first = max(i, place[i - stride]) if i > 0 else 0
            last = i + len(disc) - 1
            if i > 0 and i + stride < n:
                last = min(last, place[i + stride])
            best = first
            most = z[first] + disc[first - i]
            for k in range(first + 1, last + 1):
                here = z[k] + disc[k - i]
                if here > most:
                    best, most = k, here
            place[i] = best
        stride //= 2
    for i in range(n):
        place[i] -= i
    return place


@_compiled
def located(
    place: Array, cells: int, periodic: bool, split_cell: NDArray[np.intp], split_at: Array
) -> tuple[NDArray[np.intp], Array]:
    """Row of the polynomial that holds at each place, counted in cells from the table's origin, and
    where in its cell that is, 0 to 1; rows right of a split stand behind the cells."""
    row, t = np.empty(len(place), dtype=np.intp), np.empty(len(place))
    for i in range(len(place)):
        p = place[i]
        if periodic:
            p -= np.floor(p / cells) * cells
        else:
            p = min(max(p, 0.0), float(cells))
        cell = max(min(int(p), cells - 1), 0)  # a place that is no number has a row, too
        row[i], t[i] = cell, p - cell
        if len(split_cell):
            nearest = np.searchsorted(split_cell, cell)
            here = nearest < len(split_cell) and split_cell[nearest] == cell
            if here and t[i] > split_at[nearest]:
                row[i] = cells + nearest
    return row, t


@_compiled
def looked_up(cubic: Array, row: NDArray[np.intp], t: Array) -> tuple[Array, Array, Array]:
    """Values of cubics (rows, 4), the constant first, at t of a row each; their derivatives there,
    and their integrals from 0 to t."""
    value, slope, area = np.empty(len(t)), np.empty(len(t)), np.empty(len(t))
    for i in range(len(t)):
        c0, c1, c2, c3 = cubic[row[i]]
        value[i] = ((c3 * t[i] + c2) * t[i] + c1) * t[i] + c0
        slope[i] = (3.0 * c3 * t[i] + 2.0 * c2) * t[i] + c1
        area[i] = (((c3 / 4.0 * t[i] + c2 / 3.0) * t[i] + c1 / 2.0) * t[i] + c0) * t[i]
    return value, slope, area


@_compiled
def periodic_cubic(value: Array, slope: Array, place: Array) -> tuple[Array, Array]:
    """Cubic Hermite interpolation of a periodic function that is known at equal distances, with its
    slope per distance, at places counted in them; and the slope there (C. de Boor, A Practical
    Guide to Splines, 1978, chapter IV)."""
    n = len(value)
    at, rate = np.empty(len(place)), np.empty(len(place))
    for i in range(len(place)):
        below = np.floor(place[i])
        t = place[i] - below
        k = int(below) % n
        after = (k + 1) % n
        rise = value[after] - value[k]
        c2 = 3.0 * rise - 2.0 * slope[k] - slope[after]
        c3 = slope[k] + slope[after] - 2.0 * rise
        at[i] = ((c3 * t + c2) * t + slope[k]) * t + value[k]
        rate[i] = (3.0 * c3 * t + 2.0 * c2) * t + slope[k]
    return at, rate
