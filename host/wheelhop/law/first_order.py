"""What a free law would explain at every place, to first order."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wheelhop.diagnose import Rung
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.effects import Effect
from wheelhop.law.free import Form, FreeForce
from wheelhop.law.motion import Moves
from wheelhop.law.places import Where, of_axle, parts_of, places
from wheelhop.law.regression import Columned, Signatures, Sums, gives_force_at_once
from wheelhop.law.terms import drift, knots, positioned, slipping, slipping_loaded, slips

COUNTS = (5, 9, 17, 33)
"""Knots of a spline where an imposed motion gives the force at once."""
FINER = ((5, 99), (9, 3), (17, 1))
"""Elsewhere so many knots, at so many of the places that promised most with fewer."""


@dataclass(frozen=True, eq=False)
class Promise:
    """The form that promises most at a place, as it was screened."""

    where: Where
    form: Form
    screened: Screened


def screen_places(signatures: Signatures, base: Rung, moves: Moves) -> list[Promise]:
    """Every place with its best form, the most likely first."""
    every = places(base.model.values)
    best: dict[Where, Promise] = {}
    stages: Sequence[tuple[int, int]] = FINER
    if gives_force_at_once(signatures.workshop.campaign):
        stages = [(count, len(every)) for count in COUNTS]
    for count, most in stages:
        leading = [promise.where for promise in _ranked(best.values())[:most]] or every
        for promise in _screened(signatures, base, moves, leading, count):
            before = best.get(promise.where)
            least = -np.inf if before is None else before.screened.score + signatures.as_well
            if promise.screened.score > least:
                best[promise.where] = promise
    return _ranked(best.values())


def _ranked(promises: Iterable[Promise]) -> list[Promise]:
    return sorted(promises, key=lambda p: -p.screened.score)


def _screened(
    signatures: Signatures,
    base: Rung,
    moves: Moves,
    among: Sequence[Where],
    count: int,
) -> list[Promise]:
    """These places, each with its best form of so many knots: families join while they leave
    noticeably less.

    Terms are known for each strut of an axle by itself, or for each axle of a place across both,
    and at all of them added up.
    """
    families = {where: _families(moves, where, base, count) for where in among}
    terms = {
        (part, form): signatures.free(part, form)
        for where, forms in families.items()
        for part in parts_of(where)
        for form in forms
    }
    signatures.know(list(terms.values()))
    grown = (_grown(signatures, where, forms, terms) for where, forms in families.items() if forms)
    return [promise for promise in grown if np.isfinite(promise.screened.gain)]


def _grown(
    signatures: Signatures,
    where: Where,
    forms: Sequence[Form],
    terms: Mapping[tuple[Where, Form], FreeForce],
) -> Promise:
    """The best form of a place; without splines each axle has forces of its own if that leaves
    noticeably less."""
    workshop, at = signatures.workshop, dict[str, list[tuple[Effect, str]]]()
    for form in forms:
        for i, part in enumerate(parts_of(where)):
            term = terms[part, form]
            for p in workshop.parameters_of(term):
                at.setdefault(p.name, []).append((term, p.name))
                if len(where.ends()) > 1:
                    at[where.ends()[i][0] + p.name] = [(term, p.name)]
    sums = Sums(signatures, list(dict.fromkeys(term for own in at.values() for term, _ in own)))

    def columns(form: Form) -> Columned:
        total = FreeForce(where, {form.name: form})
        return [at[p.name] for p in workshop.parameters_of(total)]

    best, chosen = -np.inf, list[Form]()
    while len(chosen) < len(forms):
        trials = [[*chosen, form] for form in forms if form not in chosen]
        worths = [sums.worth(columns(_sum(trial))) for trial in trials]
        if chosen and not max(worths) > best + signatures.as_well:
            break
        best, chosen = max(worths), trials[int(np.argmax(worths))]
    form = _sum(chosen)
    if len(where.ends()) > 1 and not (form.extension_m or form.rate_m_s):
        # A spline's knot that one axle alone reaches would be known from nothing at the other.
        apart = replace(form, name=f"{form.name}, each axle by itself", apart=True)
        if sums.worth(columns(apart)) > best + signatures.as_well:
            form = apart
    return Promise(where, form, sums.screen(FreeForce(where, {form.name: form}), columns(form)))


def _families(moves: Moves, where: Where, base: Rung, count: int) -> tuple[Form, ...]:
    """What a free law may be made of, one after the other: a spring, a damper, friction that gives
    way elastically; damping that follows the extension, friction that follows the load, and damping
    that changes while the run lasts; and dampers that recorded inputs drive. Nothing
    where no motion is told."""
    moved = moves.of(of_axle(where, base.model.values))
    if moved is None or not np.ptp(moved.extension) > 0.0:
        return ()
    x, v = (float(np.abs(way).max()) for way in (moved.extension, moved.rate))
    ways = slips(moved.extension)
    few = ways[:: 3 if count == COUNTS[0] else 1]
    loaded = tuple(slipping_loaded(way, x) for way in ways[::3])
    rate = knots(moved.rate, count)
    return (
        Form(f"{count} knots of extension", knots(moved.extension, count)),
        Form(f"{count} knots of rate", rate_m_s=rate),
        Form("sliders", terms=tuple(slipping(way) for way in few)),
        Form("damping by place", terms=tuple(positioned(x, v))),
        Form("friction by load", terms=loaded),
        Form("damping by time", terms=(drift(v),)),
        *(
            Form(f"{count} knots of rate, times {name}", inputs=((name, rate),))
            for name in moved.inputs
        ),
    )


def _sum(simple: Sequence[Form]) -> Form:
    """One form with all their terms."""
    return Form(
        " and ".join(form.name for form in simple),
        sum((form.extension_m for form in simple), ()),
        sum((form.rate_m_s for form in simple), ()),
        sum((form.terms for form in simple), ()),
        sum((form.inputs for form in simple), ()),
    )
