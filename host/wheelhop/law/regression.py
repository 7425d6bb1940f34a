"""What sums of terms would explain of the residual of a fit: linear regression on its signatures.

On a road, of a model without force laws, a term's signature is that of its force along the motion
recorded (`ForcedRun`), and holds however strong it is; else it is simulated beside the model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import log

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, ComponentCampaign
from wheelhop.diagnose.screen.first_order import Screened, Taken, solve
from wheelhop.diagnose.screen.signatures import Variant, prepare, signatures, variants
from wheelhop.diagnose.screen.table import Columns, Known, Table, run_table
from wheelhop.effects import Effect
from wheelhop.fit import Fit, RunFit, Workshop
from wheelhop.law.along import follow_all, laws_of
from wheelhop.law.formula import Formula
from wheelhop.law.free import Form, FreeForce
from wheelhop.law.motion import Moves
from wheelhop.law.places import Where
from wheelhop.law.terms import Term
from wheelhop.vehicle import is_component

Array = NDArray[np.float64]


AS_WELL = 1.05
"""A law that leaves no more than this many times what another one leaves does as well."""

Columned = Sequence[Sequence[tuple[Effect, str]]]
"""For every number of a sum which numbers of which terms it is."""


class Signatures:
    """Signatures (size, a) of terms, effects with amplitudes and nothing else, in the runs of a
    fit; each is computed once. Whether they `follow_records` or the motion of the model. What is
    taken `by_vehicle` alone counts for no term."""

    def __init__(
        self, workshop: Workshop, base: Fit, moves: Moves, by_vehicle: Taken | None = None
    ) -> None:
        self.workshop, self.base, self._moves = workshop, base, moves
        self.by_vehicle = by_vehicle
        self.known = workshop.each(Known.of, base.runs)
        self._found: dict[Effect, list[Array]] = {}
        self._free: dict[tuple[Where, Form], FreeForce] = {}
        self._alone: dict[tuple[Where, Term], Formula] = {}
        values = base.model.values
        laws = any(system.laws for system in workshop.systems(base.model).values())
        self.follow_records = moves.on_road and not laws and not is_component(values)

    @property
    def as_well(self) -> float:
        """Logarithm of evidence by which a law that does as well as another may fall behind it:
        none where the motion is imposed, and all that is left is noise."""
        imposed = gives_force_at_once(self.workshop.campaign)
        return 0.0 if imposed else self.base.size * log(AS_WELL)

    def know(self, terms: Sequence[Effect]) -> None:
        """Compute all of these terms that are not known yet: less work than one by one."""
        fresh = [term for term in dict.fromkeys(terms) if term not in self._found]
        if fresh:
            of_runs = self._followed(fresh) if self.follow_records else self._simulated(fresh)
            for i, term in enumerate(fresh):
                self._found[term] = [run[i] for run in of_runs]

    def of(self, terms: Sequence[Effect]) -> list[Array]:
        """Of all these terms side by side, run by run."""
        self.know(terms)
        of_runs = zip(*(self._found[term] for term in terms), strict=True)
        return self.workshop.each(np.hstack, list(of_runs))

    def alone(self, where: Where, term: Term) -> list[Formula]:
        """A term at every axle of a place, always the same effects, so that their signatures are
        known."""
        ends = [end for _, end in where.ends()]
        return [self._alone.setdefault((end, term), Formula(end, [term])) for end in ends]

    def free(self, where: Where, form: Form) -> FreeForce:
        """A free law of this form at a place, always the same effect."""
        return self._free.setdefault((where, form), FreeForce(where, {form.name: form}))

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

        each = [item for one in laws for item in one]
        columns = [i for i, one in enumerate(laws) for _ in one]

        def followed(run: RunFit) -> list[Array]:
            forced = runs[run.bench.run.id]
            force = follow_all(each, forced.extension, forced.rate, forced.step_s)
            answers = forced.answers([port for port, *_ in each], force, columns)
            return np.split(answers, counts, axis=1)

        return self.workshop.each(followed, self.base.runs)


def gives_force_at_once(campaign: Campaign) -> bool:
    """Whether the motion is imposed, so that a law is simulated by looking it up along it."""
    return isinstance(campaign, ComponentCampaign) and campaign.drive == "displacement"


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
            return run_table(run, base, part, known)

        given = zip(base.runs, signatures.known, columns, strict=True)
        self._tables = workshop.each(table, list(given))
        known = base.believed * base.sigma**2
        self._matrix = np.sum([t.matrix for t in self._tables], axis=0)
        self._matrix[: len(known), : len(known)] += known
        self._gradient = np.sum([t.gradient for t in self._tables], axis=0)
        self._power = sum(float(run.surprise @ run.surprise) for run in base.runs)

    def worth(self, columns: Columned, shapes: int = 0) -> float:
        """Logarithm of evidence of a sum whose numbers are these `columns`: what is left counts as
        noise (profile likelihood and the price of BIC); so many `shapes` were fitted, too. −∞ if a
        term runs away."""
        chosen = self._chosen(columns)
        if chosen[~self._fine].any():
            return -np.inf
        g, chosen = len(self._of.base.shared), chosen[self._fine]
        inner = self._matrix[:g, :g]
        across, gradient = self._matrix[:g, g:] @ chosen, self._gradient[g:] @ chosen
        whole = np.block([[inner, across], [across.T, chosen.T @ self._matrix[g:, g:] @ chosen]])
        # What an axle never does, as to reach a stop, has no signature there.
        whole += np.diag(1e-9 * np.diag(whole) + 1e-30)
        pull = np.concatenate([self._gradient[:g], gradient])
        left = self._power - float(pull @ np.linalg.solve(whole, pull))
        size = self._of.base.size
        gain = size * log(self._power / left) if left > 0.0 else np.inf
        return float(0.5 * (gain - (chosen.shape[1] + shapes) * log(size)))

    def screen(self, total: Effect, columns: Columned) -> Screened:
        """The effect `total`, whose amplitudes are these `columns`. What it promises is −∞ if one
        of their terms runs away."""
        parameters = tuple(self._of.workshop.parameters_of(total))
        chosen = self._chosen(columns)
        base, variant = self._of.base, Variant(total, "", {}, parameters)
        tables = [_summed(table, chosen[self._fine], len(base.shared)) for table in self._tables]
        found = solve(base, variant, tables, self._of.by_vehicle)
        if chosen[~self._fine].any():
            return replace(found, gain=-np.inf)
        return found

    def _chosen(self, columns: Columned) -> Array:
        """Which numbers of the terms, as rows, each column moves."""
        place = {name: i for i, name in enumerate(self._names)}
        chosen = np.zeros((len(place), len(columns)))
        for j, column in enumerate(columns):
            chosen[[place[name] for name in column], j] = 1.0
        return chosen


def _summed(table: Table, chosen: Array, shared: int) -> Table:
    """The table of sums of its amplitudes, `chosen` (a, s) of them."""
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

    (i, among), (j, last) = of(shared, 0), of(shared, 1)
    return replace(
        table,
        matrix=among.T @ table.matrix[np.ix_(i, i)] @ among,
        gradient=table.gradient[i] @ among,
        signatures=table.signatures[:, some] @ chosen[some].astype(np.float32),
        back=table.back[:, j] @ last,
        products=table.products.summed(chosen),
        at_noise=among.T @ table.at_noise[np.ix_(i, i)] @ among,
    )
