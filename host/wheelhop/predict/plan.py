"""Which runs to drive: of all that could be made, the few that together would tell most.

Of a set of runs with the information matrix M (its blocks: g the vehicle's numbers, a the effects'
amplitudes) and the prior precision W of the numbers, the plan counts in nats

- what it tells of the numbers: ½ ln det(W + M_gg) − ½ ln det W (D-optimality; V. Fedorov, Theory of
  Optimal Experiments, Academic Press 1972, section 2.1);
- of every effect's strength, believed to be of its scale: ½ ln(1 + S_ii − S_iJ (1 + S_JJ)⁻¹ S_Ji),
  S = M_aa − M_ag (W + M_gg)⁻¹ M_ga, where J are the amplitudes of the rival that leaves least of
  it; the mean over the effect's forms.

Runs are chosen one by one, each time the one that adds most. The sum is nearly submodular: one run
less is gained by a run that comes later, and choosing so is within 1 − 1/e of the best set if it is
so exactly (G. Nemhauser, L. Wolsey, M. Fisher, Math. Programming 14 (1978) 265).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, log
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.diagnose.score import SIGNIFICANT
from wheelhop.diagnose.verdict.ranking import AMBIGUOUS_DEG
from wheelhop.effects import Switch
from wheelhop.predict.drives import VALIDATE_EVERY, Drive
from wheelhop.predict.foresee import Foreseen

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]


class Worth(NamedTuple):
    """What runs tell, in nats: of the vehicle's numbers, and of the effects' strengths."""

    numbers: float
    effects: float

    @property
    def total(self) -> float:
        """Of both."""
        return self.numbers + self.effects


@dataclass(frozen=True)
class Told:
    """What the advised runs tell of an effect in its first form, as `wheelhop simulate` makes it.

    The least strength, relative to `amplitudes`, its scale, at which they would show it, and at
    which they would show that it is not the `rival`, the effect most like it; the angle between
    the records of the two, 0 to 90 degrees.
    """

    effect: str
    form: str
    amplitudes: dict[str, float]
    shown_from: float
    told_from: float
    rival: str
    angle_deg: float


@dataclass(frozen=True, eq=False)
class Plan:
    """The runs to drive, the most telling first: `chosen` are places in `foreseen.drives`, and
    `after` what the first one, two, … of them tell together."""

    foreseen: Foreseen
    chosen: tuple[int, ...]
    after: tuple[Worth, ...]

    @property
    def vehicle_name(self) -> str:
        """Of the vehicle the plan is made for."""
        return self.foreseen.vehicle_name

    @property
    def drives(self) -> tuple[Drive, ...]:
        """The runs to drive, in order; every third is to validate."""
        return tuple(self.foreseen.drives[i] for i in self.chosen)

    @property
    def roles(self) -> tuple[str, ...]:
        """Of the drives: "fit", and every third "validate"."""
        return tuple(
            "validate" if i % VALIDATE_EVERY == VALIDATE_EVERY - 1 else "fit"
            for i in range(len(self.chosen))
        )

    @cached_property
    def alone(self) -> tuple[Worth, ...]:
        """What every run that could be driven tells by itself."""
        return tuple(worth(self.foreseen, [i]) for i in range(len(self.foreseen.drives)))

    @cached_property
    def uncertainty(self) -> dict[str, tuple[float, float]]:
        """One standard deviation of each of the vehicle's numbers, in its unit: as believed, and
        after the runs to drive."""
        matrix = _numbers(self.foreseen, _sum(self.foreseen, self.chosen))
        after = np.sqrt(np.diag(np.linalg.inv(matrix)))
        return {
            f.name: (f.sigma, float(f.scale * sigma))
            for f, sigma in zip(self.foreseen.numbers, after, strict=True)
        }

    @cached_property
    def told(self) -> tuple[Told, ...]:
        """What the runs to drive tell of each effect, in the library's order."""
        return told(self.foreseen, self.chosen)

    @property
    def confused(self) -> tuple[tuple[str, str, float], ...]:
        """Pairs of effects the runs would hardly tell apart, with the angle, nearest first."""
        pairs = {
            (min(t.effect, t.rival), max(t.effect, t.rival)): t.angle_deg
            for t in self.told
            if t.angle_deg < AMBIGUOUS_DEG
        }
        return tuple(sorted(((*pair, a) for pair, a in pairs.items()), key=lambda p: p[2]))

    def to_dataframe(self) -> DataFrame:
        """All runs that could be driven.

        Returns
        -------
        DataFrame
            Those to drive first and in order (`rank`; NaN for the others), then by what they tell
            alone; speeds in km/h where the name says so, else SI.
        """
        import pandas

        rank = {place: n for n, place in enumerate(self.chosen, start=1)}
        rows: list[dict[str, Any]] = []
        for i, drive in enumerate(self.foreseen.drives):
            rows.append(
                {
                    "run": drive.id,
                    "speed_kmph": drive.speed_kmph,
                    "rank": rank.get(i, np.nan),
                    "numbers_nats": self.alone[i].numbers,
                    "effects_nats": self.alone[i].effects,
                    "alone_nats": self.alone[i].total,
                }
            )
        table = pandas.DataFrame(rows).sort_values(["rank", "alone_nats"], ascending=[True, False])
        return table.set_index("run")


def choose(foreseen: Foreseen, runs: int) -> Plan:
    """The runs to drive, so many of them, greedily; raises what `check_runs` does."""
    count = len(foreseen.drives)
    check_runs(runs, count)
    chosen, after = list[int](), list[Worth]()
    while len(chosen) < runs:
        left = [i for i in range(count) if i not in chosen]
        worths = [worth(foreseen, [*chosen, i]) for i in left]
        best = int(np.argmax([one.total for one in worths]))
        chosen.append(left[best])
        after.append(worths[best])
    return Plan(foreseen, tuple(chosen), tuple(after))


