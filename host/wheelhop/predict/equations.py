"""The equations of what channels show of effects: of the channels there are, or of some more.

Of every run the derivatives of its record stand beside each other: by what the run leaves free, by
the vehicle's numbers, and by what every effect has. Their products say, to first order, what would
be left of an effect where everything else is fitted.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import log
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign
from wheelhop.compare.band import InBand
from wheelhop.diagnose import Limit
from wheelhop.diagnose.screen.signatures import Variant, prepare, signatures
from wheelhop.diagnose.screen.table import Columns
from wheelhop.diagnose.verdict.limits import drop_needed, least_strength, limit
from wheelhop.effects import RunSetting, Switch
from wheelhop.fit import Fit, RunFit, Workshop

Array = NDArray[np.float64]

TINY = 1e-9
"""Precision, in units of the prior's, that keeps the equations of idle numbers regular."""

Grams = tuple[Array, Array]
"""Products, per noise power, of all of a run's columns, and of what is wrong of the amplitudes'."""


@dataclass(frozen=True, eq=False)
class Shown:
    """One `run`, which stands for `weight` times as much: its derivatives by what the variants have
    (`columns`), and by how much those of the amplitudes (n, a) change where what moves the model is
    as wrong as it may be (`astray`)."""

    run: RunFit
    weight: float
    columns: Sequence[Columns]
    astray: Array


def shown_by(
    workshop: Workshop, base: Fit, variants: Sequence[Variant], weights: Sequence[float]
) -> list[Shown]:
    """Every run of a fit, each with its weight."""
    systems = workshop.systems(base.model)
    prepared = [prepare(workshop, base.model, variant) for variant in variants]

    def of_run(item: tuple[RunFit, float]) -> Shown:
        run, weight = item
        columns = signatures(run, base.model, systems, prepared)
        astray = np.zeros((run.bench.size, sum(c.amplitudes.shape[1] for c in columns)))
        if (wrong := workshop.astray.get(run.bench.run.id)) is not None:
            wrongly = signatures(replace(run, bench=wrong), base.model, systems, prepared)
            pairs = zip(wrongly, columns, strict=True)
            astray = np.hstack([one.amplitudes - other.amplitudes for one, other in pairs])
        return Shown(run, weight, columns, np.nan_to_num(astray, posinf=0.0, neginf=0.0))

    return workshop.each(of_run, list(zip(base.runs, weights, strict=True)))


@dataclass(frozen=True, eq=False)
class Equations:
    """The derivatives of all records, per noise: by the vehicle's numbers and what every run leaves
    free (`base`), and by what the `variants` have (`shown`)."""

    base: Fit
    variants: Sequence[Variant]
    shown: Sequence[Shown]
    least: float  #: share of the noise's power that is immaterial, or may be the simulation's error

    @property
    def settings(self) -> list[RunSetting]:
        """How the runs are driven."""
        return [run.bench.simulator.setting for run in self.base.runs]

    def limits(self, strengths: Sequence[float]) -> tuple[Limit, ...]:
        """What these least strengths of the variants, in scales of their amplitudes, are."""
        pairs = zip(self.variants, strengths, strict=True)
        return tuple(limit(variant, strength) for variant, strength in pairs)

    def seen(self, channels: Iterable[int]) -> Seen:
        """What some of the channels show."""
        kept = list(channels)
        return Seen(self, kept, [_gram(shown, kept, self.base.sigma) for shown in self.shown])

    def information(self, which: Sequence[int], grams: Sequence[Grams]) -> tuple[Array, float]:
        """What the runs tell of the amplitudes of some variants (a, a), and what these variants'
        own numbers in all runs cost."""
        g = len(self.base.shared)
        count = sum(len(self.variants[k].amplitudes) for k in which)
        total, price = np.zeros((g + count, g + count)), 0.0
        for shown, (gram, _) in zip(self.shown, grams, strict=True):
            r = len(shown.run.own)
            own, amplitudes = _places(shown.columns, which, r + g)
            n = r + len(own)
            order = [*range(r), *own, *range(r, r + g), *amplitudes]
            matrix = gram[np.ix_(order, order)]
            prior = np.array([(f.scale / f.sigma) ** 2 for f in shown.run.own] + [1.0] * len(own))
            inner = matrix[:n, :n] + np.diag(prior * (1.0 + TINY) + TINY)
            back = np.linalg.solve(inner, matrix[:n, n:])
            total += shown.weight * (matrix[n:, n:] - matrix[n:, :n] @ back)
            volume = np.linalg.slogdet(inner)[1] - np.linalg.slogdet(inner[:r, :r])[1]
            price += shown.weight * float(volume)
        believed = total[:g, :g] + self.base.believed + TINY * np.eye(g)
        told = total[g:, g:] - total[g:, :g] @ np.linalg.solve(believed, total[:g, g:])
        return np.asarray(told), price


