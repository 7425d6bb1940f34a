"""What scales and a stopwatch tell of a whole vehicle: sums and relations of its numbers.

The weight on an axle is known to 2 %, how much of it is wheels to 40 %. Stated as two numbers, each
with its own uncertainty, what the scales said is lost.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, sqrt

from wheelhop.vehicle.layout import axle_name, axles, static_load, static_tyre_load, wheels

MEASURED = "measured"
"""The table of vehicle.toml."""
TOTAL, AXLE, RIDE = "total_mass_kg", "axle_kg", "ride_hz"


@dataclass(frozen=True)
class Measured:
    """A relation of a vehicle's numbers that was measured: its key, its value, positive, and one
    standard deviation in the same unit. It is believed in proportion."""

    key: str
    value: float
    sigma: float

    @property
    def name(self) -> str:
        """Its dotted name: "measured.front_axle_kg"."""
        return f"{MEASURED}.{self.key}"

    @property
    def relative(self) -> float:
        """One standard deviation of its logarithm."""
        return self.sigma / self.value

    def of(self, values: Mapping[str, float]) -> float:
        """What a vehicle with these numbers has instead."""
        if self.key == TOTAL:
            return sum(static_tyre_load(values, i, 1.0) for i in wheels(values))
        end, _, quantity = self.key.partition("_")
        corners = [i for i in wheels(values) if axle_name(i) == end]
        if quantity == AXLE:
            return sum(static_tyre_load(values, i, 1.0) for i in corners)
        spring = values[f"suspension.{end}.stiffness_N_m"]
        tyre = values[f"wheel.{end}.tyre_stiffness_N_m"]
        mass = static_load(values, corners[0], 1.0)
        return sqrt(spring * tyre / (spring + tyre) / mass) / (2 * pi)


def measurable(values: Mapping[str, float]) -> tuple[str, ...]:
    """The keys that [measured] of a vehicle with these numbers may have."""
    ends = [f"{end}_{what}" for end in axles(values) for what in (AXLE, RIDE)]
    return (TOTAL, *ends)
