"""What a free law would explain at every place, to first order."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from wheelhop.campaign import Campaign, ComponentCampaign
from wheelhop.diagnose import Rung
from wheelhop.diagnose.screen import Screened
from wheelhop.law.free import Form, FreeForce
from wheelhop.law.motion import Moves
from wheelhop.law.places import Where, of_axle, parts_of, places
from wheelhop.law.regression import Signatures, Sums
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
            if before is None or promise.screened.score > before.screened.score:
                best[promise.where] = promise
    return _ranked(best.values())


def gives_force_at_once(campaign: Campaign) -> bool:
    """Whether the motion is imposed, so that a law is simulated by looking it up along it."""
    return isinstance(campaign, ComponentCampaign) and campaign.drive == "displacement"


def _ranked(promises: Iterable[Promise]) -> list[Promise]:
    return sorted(promises, key=lambda p: -p.screened.score)


def _screened(
    signatures: Signatures,
    base: Rung,
    moves: Moves,
    among: Sequence[Where],
    count: int,
) -> list[Promise]:
    """These places, each with its best form of so many knots.

    Terms are known for each strut of an axle by itself, and at both added up.
    """
    families = {where: _families(moves, where, base, count) for where in among}
    terms = {
        (part, form): FreeForce(part, {form.name: form})
        for where, forms in families.items()
        for part in parts_of(where)
        for form in forms
    }
    signatures.of(list(terms.values()))
    found = []
    for where, forms in families.items():
        parts = {f: [terms[part, f] for part in parts_of(where)] for f in forms}
        sums = Sums(signatures, [term for family in forms for term in parts[family]])

        best, chosen = 0.0, list[Form]()
        while len(chosen) < len(forms):
            trials = [[*chosen, form] for form in forms if form not in chosen]
            worth, trial = max(
                ((sums.worth([parts[f] for f in trial]), trial) for trial in trials),
                key=lambda found: found[0],
            )
            if chosen and not worth > best:
                break
            best, chosen = worth, trial
        if chosen and np.isfinite(best):
            form = _sum(chosen)
            total = FreeForce(where, {form.name: form})
            terms_of_it = [term for family in chosen for term in parts[family]]
            found.append(Promise(where, form, sums.screen(total, terms_of_it)))
    return found


def _families(moves: Moves, where: Where, base: Rung, count: int) -> tuple[Form, ...]:
    """What a free law may be made of, one after the other: a spring, a damper, friction that gives
    way elastically; damping that follows the extension, friction that follows the load, and damping
    that changes while the run lasts; and dampers that recorded inputs drive. Nothing
    where no motion is told."""
    moved = moves.of(of_axle(where, base.model.values))
    if moved is None or not np.ptp(moved.extension) > 0.0:
        return ()
    x, v = (float(np.abs(way).max()) for way in (moved.extension, moved.rate))
    ways = slips(moved.extension)[::3]
    loaded = tuple(slipping_loaded(way, x) for way in ways)
    rate = knots(moved.rate, count)
    return (
        Form(f"{count} knots of extension", knots(moved.extension, count)),
        Form(f"{count} knots of rate", rate_m_s=rate),
        Form("sliders", terms=tuple(slipping(way) for way in ways)),
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
