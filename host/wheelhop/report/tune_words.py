"""What tuning found, in sentences, and its JSON."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import Any

from wheelhop.files.words import listed, significant, unit_of
from wheelhop.tune.objectives import Objective
from wheelhop.tune.tuning import Cost, Gain, Setting, Tuning

UNITS = {"m": (1e3, " mm"), "rad": (180 / pi, "°"), "1": (100.0, " %")}
"""In which units people read an objective: how many of them its own unit is."""


def amount(value: float, objective: Objective, digits: int = 3) -> str:
    """A value of an objective with its unit: travel in mm, roll in degrees, shares in per cent."""
    size, unit = UNITS.get(objective.unit, (1.0, f" {objective.unit}"))
    return f"{significant(size * value, digits)}{unit}"


def change(gain: Gain, objective: Objective) -> str:
    """A gain with its interval, as the change it makes."""
    sign = "−" if gain.value > 0 else "+"
    return f"{sign}{amount(abs(gain.value), objective)} ± {amount(gain.half, objective, 2)}"


def sentences(found: Tuning) -> list[str]:
    """What a person wants to know first."""
    return [*_verdict(found), *_costs(found), *_basis(found)]


def _verdict(found: Tuning) -> Iterator[str]:
    first, names = found.front[0], listed([o.name for o in found.objectives])
    if found.proposed is None:
        told = [
            f"{o.name} {change(gain, o)}"
            for o, gain in zip(found.objectives, first.gains, strict=True)
        ]
        yield (
            f"There is no room for gain: of {found.count} settings within the bounds none is better"
            f" than the present one in {names} by more than what is not known of the car"
            f" (the best compromise: {', '.join(told)})."
        )
        return
    for objective, score, gain in zip(found.objectives, first.scores, first.gains, strict=True):
        now = found.now.scores[found.objectives.index(objective)]
        line = (
            f"The proposed setting takes {objective.name}, the {objective.title}, from"
            f" {amount(now, objective)} to {amount(score, objective)}"
        )
        size = "larger" if gain.is_sure else "smaller"
        yield f"{line}: {change(gain, objective)}, {size} than what is not known of the car."


def _costs(found: Tuning) -> Iterator[str]:
    """What effects cost in the first objective, beside what dampers could gain."""
    objective, now = found.objectives[0], found.now.scores[0]
    for cost in found.costs:
        if cost.whole[0] <= found.car.misfit * now:
            continue
        sizes = listed(
            [f"{significant(v, 3)} {unit_of(k)} ({k})" for k, v in cost.amplitudes.items()]
        )
        line = (
            f"{cost.effect} of {sizes} costs {amount(cost.whole[0], objective)} of"
            f" {objective.name}; halving it gains {amount(cost.half[0], objective)}"
        )
        yield f"{line}{_beside_dampers(found, cost, objective)}."


def _beside_dampers(found: Tuning, cost: Cost, objective: Objective) -> str:
    if found.dampers is None:
        return ""
    most = max(float(found.dampers[0]), 0.0)
    more = "more" if cost.half[0] > most else "less"
    by = "any setting" if more == "more" else "the best setting"
    return f", {more} than {by} of the dampers within their bounds ({amount(most, objective)})"


def _basis(found: Tuning) -> Iterator[str]:
    car = found.car
    if car.misfit:
        yield (
            f"The car is the one identified, whose model errs by {100 * car.misfit:.2g} % in the"
            " records; the intervals hold that error and the covariance of its numbers, at 95 %."
        )
    else:
        yield (
            "The car is the one believed, not identified: the intervals hold the uncertainties that"
            " its file states, at 95 %."
        )
    if not car.correlated:
        yield (
            "No correlations are known: the numbers count as independent, which makes intervals"
            " wide where masses and stiffnesses are known together."
        )


def to_json(found: Tuning) -> dict[str, Any]:
    """All that was found, for programs; SI."""
    return {
        "format": 1,
        "vehicle": found.car.vehicle.name,
        "runs": [drive.id for drive in found.drives],
        "objectives": [
            {"name": o.name, "title": o.title, "unit": o.unit} for o in found.objectives
        ],
        "variables": [
            {"name": v.name, "key": v.key, "low": v.low, "high": v.high, "now": v.now}
            | ({"choices": list(v.choices)} if v.choices else {})
            for v in found.variables
        ],
        "sentences": sentences(found),
        "room_for_gain": found.proposed is not None,
        "now": _setting(found.now),
        "front": [_setting(one) for one in found.front],
        "alone": {
            v.name: row.tolist() for v, row in zip(found.variables, found.alone, strict=True)
        },
        "dampers": None if found.dampers is None else found.dampers.tolist(),
        "costs": [
            {
                "effect": cost.effect,
                "amplitudes": dict(cost.amplitudes),
                "whole": cost.whole.tolist(),
                "half": cost.half.tolist(),
            }
            for cost in found.costs
        ],
        "settings_ridden": found.count,
    }


def _setting(one: Setting) -> dict[str, Any]:
    return {
        "values": dict(one.values),
        "objectives": one.scores.tolist(),
        "gains": [{"value": g.value, "half_width": g.half} for g in one.gains],
    }
