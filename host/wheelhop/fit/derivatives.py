"""Derivatives by numbers that act one after the other in a run, from few simulations.

A coefficient of a spline moves the record while its B-spline lasts, and for as long as the vehicle
remembers. Numbers whose parts of the record do not overlap are moved together, and the change of
the record is cut into theirs (A. Curtis, M. Powell, J. Reid, On the estimation of sparse Jacobian
matrices, J. Inst. Math. Appl. 13 (1974) 117, section 2).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from wheelhop.fit.bench import Bench
from wheelhop.fit.parameters import Free
from wheelhop.simulate import Model

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Move:
    """A model with some numbers of one run moved: which of those asked for, in the order in which
    they act, and when their parts of the record begin, s."""

    model: Model
    members: tuple[int, ...]
    begins_s: tuple[float, ...]

    def parts(self, bench: Bench, change: Array) -> Iterator[tuple[int, Array]]:
        """Each member with the in-band coefficients (size,) of its part of a change of the record
        (n, channels)."""
        cuts = np.searchsorted(bench.run.time_s, [*self.begins_s[1:], inf])
        for member, first, last in zip(self.members, [0, *cuts[:-1]], cuts, strict=True):
            part = np.zeros_like(change)
            part[first:last] = change[first:last]
            yield member, bench.coefficients(part)


def moves(
    bench: Bench, model: Model, free: Sequence[Free], step: Callable[[Free], float]
) -> list[Move]:
    """Models in which each of the numbers that a run leaves free has moved by its step."""
    sets = list[list[int]]()
    ends = list[float]()
    for i in sorted(range(len(free)), key=lambda i: free[i].span_s):
        begin, end = free[i].span_s
        place = next((k for k, last in enumerate(ends) if last <= begin), None)
        if place is None:
            sets.append([i])
            ends.append(end + bench.memory_s)
        else:
            sets[place].append(i)
            ends[place] = end + bench.memory_s
    still = {f.name: model.runs.get(bench.run.id, {}).get(f.name, f.mean) for f in free}
    found = []
    for members in sets:
        moved = still | {free[i].name: still[free[i].name] + step(free[i]) for i in members}
        begins = tuple(free[i].span_s[0] for i in members)
        found.append(Move(model.with_run(bench.run.id, moved), tuple(members), begins))
    return found
