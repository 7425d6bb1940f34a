"""What a free law would explain at every place, to first order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wheelhop.campaign import ComponentCampaign
from wheelhop.diagnose import Rung
from wheelhop.diagnose.screen import Screened
from wheelhop.diagnose.screen_sums import Terms
from wheelhop.fit import Workshop
from wheelhop.law.free import Form, FreeForce
from wheelhop.law.places import Moved, Where, motion_of, of_axle, parts_of, places
from wheelhop.law.terms import knots, slips
from wheelhop.vehicle import axle_name, static_tyre_load

COUNTS = {True: (5, 9, 17, 33), False: (5,)}
"""Knots of a spline where an imposed motion gives the force at once; and elsewhere, where each knot
is an integration of every run."""
MOST_OF_BOTH = 9
"""More knots than that belong to a law with a kink, which is one of extension or of rate alone."""


@dataclass(frozen=True, eq=False)
class Promise:
    """The form that promises most at a place, as it was screened."""

    where: Where
    form: Form
    screened: Screened


def screen_places(workshop: Workshop, base: Rung) -> list[Promise]:
    """Every place with its best form, the most likely first.

    Terms are simulated once for each strut, and at those that form an axle added up.
    """
    campaign, values = workshop.campaign, base.model.values
    quick = isinstance(campaign, ComponentCampaign) and campaign.drive == "displacement"
    terms: dict[tuple[Where, Form], FreeForce] = {}
    totals: list[tuple[Where, Form, list[FreeForce]]] = []
    for where in places(values):
        moved = motion_of(workshop, base.model, of_axle(where, base.model.values))
        for simple in _sums(base, where, moved, quick):
            for part in parts_of(where):
                for form in simple:
                    terms.setdefault((part, form), FreeForce(part, {form.name: form}))
            among = [terms[part, form] for part in parts_of(where) for form in simple]
            totals.append((where, _sum(simple), among))
    if not terms:
        return []
    sums = Terms(workshop, base.fit, list(terms.values()))
    best: dict[Where, Promise] = {}
    for where, form, among in totals:
        found = sums.screen(FreeForce(where, {form.name: form}), among)
        if np.isfinite(found.gain) and (
            where not in best or found.score > best[where].screened.score
        ):
            best[where] = Promise(where, form, found)
    return sorted(best.values(), key=lambda p: -p.screened.score)


def _sums(base: Rung, where: Where, moved: Moved | None, quick: bool) -> list[tuple[Form, ...]]:
    """Forms to try, from few terms to many, each as the simple ones that add up to it; `quick`:
    where a simulation costs next to nothing."""
    if where.kind == "tyre":
        values, corner = base.model.values, where.corners[0]
        stiffness = values[f"wheel.{axle_name(corner)}.tyre_stiffness_N_m"]
        deflection = static_tyre_load(values, corner) / stiffness
        at = tuple(float(share) * deflection for share in np.linspace(-1, 1, 5))
        return [(Form("5 knots of deflection", at),)]
    if moved is None:
        return []
    ways = slips(moved.extension)
    sliders = Form("sliders", slips_m=ways if quick else ways[::3])
    found: list[tuple[Form, ...]] = []
    for count in COUNTS[quick]:
        x = Form(f"{count} knots of extension", knots(moved.extension, count))
        v = Form(f"{count} knots of rate", rate_m_s=knots(moved.rate, count))
        found += [(x,), (v,)]
        if count <= MOST_OF_BOTH:
            found += [(x, v), (x, v, sliders)] if quick else [(x, v)]
    found.append((sliders,))
    for name in moved.inputs:
        for count in COUNTS[quick][:2]:
            rate = knots(moved.rate, count)
            by = Form(f"{count} knots of rate, times {name}", inputs=((name, rate),))
            found += [(*simple, by) for simple in found if not simple[-1].inputs] + [(by,)]
    return found


def _sum(simple: Sequence[Form]) -> Form:
    """One form with all their terms."""
    return Form(
        " and ".join(form.name for form in simple),
        sum((form.extension_m for form in simple), ()),
        sum((form.rate_m_s for form in simple), ()),
        sum((form.slips_m for form in simple), ()),
        sum((form.inputs for form in simple), ()),
    )
