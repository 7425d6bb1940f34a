"""The vehicles of the generated campaigns: numbers as in vehicle.toml, keyed by dotted names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

Vehicle = Mapping[str, float]  # "suspension.front.stiffness_N_m" -> value, SI

GRAVITY_M_S2 = 9.81


def flatten(table: Mapping[str, Any], prefix: str = "") -> dict[str, float]:
    """Nested TOML tables of numbers as one dict with dotted keys; other values are dropped."""
    flat: dict[str, float] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            flat |= flatten(value, f"{prefix}{key}.")
        elif isinstance(value, (int, float)):
            flat[prefix + key] = float(value)
    return flat


def axle(corner: int) -> str:
    """ "front" or "rear"; corners count 0 front left, 1 front right, 2 rear left, 3 rear right."""
    return "front" if corner < 2 else "rear"


def corner_positions(vehicle: Vehicle) -> list[tuple[float, float]]:
    """(x, y) of the four wheels from the sprung body's centre of mass, metres."""
    front = vehicle["geometry.cg_to_front_axle_m"]
    rear = front - vehicle["geometry.wheelbase_m"]
    half = vehicle["geometry.track_width_m"] / 2.0
    return [(front, half), (front, -half), (rear, half), (rear, -half)]


def suspension_static_load(vehicle: Vehicle) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Weight of the sprung body on each suspension (4,), newtons."""
    ahead = vehicle["geometry.cg_to_front_axle_m"] / vehicle["geometry.wheelbase_m"]
    half_weight = 0.5 * GRAVITY_M_S2 * vehicle["body.mass_kg"]
    return half_weight * np.array([1.0 - ahead, 1.0 - ahead, ahead, ahead])


def tyre_static_load(vehicle: Vehicle) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Weight on each contact (4,): the sprung body's share and the wheel's own, newtons."""
    wheels = [vehicle[f"wheel.{axle(i)}.unsprung_mass_kg"] for i in range(4)]
    return suspension_static_load(vehicle) + GRAVITY_M_S2 * np.array(wheels)
