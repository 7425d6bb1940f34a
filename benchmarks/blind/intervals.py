"""Do the intervals that are stated of forces and stiffnesses hold the truth?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

WIDE = 2.0
"""Standard deviations to either side."""

ENDINGS = ("_N", "_N_m")
"""Of the names of forces and stiffnesses, in SI."""

CALLED = {"dry-friction.front_N": "coulomb_front_N", "dry-friction.rear_N": "coulomb_rear_N"}
"""What the truth calls numbers of effects that it has under another name."""

OF_THE_FORM = ("dry-friction.presliding_N_m",)
"""Numbers of one form of a law, where the truth may have another."""


def held(step: Mapping[str, Any], truth: Mapping[str, Any]) -> tuple[int, int]:
    """How many intervals of a ladder's step (`parameters`, `uncertainties`) hold the true number,
    and of how many: those of the vehicle, and of the effects that are really there."""
    inside = [abs(value - true) <= WIDE * sd for value, sd, true in _pairs(step, truth)]
    return sum(inside), len(inside)


def _pairs(
    step: Mapping[str, Any], truth: Mapping[str, Any]
) -> Iterator[tuple[float, float, float]]:
    """What is stated of each such number, its standard deviation, and what it truly is."""
    vehicle, deviations = dict(_flat(truth["vehicle_true"])), step.get("uncertainties", {})
    for name, value in step.get("parameters", {}).items():
        effect, _, own = name.partition(".")
        of_effect = truth.get("effect", {}).get(effect, {})
        true = vehicle.get(name, of_effect.get(CALLED.get(name, own)))
        counts = name.endswith(ENDINGS) and name not in OF_THE_FORM
        if counts and true is not None and (deviation := deviations.get(name)):
            yield value, deviation, float(true)


def _flat(table: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, float]]:
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", value
