"""What sums of terms would explain of the residual of a fit: linear regression on its signatures.

On a road, of a model without force laws, a term's signature is that of its force along the motion
recorded (`ForcedRun`), and holds however strong it is; else it is simulated beside the model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from math import log

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.screen import Screened, solve
from wheelhop.diagnose.screen_table import Columns, Known, Table, run_table
from wheelhop.diagnose.signatures import Variant, prepare, signatures, variants
from wheelhop.effects import Effect
from wheelhop.fit import Fit, RunFit, Workshop
from wheelhop.law.along import follow_all, laws_of
from wheelhop.law.formula import Formula
from wheelhop.law.motion import Moves
from wheelhop.law.places import Where
from wheelhop.law.terms import Term
from wheelhop.vehicle import is_component

Array = NDArray[np.float64]


class Signatures:
    """Signatures (size, a) of terms, effects with amplitudes and nothing else, in the runs of a
    fit; each is computed once."""

    def __init__(self, workshop: Workshop, base: Fit, moves: Moves) -> None:
        self.workshop, self.base, self._moves = workshop, base, moves
        self.known = workshop.each(Known.of, base.runs)
        self._found: dict[Effect, list[Array]] = {}
        self._alone: dict[tuple[Where, Term], Formula] = {}
        values = base.model.values
        laws = any(system.laws for system in workshop.systems(base.model).values())
        self._along = moves.on_road and not laws and not is_component(values)

    def of(self, terms: Sequence[Effect]) -> list[Array]:
        """Of all these terms side by side, run by run."""
        fresh = [term for term in dict.fromkeys(terms) if term not in self._found]
        if fresh:
            of_runs = self._followed(fresh) if self._along else self._simulated(fresh)
            for i, term in enumerate(fresh):
                self._found[term] = [run[i] for run in of_runs]
        return [np.hstack(run) for run in zip(*(self._found[t] for t in terms), strict=True)]

    def alone(self, where: Where, term: Term) -> Formula:
        """A term at a place, always the same effect, so that its signature is known."""
        return self._alone.setdefault((where, term), Formula(where, [term]))

    def _simulated(self, terms: Sequence[Effect]) -> list[list[Array]]:
        base = self.base
        found = [v for term in terms for v in variants(self.workshop, base, term)]
        prepared = [prepare(self.workshop, base.model, variant) for variant in found]
        systems = self.workshop.systems(base.model)

        def simulated(run: RunFit) -> list[Array]:
            return [c.amplitudes for c in signatures(run, base.model, systems, prepared)]

        return self.workshop.each(simulated, base.runs)

    def _followed(self, terms: Sequence[Effect]) -> list[list[Array]]:
        values, rows = self.base.model.values, self._moves.rows
        names = [[p.name for p in self.workshop.parameters_of(term)] for term in terms]
        laws = [
            [(rows.index(row), kernel, numbers) for row, kernel, numbers, _ in one]
            for term, own in zip(terms, names, strict=True)
            for name in own
            for one in [laws_of(term, {n: float(n == name) for n in own}, values)]
        ]
        counts = np.cumsum([len(own) for own in names])[:-1]

        runs = self._moves.forced

        def followed(run: RunFit) -> list[Array]:
            forced = runs[run.bench.run.id]
            each = [item for one in laws for item in one]
            force = follow_all(each, forced.extension, forced.rate, forced.step_s)
            answers = forced.answers([port for port, *_ in each], force)
            ends = np.cumsum([0, *(len(one) for one in laws)])
            sums = [answers[:, a:b].sum(axis=1) for a, b in pairwise(ends)]
            return np.split(np.stack(sums, axis=1), counts, axis=1)

        return self.workshop.each(followed, self.base.runs)


class Sums:
    """Sums of some terms; each run's table is made once, of all of them."""

    def __init__(self, signatures: Signatures, terms: Sequence[Effect]) -> None:
        self._of, workshop = signatures, signatures.workshop
        self._names = [(term, p.name) for term in terms for p in workshop.parameters_of(term)]
        columns = signatures.of(terms)
        # What runs away spoils no sum but its own.
        self._fine = np.all([np.isfinite(run).all(axis=0) for run in columns], axis=0)
        base = signatures.base

        def table(given: tuple[RunFit, Known, Array]) -> Table:
            run, known, own = given
            part = Columns(own[:, self._fine], own[:, :0])
            return run_table(run, base, part, known.with_columns(run, part))

        given = zip(base.runs, signatures.known, columns, strict=True)
        self._tables = workshop.each(table, list(given))
        known = [(f.scale / f.sigma) ** 2 for f in base.shared] * np.array(base.sigma**2)
        self._matrix = np.sum([t.matrix for t in self._tables], axis=0)
        self._matrix[: len(known), : len(known)] += np.diag(known)
        self._gradient = np.sum([t.gradient for t in self._tables], axis=0)
        self._power = sum(float(run.surprise @ run.surprise) for run in base.runs)

    def worth(self, sums: Sequence[Sequence[Effect]], shapes: int = 0) -> float:
        """Logarithm of evidence of sums of terms, the terms of each with numbers of the same names
        and values: what is left counts as noise (profile likelihood and the price of BIC); so many
        `shapes` were fitted, too. −∞ if a term runs away."""
        chosen = np.array(
            [
                [float(term in parts and name == p) for term, name in self._names]
                for parts in sums
                for p in self._numbers(parts[0])
            ]
        ).T
        if chosen[~self._fine].any():
            return -np.inf
        g, chosen = len(self._of.base.shared), chosen[self._fine]
        inner = self._matrix[:g, :g]
        across, gradient = self._matrix[:g, g:] @ chosen, self._gradient[g:] @ chosen
        whole = np.block([[inner, across], [across.T, chosen.T @ self._matrix[g:, g:] @ chosen]])
        whole += np.diag(1e-9 * np.diag(whole))
        pull = np.concatenate([self._gradient[:g], gradient])
        left = self._power - float(pull @ np.linalg.solve(whole, pull))
        size = self._of.base.size
        gain = size * log(self._power / left) if left > 0.0 else np.inf
        return float(0.5 * (gain - (chosen.shape[1] + shapes) * log(size)))

    def _numbers(self, term: Effect) -> list[str]:
        return [p.name for p in self._of.workshop.parameters_of(term)]

    def screen(self, total: Effect, among: Sequence[Effect]) -> Screened:
        """The sum of these terms: an amplitude of `total` is that of every term `among` them which
        has one of this name. What it promises is −∞ if one of them runs away."""
        parameters = tuple(self._of.workshop.parameters_of(total))
        chosen = np.array(
            [
                [float(p.name == name and term in among) for p in parameters]
                for term, name in self._names
            ]
        )
        base, variant = self._of.base, Variant(total, "", {}, parameters)
        tables = [_summed(table, chosen[self._fine], len(base.shared)) for table in self._tables]
        found = solve(base, variant, tables)
        if chosen[~self._fine].any():
            return replace(found, gain=-np.inf)
        return found


