"""Screening of sums: to first order terms add up, so that each is simulated once for all sums."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.screen import Screened, Variant, prepare, signatures, solve, variants
from wheelhop.diagnose.screen_table import Columns, Known, run_table
from wheelhop.effects import Effect
from wheelhop.fit import Fit, RunFit, Workshop

Array = NDArray[np.float64]


class Terms:
    """Signatures of terms, effects with amplitudes and nothing else, in the runs of a fit."""

    def __init__(self, workshop: Workshop, base: Fit, terms: Sequence[Effect]) -> None:
        self._workshop, self._base = workshop, base
        of_terms = [(t, v) for t in terms for v in variants(workshop, base, t)]
        self._names = [(term, p.name) for term, variant in of_terms for p in variant.amplitudes]
        prepared = [prepare(workshop, base.model, variant) for _, variant in of_terms]
        systems = workshop.systems(base.model)

        def simulated(run: RunFit) -> tuple[Columns, Array]:
            found = signatures(run, base.model, systems, prepared)
            together = Columns(np.hstack([c.amplitudes for c in found]), found[0].own[:, :0])
            return together, Known.of(run).with_columns(run, together)

        self._runs = workshop.each(simulated, base.runs)

    def screen(self, total: Effect, among: Sequence[Effect]) -> Screened:
        """The sum of these terms: an amplitude of `total` is that of every term `among` them which
        has one of this name."""
        base, parameters = self._base, tuple(self._workshop.parameters_of(total))
        sums = np.array(
            [
                [float(p.name == name and term in among) for p in parameters]
                for term, name in self._names
            ]
        )
        some = np.flatnonzero(sums.any(axis=1))  # what runs away spoils no sum but its own
        sums = sums[some]
        tables = []
        for run, (columns, products) in zip(base.runs, self._runs, strict=True):
            known = len(run.own) + len(base.shared)
            kept = [*range(known), *(known + some), products.shape[1] - 1]
            matrix = np.zeros((len(kept), known + len(parameters) + 1))
            matrix[:known, :known] = np.eye(known)
            matrix[known:-1, known:-1], matrix[-1, -1] = sums, 1.0
            together = matrix.T @ products[:, kept][:, :, kept] @ matrix
            part = Columns(columns.amplitudes[:, some] @ sums, columns.own)
            tables.append(run_table(run, base, part, together))
        return solve(base, Variant(total, "", {}, parameters), tables)
