"""Which campaigns there are: one per seed, in rounds of 200 seeds."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.blind.outside import OUTSIDE
from benchmarks.blind.reality import REALITY
from tests.truth import PRESETS

FIRST_SEED = {"dev": 1000, "published": 5000}
"""Development looks at seeds 1000 to 1999 only; the published table is made from 5000 on."""

ROUND = 200  # seeds
DEV_ROUNDS = 5

EFFECTS = (
    "speed-fluctuation",
    "left-right-drift",
    "tyre-envelope",
    "small-scale-roughness",
    "progressive-tyre",
    "tyre-lift-off",
    "wheel-imbalance",
    "progressive-spring",
    "bump-stop",
    "asymmetric-damper",
    "digressive-damper",
    "dry-friction",
    "backlash",
    "mount-bushing",
    "anti-roll-bar",
    "corner-asymmetry",
    "driver-seat",
    "driver-rocking",
    "engine-vibration",
    "frame-twist",
    "longitudinal-pitch",
    "cornering-roll",
    "sensor-gain",
    "sensor-polarity",
    "sensor-skew",
    "sensor-clipping",
    "sensor-mount",
)
"""Ids of the library, in the order of the chain: an effect keeps its seeds for good."""

ALL_OR_NOTHING = ("sensor-polarity",)
"""Effects that cannot be weak."""

FIELD = ("speed-fluctuation", "tyre-lift-off", "dry-friction", "driver-seat")
"""What data from the field nearly always hold."""

ALSO_IN_THE_FIELD = (
    "left-right-drift",
    "progressive-spring",
    "asymmetric-damper",
    "digressive-damper",
    "bump-stop",
    "driver-rocking",
    "engine-vibration",
    "frame-twist",
)

KINDS = ("clear", "weak", "none", "two", "four", "outside", "without", "faint", *REALITY)
KINDS += ("everything",)
FIRST_SLOT = {"clear": 0, "weak": 30, "none": 60, "two": 70, "four": 80, "outside": 90}
FIRST_SLOT |= {"without": 100, "faint": 130}
FIRST_SLOT |= {kind: 160 + k for k, kind in enumerate(REALITY)}
FIRST_SLOT |= {"everything": 185}
COUNT = {"none": 10, "two": 10, "four": 7, "everything": 10}
NOTHING = 0.2
"""Share of the campaigns of the kind "everything" that hide nothing."""


@dataclass(frozen=True)
class Case:
    """One question to the program: a campaign and what is hidden in it.

    A "without" case shows the campaign of a "clear" one to a library that lacks its effect.
    """

    seed: int
    kind: str
    hidden: tuple[str, ...]
    preset: str
    campaign_seed: int

    @property
    def name(self) -> str:
        """Name of the result's file."""
        return self._named(self.seed, self.kind)

    @property
    def campaign(self) -> str:
        """Name of the campaign's folder."""
        kind = "clear" if self.kind == "without" else self.kind
        return self._named(self.campaign_seed, kind)

    def _named(self, seed: int, kind: str) -> str:
        return "-".join([str(seed), kind, "+".join(self.hidden) or "clean", self.preset])


def plan(first_seed: int, rounds: int, available: Collection[str]) -> Iterator[Case]:
    """All cases of some rounds; effects that are not `available` are left out.

    Doubles and fours are drawn from the effects available, so their seeds keep their meaning
    only as long as the library does; the name tells what is hidden.
    """
    for first in range(first_seed, first_seed + rounds * ROUND, ROUND):
        for kind in KINDS:
            for number, hidden in enumerate(_hidden(kind, first, available)):
                if kind in ("weak", "faint") and hidden[0] in ALL_OR_NOTHING:
                    continue
                if kind != "outside" and not set(hidden) <= set(available):
                    continue
                yield _case(first, kind, number, hidden)


def _case(first: int, kind: str, number: int, hidden: tuple[str, ...]) -> Case:
    seed = first + FIRST_SLOT[kind] + number
    presets = sorted(PRESETS)
    campaign_seed = first + number if kind == "without" else seed
    # Every effect meets every kind of vehicle in three rounds, and one each at every strength.
    turn = number + first // ROUND + {"weak": 1, "faint": 2}.get(kind, 0)
    turn += list(REALITY).index(kind) if kind in REALITY else 0
    return Case(seed, kind, hidden, presets[turn % len(presets)], campaign_seed)


def _hidden(kind: str, first: int, available: Collection[str]) -> list[tuple[str, ...]]:
    if kind in ("clear", "without"):
        return [(effect,) for effect in EFFECTS]
    if kind in ("weak", "faint"):
        return [(e,) for e in EFFECTS]
    if kind == "outside":
        return [(effect,) for effect in OUTSIDE]
    if kind == "none":
        return [()] * COUNT[kind]
    if kind in REALITY:
        rng = np.random.default_rng([first + FIRST_SLOT[kind], 3])
        return [tuple(str(name) for name in [rng.choice(REALITY[kind].hides)] if name)]
    draw = {"two": _two, "four": _four, "everything": _one_or_none}[kind]
    seeds = range(first + FIRST_SLOT[kind], first + FIRST_SLOT[kind] + COUNT[kind])
    return [draw(np.random.default_rng(seed), available) for seed in seeds]


def _one_or_none(rng: np.random.Generator, available: Collection[str]) -> tuple[str, ...]:
    name = str(rng.choice([e for e in EFFECTS if e in available]))
    return () if rng.random() < NOTHING else (name,)


def _two(rng: np.random.Generator, available: Collection[str]) -> tuple[str, ...]:
    return tuple([str(e) for e in rng.permutation(EFFECTS) if e in available][:2])


def _four(rng: np.random.Generator, available: Collection[str]) -> tuple[str, ...]:
    """The field's own four, or with one or two of the last three replaced."""
    replaced = int(rng.choice([0, 0, 1, 2]))
    others = [str(e) for e in rng.permutation(ALSO_IN_THE_FIELD) if e in available][:replaced]
    kept = sorted(rng.permutation(3)[: 3 - len(others)])
    return (FIELD[0], *(FIELD[1 + k] for k in kept), *others)