def check_runs(runs: int, count: int) -> None:
    """Raise CampaignError for fewer runs than one, or more than could be driven."""
    if not 1 <= runs <= count:
        raise CampaignError(
            f"{runs} runs: there are {count} combinations of track and speed to choose from; ask"
            f" for 1 to {count}, or give more tracks or speeds"
        )


def worth(foreseen: Foreseen, chosen: Sequence[int]) -> Worth:
    """What some of the runs tell together."""
    total = _sum(foreseen, chosen)
    matrix = _numbers(foreseen, total)
    before = _numbers(foreseen, np.zeros_like(total))
    numbers = np.linalg.slogdet(matrix)[1] - np.linalg.slogdet(before)[1]
    effects = 0.0
    if foreseen.variants:
        left = np.log1p(_Strengths.of(foreseen, total).beside_rivals.min(axis=1))
        counts = Counter(variant.effect.id for variant in foreseen.variants)
        effects = sum(
            float(one) / counts[variant.effect.id]
            for one, variant in zip(left, foreseen.variants, strict=True)
        )
    return Worth(0.5 * float(numbers), 0.5 * effects)


def told(foreseen: Foreseen, chosen: Sequence[int]) -> tuple[Told, ...]:
    """What some of the runs tell of each effect."""
    strengths = _Strengths.of(foreseen, _sum(foreseen, chosen))
    names = [variant.effect.id for variant in foreseen.variants]
    return tuple(
        _told(foreseen, strengths, names.index(name), len(chosen)) for name in foreseen.effects
    )


TINY = 1e-6
"""Precision of a number nothing is believed of; it keeps the matrix regular."""


def _sum(foreseen: Foreseen, chosen: Sequence[int]) -> Array:
    return np.asarray(foreseen.information[list(chosen)].sum(axis=0))


def _numbers(foreseen: Foreseen, total: Array) -> Array:
    """Precision (g, g) of the vehicle's numbers where no effect is missing."""
    g = len(foreseen.numbers)
    return np.asarray(total[:g, :g] + foreseen.prior + TINY * np.eye(g))


@dataclass(frozen=True, eq=False)
class _Strengths:
    """What runs tell of the v variants at once: `matrix` (a, a), the information on their
    amplitudes per scale, the vehicle's numbers eliminated; `size` (v,) of it along each variant
    with all its amplitudes alike; `across` (v, a), what that has in common with every amplitude."""

    foreseen: Foreseen
    matrix: Array
    size: Array
    across: Array

    @classmethod
    def of(cls, foreseen: Foreseen, total: Array) -> _Strengths:
        g = len(foreseen.numbers)
        back = np.linalg.solve(_numbers(foreseen, total), total[:g, g:])
        matrix = np.asarray(total[g:, g:] - total[g:, :g] @ back)
        across = np.stack([matrix[place].sum(axis=0) for place in foreseen.places])
        size = np.array(
            [row[place].sum() for row, place in zip(across, foreseen.places, strict=True)]
        )
        return cls(foreseen, matrix, np.maximum(size, 0.0), across)

    @cached_property
    def beside_rivals(self) -> Array:
        """What is left (v, v) of each variant's information where another's amplitudes are free as
        well; where that is of the same effect, all of it."""
        taken = self._shared(1.0)
        names = np.array([variant.effect.id for variant in self.foreseen.variants])
        taken[names[:, None] == names[None, :]] = 0.0
        return np.asarray(np.maximum(self.size[:, None] - taken, 0.0))

    def angle_deg(self, variant: int, rival: int) -> float:
        """Between what a variant does to the records and the nearest a rival can do to them."""
        if self.size[variant] <= 0.0:
            return 90.0
        common = self._shared(RIDGE)[variant, rival] / self.size[variant]
        return float(np.degrees(np.arccos(np.sqrt(np.clip(common, 0.0, 1.0)))))

    def _shared(self, prior: float) -> Array:
        """S_iJ (p + S_JJ)⁻¹ S_Ji for all variants i and J, (v, v)."""
        found = np.empty((len(self.size), len(self.size)))
        for j, place in enumerate(self.foreseen.places):
            block = self.matrix[place, place]
            part = self.across[:, place]
            inner = block + prior * np.eye(len(block))
            found[:, j] = (part * np.linalg.solve(inner, part.T).T).sum(axis=1)
        return found


RIDGE = 1e-6
"""A rival's amplitude is free, but not without any limit."""


def _told(foreseen: Foreseen, strengths: _Strengths, i: int, runs: int) -> Told:
    variant, left = foreseen.variants[i], strengths.beside_rivals[i]
    numbers = sum(not isinstance(p, Switch) for p in variant.amplitudes) + len(variant.shapes)
    # As the diagnosis asks: worth its parameters' price, and on a third of the runs not by chance.
    by_chance = 2.0 * log(len(foreseen.effects) / SIGNIFICANT) * (VALIDATE_EVERY - 1)
    needed = max(numbers * log(foreseen.size * runs), by_chance)
    rival = int(np.argmin(left))
    other = foreseen.variants[rival].effect.id
    alone = other == variant.effect.id
    return Told(
        variant.effect.id,
        variant.choice,
        {p.name: p.scale for p in variant.amplitudes},
        _least(needed, float(strengths.size[i])),
        _least(needed, float(left[rival])),
        "" if alone else other,
        90.0 if alone else strengths.angle_deg(i, rival),
    )


def _least(needed: float, information: float) -> float:
    """The strength at which information of so much is worth what is needed."""
    return float(np.sqrt(needed / information)) if information > 0.0 else inf
