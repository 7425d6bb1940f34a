"""Which channel of a beam session is inverted, dead, or exchanged with another one.

At each frequency the beam moves in one shape with signs; every fault changes the expected shape in
its own way. The fault that explains the measured one best is taken, if it is much better than none,
and the search goes on, since there may be two.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

GAIN_TOLERANCE = 0.10  # of a sensor whose gain is not known better than its data sheet
SHAPE_TOLERANCE = 0.05  # of the largest amplitude: positions, dimensions, damping
DEAD_TOLERANCE = 0.02  # of the largest amplitude: what a dead channel may show
CONVINCING = 25.0  # fall of χ² that one fault must bring: five standard deviations
DISTINCT = 9.0  # what is worse by this is no rival
MOST_FAULTS = 3
ACCEPTABLE = 4.0  # χ² per value, above which the beam is not the one described

Real = NDArray[np.float64]


@dataclass(frozen=True)
class Fault:
    """`kind` is "inverted", "dead" or "swapped"; `channels` are one, or the two that are exchanged.

    `rivals` are other channels (or pairs) of which the same could be said; `strength` is by how
    much χ² falls.
    """

    kind: str
    channels: tuple[str, ...]
    strength: float
    rivals: tuple[tuple[str, ...], ...] = ()

    def __str__(self) -> str:
        who = " or ".join(" and ".join(names) for names in (self.channels, *self.rivals))
        verb = "are" if len(self.channels) > 1 else "is"
        return f"{who} {verb} {self.kind}"


@dataclass(frozen=True)
class Expected:
    """What each channel (c,) is believed to read: the sensor at position `at`, times `sign`, or
    nothing where it is not `alive`."""

    at: NDArray[np.int64]
    sign: Real
    alive: NDArray[np.bool_]

    @classmethod
    def healthy(cls, channels: int) -> "Expected":
        """Every channel its own sensor."""
        return cls(np.arange(channels), np.ones(channels), np.ones(channels, dtype=bool))

    def of(self, shape: Real) -> Real:
        """The beam's shape (f, positions) as the channels read it, (f, c)."""
        return np.where(self.alive, shape[:, self.at] * self.sign, 0.0)

    def with_fault(self, kind: str, which: tuple[int, ...]) -> "Expected":
        """What one more fault makes of it."""
        at, sign, alive = self.at.copy(), self.sign.copy(), self.alive.copy()
        if kind == "inverted":
            sign[which[0]] *= -1
        elif kind == "dead":
            alive[which[0]] = False
        else:
            at[list(which)] = at[list(which[::-1])]
        return Expected(at, sign, alive)


def find_faults(
    measured: Real, shape: Real, uncertainty: Real, names: tuple[str, ...]
) -> tuple[tuple[Fault, ...], Expected, float]:
    """Faults, what they leave to expect, and its χ² per value.

    `measured` and `shape` are signed amplitudes (f, c), each up to a factor for every frequency;
    `uncertainty` (f, c) belongs to `measured`.
    """
    expected = Expected.healthy(len(names))
    best = misfit(measured, expected, shape, uncertainty)
    faults: list[Fault] = []
    while len(faults) < min(MOST_FAULTS, len(names) - 1):
        tried = []
        for kind, which in _candidates(expected.alive):
            changed = expected.with_fault(kind, which)
            tried.append((misfit(measured, changed, shape, uncertainty), kind, which, changed))
        tried.sort(key=lambda each: each[0])
        lowest, kind, which, changed = tried[0]
        if best - lowest < CONVINCING:
            break
        rivals = tuple(
            tuple(names[i] for i in other)
            for chi, what, other, _ in tried[1:]
            if chi - lowest < DISTINCT and what == kind
        )
        faults.append(Fault(kind, tuple(names[i] for i in which), best - lowest, rivals))
        best, expected = lowest, changed
    return tuple(faults), expected, best / measured.size


def indistinct_pairs(
    shape: Real, uncertainty: Real, names: tuple[str, ...]
) -> tuple[tuple[str, str], ...]:
    """Pairs whose exchange these frequencies would not show."""
    healthy = Expected.healthy(len(names))
    return tuple(
        (names[i], names[j])
        for i, j in combinations(range(len(names)), 2)
        if misfit(healthy.with_fault("swapped", (i, j)).of(shape), healthy, shape, uncertainty)
        < CONVINCING + DISTINCT
    )


def misfit(measured: Real, expected: Expected, shape: Real, uncertainty: Real) -> float:
    """χ² of the measured amplitudes (f, c), each frequency's factor chosen best."""
    total = 0.0
    for got, want, noise in zip(measured, expected.of(shape), uncertainty, strict=True):
        got, want = got / np.abs(got).max(), want / np.abs(want).max()
        tolerance = np.where(expected.alive, SHAPE_TOLERANCE, DEAD_TOLERANCE)
        variance = tolerance**2 + (GAIN_TOLERANCE * want) ** 2 + noise**2
        factor = np.sum(got * want / variance) / np.sum(want**2 / variance)
        total += float(np.sum((got - factor * want) ** 2 / variance))
    return total


def _candidates(alive: NDArray[np.bool_]) -> list[tuple[str, tuple[int, ...]]]:
    living = [int(i) for i in np.flatnonzero(alive)]
    single: list[tuple[str, tuple[int, ...]]] = [
        (kind, (i,)) for kind in ("inverted", "dead") for i in living
    ]
    return single + [("swapped", pair) for pair in combinations(living, 2)]
