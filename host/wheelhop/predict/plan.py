"""Which runs to drive: of all that could be made, the few that together would tell most.

Of a set of runs with the information matrix M (its blocks: g the vehicle's numbers, e the effects'
strengths) and the prior precision W of the numbers, the plan counts in nats

- what it tells of the numbers: ½ ln det(W + M_gg) − ½ ln det W (D-optimality; V. Fedorov, Theory of
  Optimal Experiments, Academic Press 1972, section 2.1);
- of every effect's strength, believed to be of its scale: ½ ln(1 + S_ii − S_ij² / (1 + S_jj)),
  S = M_ee − M_eg (W + M_gg)⁻¹ M_ge, where j is the rival that leaves least of it.

Runs are chosen one by one, each time the one that adds most. The sum is nearly submodular: one run
less is gained by a run that comes later, and choosing so is within 1 − 1/e of the best set if it is
so exactly (G. Nemhauser, L. Wolsey, M. Fisher, Math. Programming 14 (1978) 265).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, log
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.diagnose.ambiguity import AMBIGUOUS_DEG
from wheelhop.diagnose.judge import SIGNIFICANT
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
    """What the advised runs tell of an effect.

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
        """All runs that could be driven, those to drive first and in order (`rank`; NaN for the
        others), then by what they tell alone."""
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
    numbers = np.linalg.slogdet(matrix)[1] - np.log(np.maximum(foreseen.prior, TINY)).sum()
    left = _beside_rivals(_strengths(foreseen, total))
    effects = np.log1p(left.min(axis=1, initial=inf)).sum() if len(left) else 0.0
    return Worth(0.5 * float(numbers), 0.5 * float(effects))


def told(foreseen: Foreseen, chosen: Sequence[int]) -> tuple[Told, ...]:
    """What some of the runs tell of each effect."""
    strengths = _strengths(foreseen, _sum(foreseen, chosen))
    left, size = _beside_rivals(strengths), np.diag(strengths)
    return tuple(
        _told(foreseen, i, int(np.argmin(left[i])), strengths, left[i].min(), len(chosen))
        for i in range(len(size))
    )


TINY = 1e-6
"""Precision of a number nothing is believed of; it keeps the matrix regular."""


def _sum(foreseen: Foreseen, chosen: Sequence[int]) -> Array:
    return np.asarray(foreseen.information[list(chosen)].sum(axis=0))


def _numbers(foreseen: Foreseen, total: Array) -> Array:
    """Precision (g, g) of the vehicle's numbers where no effect is missing."""
    g = len(foreseen.numbers)
    return np.asarray(total[:g, :g] + np.diag(np.maximum(foreseen.prior, TINY)))


def _strengths(foreseen: Foreseen, total: Array) -> Array:
    """Information (e, e) on the effects' strengths, the vehicle's numbers eliminated."""
    g = len(foreseen.numbers)
    back = np.linalg.solve(_numbers(foreseen, total), total[:g, g:])
    left = total[g:, g:] - total[g:, :g] @ back
    return np.asarray(0.5 * (left + left.T))


def _beside_rivals(strengths: Array) -> Array:
    """What is left (e, e) of the information on effect i where effect j is free as well; on the
    diagonal what there is without a rival."""
    size = np.maximum(np.diag(strengths), 0.0)
    shared = strengths**2 / (1.0 + size)
    np.fill_diagonal(shared, 0.0)
    return np.asarray(np.maximum(size[:, None] - shared, 0.0))


def _told(foreseen: Foreseen, i: int, rival: int, strengths: Array, left: float, runs: int) -> Told:
    variant = foreseen.effects[i]
    numbers = sum(not p.switch for p in variant.amplitudes) + len(variant.shapes)
    # As the diagnosis asks: worth its parameters' price, and on a third of the runs not by chance.
    by_chance = 2.0 * log(len(foreseen.effects) / SIGNIFICANT) * (VALIDATE_EVERY - 1)
    needed = max(numbers * log(foreseen.size * runs), by_chance)
    both = float(np.sqrt(max(strengths[i, i], 0.0) * max(strengths[rival, rival], 0.0)))
    angle = 90.0
    if both > 0.0 and rival != i:
        angle = float(np.degrees(np.arccos(min(1.0, abs(strengths[i, rival]) / both))))
    return Told(
        variant.effect.id,
        variant.choice,
        {p.name: p.scale for p in variant.amplitudes},
        _least(needed, float(strengths[i, i])),
        _least(needed, left),
        foreseen.effects[rival].effect.id if rival != i else "",
        angle,
    )


def _least(needed: float, information: float) -> float:
    """The strength at which information of so much is worth what is needed."""
    return float(np.sqrt(needed / information)) if information > 0.0 else inf
