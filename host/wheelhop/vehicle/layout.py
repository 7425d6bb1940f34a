"""The ladder of models: in which ways a vehicle's body moves, and which wheels carry it.

A body that does not pitch has no rear wheels, one that does not roll no right ones. So the numbers
of a vehicle say by themselves what it is: which inertias they hold.
"""

from __future__ import annotations

from collections.abc import Mapping

from wheelhop.files.units import STANDARD_GRAVITY_M_S2

CORNERS = (0, 1, 2, 3)
"""Front left, front right, rear left, rear right."""

FULL_CAR = "full-car"
MODELS: Mapping[str, tuple[str, ...]] = {
    "quarter-car": ("heave",),
    "half-car": ("heave", "pitch"),
    "half-car-roll": ("heave", "roll"),
    FULL_CAR: ("heave", "pitch", "roll"),
}
"""The body's motions in each model, by its name in vehicle.toml."""

INERTIA: Mapping[str, str] = {
    "heave": "body.mass_kg",
    "pitch": "body.pitch_inertia_kg_m2",
    "roll": "body.roll_inertia_kg_m2",
}
"""The number that each motion of the body has to have."""


def motions(values: Mapping[str, float]) -> tuple[str, ...]:
    """The ways in which the sprung body moves; a component has none."""
    return tuple(motion for motion, key in INERTIA.items() if key in values)


def wheels(values: Mapping[str, float]) -> tuple[int, ...]:
    """The corners that have a wheel, in the order of `CORNERS`."""
    has = motions(values)
    return tuple(i for i in CORNERS if ("pitch" in has or i < 2) and ("roll" in has or i % 2 == 0))


def axle_name(corner: int) -> str:
    """Front or rear: the key under which vehicle.toml keeps a corner's numbers."""
    return "front" if corner < 2 else "rear"


def axles(values: Mapping[str, float]) -> tuple[str, ...]:
    """The axles there are: "front", and "rear"."""
    return tuple(dict.fromkeys(axle_name(i) for i in wheels(values)))


def behind_m(values: Mapping[str, float], corner: int) -> float:
    """How far a corner lies behind the front axle, m; 0 where there is no other."""
    return values.get("geometry.wheelbase_m", 0.0) if corner >= 2 else 0.0


def corner_position(values: Mapping[str, float], corner: int) -> tuple[float, float]:
    """(x, y), m, of a corner's attachment point, seen from the sprung body's centre of mass."""
    x = values.get("geometry.cg_to_front_axle_m", 0.0) - behind_m(values, corner)
    half = values.get("geometry.track_width_m", 0.0) / 2
    return x, half if corner % 2 == 0 else -half


def static_load(
    values: Mapping[str, float], corner: int, gravity: float = STANDARD_GRAVITY_M_S2
) -> float:
    """Static load of the suspension spring at a corner, N, from the body's mass and its place."""
    has, share = motions(values), 1.0
    if "pitch" in has:
        rear = values["geometry.cg_to_front_axle_m"] / values["geometry.wheelbase_m"]
        share = rear if corner >= 2 else 1 - rear
    if "roll" in has:
        share /= 2
    return values["body.mass_kg"] * gravity * share


def static_tyre_load(
    values: Mapping[str, float], corner: int, gravity: float = STANDARD_GRAVITY_M_S2
) -> float:
    """Static load under the wheel of a corner, N."""
    unsprung = values[f"wheel.{axle_name(corner)}.unsprung_mass_kg"]
    return static_load(values, corner, gravity) + unsprung * gravity


def body_inertia(values: Mapping[str, float]) -> tuple[float, ...]:
    """What resists each of the body's motions, as :meth:`Assembly.system` wants them: mass, pitch
    and roll inertia, as far as it has them."""
    return tuple(values[INERTIA[motion]] for motion in motions(values))