def _summed(table: Table, chosen: Array, shared: int) -> Table:
    """The table of sums of its amplitudes, `chosen` (a, s) of them."""
    own = len(table.back)
    some = np.flatnonzero(chosen.any(axis=1))

    def of(before: int, after: int) -> tuple[list[int], Array]:
        """Which rows are kept, and what becomes of them; so many stand before the amplitudes."""
        kept = [
            *range(before),
            *(before + some),
            *range(before + len(chosen), before + len(chosen) + after),
        ]
        matrix = np.zeros((len(kept), before + chosen.shape[1] + after))
        matrix[:before, :before] = np.eye(before)
        matrix[before : before + len(some), before : before + chosen.shape[1]] = chosen[some]
        matrix[before + len(some) :, before + chosen.shape[1] :] = np.eye(after)
        return kept, matrix

    (i, among), (j, last), (k, whole) = of(shared, 0), of(shared, 1), of(own + shared, 1)
    return replace(
        table,
        matrix=among.T @ table.matrix[np.ix_(i, i)] @ among,
        gradient=table.gradient[i] @ among,
        signatures=table.signatures[:, some] @ chosen[some].astype(np.float32),
        back=table.back[:, j] @ last,
        products=whole.T @ table.products[:, k][:, :, k] @ whole,
        at_noise=among.T @ table.at_noise[np.ix_(i, i)] @ among,
    )