def _places(
    columns: Sequence[Columns], which: Sequence[int], first: int
) -> tuple[list[int], list[int]]:
    """Where among a run's columns, those of the variants from the `first` on, some variants' own
    numbers and their amplitudes stand."""
    own, amplitudes = list[int](), list[int]()
    ends = np.cumsum([c.own.shape[1] + c.amplitudes.shape[1] for c in columns]) + first
    for k in which:
        middle = int(ends[k]) - columns[k].amplitudes.shape[1]
        own += range(middle - columns[k].own.shape[1], middle)
        amplitudes += range(middle, int(ends[k]))
    return own, amplitudes


@dataclass(frozen=True, eq=False)
class Seen:
    """The equations as some channels, `kept`, show them: `grams` of every run."""

    equations: Equations
    kept: Sequence[int]
    grams: Sequence[Grams]

    def strengths(self, campaign: Campaign) -> list[float]:
        """From where on each effect would be seen in all of a campaign's runs."""
        found = []
        for k, needed in enumerate(self._needed(campaign)):
            information, _ = self.equations.information([k], self.grams)
            found.append(self._least(k, information, needed))
        return found

    def rivals(self, campaign: Campaign) -> list[tuple[str, float]]:
        """From where on each effect would be told from its rival, of all others the one that does
        most of what it does, whatever its strength."""
        variants, found = self.equations.variants, list[tuple[str, float]]()
        for k, needed in enumerate(self._needed(campaign)):
            a, most = len(variants[k].amplitudes), ("", 0.0)
            for j, other in enumerate(variants):
                if j != k:
                    both, _ = self.equations.information([k, j], self.grams)
                    firm = both[a:, a:] + np.diag(TINY * np.diag(both)[a:] + np.finfo(float).tiny)
                    left = both[:a, :a] - both[:a, a:] @ np.linalg.solve(firm, both[a:, :a])
                    most = max(
                        most, (other.effect.id, self._least(k, left, needed)), key=itemgetter(1)
                    )
            found.append(most)
        return found

    def _least(self, k: int, information: Array, needed: tuple[float, float]) -> float:
        """What is wrong of an effect itself, because what moves the model is, grows with it: if it
        exceeds the effect, the effect is never seen."""
        variant, wrong = self.equations.variants[k], np.zeros_like(information)
        before = sum(len(other.amplitudes) for other in self.equations.variants[:k])
        mine = slice(before, before + len(variant.amplitudes))
        for shown, (_, astray) in zip(self.equations.shown, self.grams, strict=True):
            wrong += shown.weight * astray[mine, mine]
        by_chance, immaterial = needed
        return max(
            least_strength(variant, information, by_chance),
            least_strength(variant, information - wrong, immaterial),
        )

    def _needed(self, campaign: Campaign) -> Iterator[tuple[float, float]]:
        """The drop of the sum of squares, per noise power, that each effect has to bring not to be
        there by chance, and to be material."""
        base, variants = self.equations.base, self.equations.variants
        fitted, judging = (_data(base, campaign, self.kept, role) for role in ("fit", "validate"))
        judging = judging or fitted  # where no run is held out those fitted judge
        for k, variant in enumerate(variants):
            _, price = self.equations.information([k], self.grams)
            numbers = len(variant.shapes) + sum(
                not isinstance(p, Switch) for p in variant.amplitudes
            )
            price += numbers * log(fitted)
            by_chance = drop_needed(price, fitted, judging, len(variants), 0.0)
            yield by_chance, self.equations.least * fitted


def _gram(shown: Shown, kept: Sequence[int], sigma: float) -> Grams:
    """Products, per noise power, of all of a run's columns as some channels show them: its own
    numbers, the shared ones, and for each variant its numbers in the run and its amplitudes; and
    those of what is wrong of the amplitudes'."""
    run = shown.run
    shared, own = np.split(run.jacobian, [run.derivatives.shared], axis=1)
    parts = (part for c in shown.columns for part in (c.own, c.amplitudes))
    every = np.nan_to_num(np.hstack([own, shared, *parts]), posinf=0.0, neginf=0.0)
    seen, astray = (run.bench.seen_by(part, kept) / sigma for part in (every, shown.astray))
    return np.asarray(seen.T @ seen), np.asarray(astray.T @ astray)


def _data(base: Fit, campaign: Campaign, kept: Sequence[int], role: str) -> int:
    """In-band data of the runs of a role, of as many channels as are predicted in the pieces."""
    predicted = np.mean([run.bench.predicted[list(kept)].sum() for run in base.runs])
    counts = (
        InBand(len(run.time_s), campaign.sample_rate_hz, campaign.band_hz).count
        for run in campaign.runs
        if run.role == role
    )
    return round(float(predicted) * sum(counts))
