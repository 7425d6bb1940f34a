"""The search: many settings, of which those are kept that none is better than in everything."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from wheelhop.files import require
from wheelhop.tune.objectives import Judge
from wheelhop.tune.variables import Freedom

Array = NDArray[np.float64]

POPULATION = 40
LEVELS = 7
"""Each variable alone is tried at so many places from one bound to the other."""
DAMPERS = 6
"""Dampers alone are tried at two to this power of settings, which fill their bounds evenly."""
FRONT = 9
"""So many settings of the front are looked at further."""


@dataclass(frozen=True, eq=False)
class Tried:
    """Settings as shares (n, d) of the bounds, and their objectives (n, k)."""

    shares: Array
    scores: Array

    def joined(self, other: Tried) -> Tried:
        """Both."""
        return Tried(np.vstack([self.shares, other.shares]), np.vstack([self.scores, other.scores]))

    @property
    def front(self) -> NDArray[np.int64]:
        """Those that no other is as good as in everything and better in something: V. Pareto's."""
        s = self.scores
        kept: list[int] = []
        for i in np.lexsort(s.T[::-1]):
            if np.isfinite(s[i]).all() and not (s[kept] <= s[i]).all(axis=1).any():
                kept.append(int(i))
        return np.array(kept, dtype=np.int64)


class Search:
    """Rides settings of a car that is free in some numbers, by shares of their bounds."""

    def __init__(self, judge: Judge, freedom: Freedom) -> None:
        self.judge, self.freedom = judge, freedom
        self.now = np.array(freedom.now)
        require("pymoo", "the search for a better setting", "tune")

    def try_out(self, shares: Array, varied: Sequence[int] | None = None) -> Tried:
        """Ride settings (n, d); the `varied` variables alone, if given, the others as they are."""
        keys = [v.key for v in self.freedom.variables]
        kept = set(keys if varied is None else [keys[i] for i in varied])
        settings = [
            {key: value for key, value in self.freedom.changes(row).items() if key in kept}
            for row in shares
        ]
        return Tried(shares, self.judge.score(settings))

    def alone(self) -> Tried:
        """Each variable at `LEVELS` places, the others as they are: (d · LEVELS, d)."""
        found = []
        for i in range(len(self.now)):
            rows = np.tile(self.now, (LEVELS, 1))
            rows[:, i] = np.linspace(0.0, 1.0, LEVELS)
            found.append(self.try_out(rows, [i]))
        return reduce(Tried.joined, found)

    def dampers(self) -> Tried | None:
        """Settings of the dampers, the others as they are; None where none is varied."""
        free = [i for i, v in enumerate(self.freedom.variables) if v.is_damper]
        if not free:
            return None
        rows = np.tile(self.now, (2**DAMPERS, 1))
        rows[:, free] = qmc.Sobol(len(free), seed=0).random_base2(DAMPERS)
        return self.try_out(rows, free)

    def known(self, *tried: Tried | None) -> Tried:
        """What the search may begin with: of these what lies within the bounds, which is all or,
        where the car itself lies outside of them, nothing but the setting nearest to it."""
        if self.freedom.holds_now:
            return reduce(Tried.joined, [one for one in tried if one is not None])
        return self.try_out(self.now[None, :])

    def whole(self, known: Tried, settings: int, progress: Callable[[str], None]) -> Tried:
        """All variables together, by NSGA-II (K. Deb et al., IEEE Trans. Evolutionary Computation 6
        (2002) 182), begun at what is known and spread over the bounds; `settings` of them are
        ridden."""
        from pymoo.algorithms.moo.nsga2 import NSGA2
        from pymoo.core.problem import Problem

        best = known.shares[known.front][:POPULATION]
        spread = qmc.LatinHypercube(len(self.now), seed=0).random(POPULATION)
        begin = np.vstack([self.now, best, spread])[:POPULATION]
        algorithm = NSGA2(pop_size=POPULATION, sampling=begin)
        problem = Problem(n_var=len(self.now), n_obj=known.scores.shape[1], xl=0.0, xu=1.0)
        algorithm.setup(problem, termination=("n_gen", settings // POPULATION + 1), seed=0)
        tried = known
        for _ in range(max(settings // POPULATION, 1)):
            asked = algorithm.ask()
            new = self.try_out(asked.get("X"))
            asked.set("F", np.where(np.isfinite(new.scores), new.scores, FAR))
            algorithm.tell(infills=asked)
            tried = tried.joined(new)
            progress(f"{len(tried.scores)} settings tried")
        return tried


FAR = 1e9
"""The objectives of a setting whose vehicle runs away: worse than any."""


def compromise(scores: Array, now: Array) -> int:
    """The setting whose worst objective, over what it is now, is least: it gains in all, if any
    does."""
    return int(np.argmin((scores / now).max(axis=1)))


def spread_out(scores: Array, kept: list[int], count: int) -> list[int]:
    """So many of these (n, k), the `kept` among them: the best in each objective, then one after
    the other the one farthest from those taken, objectives over their range."""
    taken = list(dict.fromkeys([*kept, *np.argmin(scores, axis=0).tolist()]))
    width = np.ptp(scores, axis=0)
    scaled = scores / np.where(width > 0.0, width, 1.0)
    while len(taken) < min(count, len(scores)):
        away = np.linalg.norm(scaled[:, None] - scaled[None, taken], axis=2).min(axis=1)
        if away.max() <= 0.0:
            break
        taken.append(int(away.argmax()))
    return taken
