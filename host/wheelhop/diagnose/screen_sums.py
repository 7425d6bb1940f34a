"""Screening of sums: to first order terms add up, so that each is simulated once for all sums."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wheelhop.diagnose.screen import Screened, Variant, _columns, _prepare, _solve, variants
from wheelhop.diagnose.screen_table import Columns, Known, run_table
from wheelhop.effects import Effect
from wheelhop.fit import Fit, RunFit, Workshop


class Terms:
    """Signatures of terms, effects with amplitudes of different names and nothing else, in the runs
    of a fit."""

    def __init__(self, workshop: Workshop, base: Fit, terms: Sequence[Effect]) -> None:
        self._workshop, self._base = workshop, base
        prepared = [
            _prepare(workshop, base.model, variant)
            for term in terms
            for variant in variants(workshop, base, term)
        ]
        names = [p.name for item in prepared for p in item.variant.amplitudes]
        self._place = {name: i for i, name in enumerate(names)}
        systems = workshop.systems(base.model)

        def simulated(run: RunFit) -> tuple[Columns, np.ndarray]:
            found = _columns(run, base.model, systems, prepared)
            together = Columns(np.hstack([c.amplitudes for c in found]), found[0].own[:, :0])
            return together, Known.of(run).with_columns(run, together)

        self._runs = workshop.each(simulated, base.runs)

    def screen(self, total: Effect) -> Screened:
        """The sum of those terms whose amplitudes `total` has."""
        base, parameters = self._base, tuple(self._workshop.parameters_of(total))
        chosen = [self._place[p.name] for p in parameters]
        tables = []
        for run, (columns, products) in zip(base.runs, self._runs, strict=True):
            known = len(run.own) + len(base.shared)
            kept = [*range(known), *(known + i for i in chosen), products.shape[1] - 1]
            part = Columns(columns.amplitudes[:, chosen], columns.own)
            tables.append(run_table(run, base, part, products[:, kept][:, :, kept]))
        return _solve(base, Variant(total, "", {}, parameters), tables)
