"""What a free law would explain at every place, to first order."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from wheelhop.campaign import Campaign, ComponentCampaign
from wheelhop.diagnose import Rung
from wheelhop.diagnose.screen import Screened, Terms
from wheelhop.fit import Workshop
from wheelhop.law.free import Form, FreeForce
from wheelhop.law.places import Moved, Where, motion_of, of_axle, parts_of, places
from wheelhop.law.terms import knots, slips
from wheelhop.vehicle import axle_name, static_tyre_load

COUNTS = (5, 9, 17, 33)
"""Knots of a spline where an imposed motion gives the force at once."""
FINER = ((5, 99), (9, 3), (17, 1))
"""Elsewhere each knot is an integration of every run: so many knots, at so many of the places that
promised most with fewer."""
MOST_OF_BOTH = 9
"""More knots than that belong to a law with a kink, which is one of extension or of rate alone."""


@dataclass(frozen=True, eq=False)
class Promise:
    """The form that promises most at a place, as it was screened."""

    where: Where
    form: Form
    screened: Screened


def screen_places(workshop: Workshop, base: Rung) -> list[Promise]:
    """Every place with its best form, the most likely first."""
    campaign = workshop.campaign
    every = places(base.model.values)
    if gives_force_at_once(campaign):
        return _screened(workshop, base, every, COUNTS)
    best: dict[Where, Promise] = {}
    for count, most in FINER:
        leading = [p.where for p in _ranked(best.values())[:most] if p.where.kind == "strut"]
        for promise in _screened(workshop, base, leading if best else every, (count,)):
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
    workshop: Workshop, base: Rung, among: Sequence[Where], counts: Sequence[int]
) -> list[Promise]:
    """These places, each with its best form of these numbers of knots, the most likely first.

    Terms are simulated once for each strut, and at those that form an axle added up.
    """
    terms: dict[tuple[Where, Form], FreeForce] = {}
    totals: list[tuple[Where, Form, list[FreeForce]]] = []
    for where in among:
        moved = motion_of(workshop, base.model, of_axle(where, base.model.values))
        for simple in _sums(base, where, moved, counts):
            for part in parts_of(where):
                for form in simple:
                    terms.setdefault((part, form), FreeForce(part, {form.name: form}))
            parts = [terms[part, form] for part in parts_of(where) for form in simple]
            totals.append((where, _sum(simple), parts))
    if not terms:
        return []
    sums = Terms(workshop, base.fit, list(terms.values()))
    best: dict[Where, Promise] = {}
    for where, form, parts in totals:
        found = sums.screen(FreeForce(where, {form.name: form}), parts)
        if np.isfinite(found.gain) and (
            where not in best or found.score > best[where].screened.score
        ):
            best[where] = Promise(where, form, found)
    return _ranked(best.values())


def _sums(
    base: Rung, where: Where, moved: Moved | None, counts: Sequence[int]
) -> list[tuple[Form, ...]]:
    """Forms to try, from few terms to many, each as the simple ones that add up to it."""
    if where.kind == "tyre":
        values, corner = base.model.values, where.corners[0]
        stiffness = values[f"wheel.{axle_name(corner)}.tyre_stiffness_N_m"]
        deflection = static_tyre_load(values, corner) / stiffness
        at = tuple(float(share) * deflection for share in np.linspace(-1, 1, 5))
        return [(Form("5 knots of deflection", at),)]
    if moved is None:
        return []
    ways = slips(moved.extension)
    # On a rig a simulation costs next to nothing.
    sliders = Form("sliders", slips_m=ways if len(counts) > 1 else ways[::3])
    found: list[tuple[Form, ...]] = []
    for count in counts:
        x = Form(f"{count} knots of extension", knots(moved.extension, count))
        v = Form(f"{count} knots of rate", rate_m_s=knots(moved.rate, count))
        found += [(x,), (v,)]
        if count <= MOST_OF_BOTH:
            found += [(x, v), (x, v, sliders)]
    found.append((sliders,))
    for name in moved.inputs:
        for count in counts[:2]:
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
