"""Three kinds of vehicle with the proving-ground runs that suit them, and how a campaign varies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .tracks import Track
from .vehicle import Vehicle


class Surface(NamedTuple):
    """One track at one severity, driven slow and, unless `fast_kmph` is 0, fast."""

    name: str
    kind: str
    amplitude_mm: float
    pitch_mm: float
    slow_kmph: float
    fast_kmph: float = 0.0


class PlannedRun(NamedTuple):
    """A run as campaign.toml lists it."""

    id: str
    role: str
    speed_kmph: float
    track: Track


@dataclass(frozen=True)
class Preset:
    """A vehicle (keys of vehicle.toml) and its surfaces."""

    name: str
    vehicle: Vehicle
    surfaces: tuple[Surface, ...]


_VALIDATE = {
    "washboard-low-fast",
    "washboard-high-slow",
    "herringbone-low-slow",
    "herringbone-high-fast",
    "chassis-twist-medium-fast",
    "one-sided-washboard-low",
}
_SHORT = {
    "washboard-low-slow",
    "washboard-high-slow",
    "washboard-high-fast",
    "herringbone-low-fast",
    "herringbone-high-fast",
    "chassis-twist-low-fast",
    "chassis-twist-medium-fast",
    "one-sided-washboard-high",
}
_EXACT = {  # measured with a tape, or not part of the model
    "geometry.wheelbase_m",
    "geometry.track_width_m",
    "wheel.front.radius_m",
    "wheel.rear.radius_m",
    "driver.x_m",
    "driver.y_m",
    "engine.x_m",
    "engine.y_m",
}


def planned_runs(preset: Preset, *, short: bool, lateral_offset_mm: float) -> list[PlannedRun]:
    """The 18 runs of a full campaign, or the 8 of a short one."""
    runs = []
    for surface in preset.surfaces:
        keys: dict[str, float | str] = {
            "amplitude_mm": surface.amplitude_mm,
            "pitch_mm": surface.pitch_mm,
        }
        if surface.kind == "herringbone":
            keys["angle_deg"] = 20.0
        if surface.kind == "chassis-twist":
            keys |= {"width_mm": 4000.0, "lateral_offset_mm": lateral_offset_mm}
        speeds = {"-slow": surface.slow_kmph, "-fast": surface.fast_kmph}
        if not surface.fast_kmph:
            speeds = {"": surface.slow_kmph}
        for suffix, speed in speeds.items():
            name = surface.name + suffix
            role = "validate" if name in _VALIDATE else "fit"
            runs.append(PlannedRun(name, role, speed, Track(surface.kind, keys)))
    return [run for run in runs if run.id in _SHORT] if short else runs


def draw_vehicles(
    preset: Preset, rng: np.random.Generator
) -> tuple[dict[str, float], dict[str, float]]:
    """The true vehicle, within 8 % of the preset, and what its owner believes.

    The belief is off by 10 % (one standard deviation, never more than two) in every number but
    the exact ones, and by 2 cm in the place of the centre of mass.
    """
    true, nominal = {}, {}
    for key, value in preset.vehicle.items():
        spread, error = rng.uniform(-0.08, 0.08), float(np.clip(rng.normal(), -2.0, 2.0))
        if key in _EXACT:
            true[key] = nominal[key] = value
        elif key == "geometry.cg_to_front_axle_m":
            true[key] = _rounded(value + 0.25 * spread)
            nominal[key] = _rounded(true[key] + 0.02 * error)
        else:
            true[key] = _rounded(value * (1.0 + spread))
            nominal[key] = _rounded(true[key] * (1.0 + 0.10 * error))
    return true, nominal


def _rounded(value: float) -> float:
    """To the six digits the files hold, so that they say exactly what was simulated."""
    return float(f"{value:.6g}")


_ATV = Preset(
    "student-built ATV",
    {
        "geometry.wheelbase_m": 1.42,
        "geometry.track_width_m": 1.18,
        "geometry.cg_to_front_axle_m": 0.80,
        "geometry.cg_height_m": 0.52,
        "body.mass_kg": 228.0,
        "body.pitch_inertia_kg_m2": 62.0,
        "body.roll_inertia_kg_m2": 25.0,
        "suspension.front.stiffness_N_m": 10500.0,
        "suspension.front.damping_N_s_m": 630.0,
        "suspension.rear.stiffness_N_m": 6500.0,
        "suspension.rear.damping_N_s_m": 590.0,
        "wheel.front.unsprung_mass_kg": 15.0,
        "wheel.front.tyre_stiffness_N_m": 40000.0,
        "wheel.front.tyre_damping_N_s_m": 200.0,
        "wheel.front.radius_m": 0.279,
        "wheel.rear.unsprung_mass_kg": 12.5,
        "wheel.rear.tyre_stiffness_N_m": 40000.0,
        "wheel.rear.tyre_damping_N_s_m": 200.0,
        "wheel.rear.radius_m": 0.279,
        "driver.mass_kg": 70.0,
        "driver.x_m": -0.10,
        "driver.y_m": 0.0,
        "engine.mass_kg": 40.0,
        "engine.x_m": -0.45,
        "engine.y_m": 0.0,
    },
    (
        Surface("washboard-low", "washboard", 15.0, 400.0, 7.5, 9.5),
        Surface("washboard-high", "washboard", 25.0, 600.0, 11.0, 13.0),
        Surface("herringbone-low", "herringbone", 10.0, 500.0, 9.0, 14.0),
        Surface("herringbone-medium", "herringbone", 15.0, 600.0, 21.0, 25.0),
        Surface("herringbone-high", "herringbone", 20.0, 800.0, 14.0, 19.0),
        Surface("chassis-twist-low", "chassis-twist", 150.0, 2000.0, 7.5, 15.5),
        Surface("chassis-twist-medium", "chassis-twist", 175.0, 3000.0, 6.5, 21.5),
        Surface("chassis-twist-high", "chassis-twist", 200.0, 4000.0, 5.5, 14.5),
        Surface("one-sided-washboard-low", "one-sided-washboard", 15.0, 400.0, 7.0),
        Surface("one-sided-washboard-high", "one-sided-washboard", 25.0, 600.0, 13.0),
    ),
)

_FORMULA_STUDENT = Preset(
    "Formula-student car",
    {
        "geometry.wheelbase_m": 1.55,
        "geometry.track_width_m": 1.20,
        "geometry.cg_to_front_axle_m": 0.82,
        "geometry.cg_height_m": 0.30,
        "body.mass_kg": 250.0,
        "body.pitch_inertia_kg_m2": 95.0,
        "body.roll_inertia_kg_m2": 28.0,
        "suspension.front.stiffness_N_m": 24000.0,
        "suspension.front.damping_N_s_m": 1500.0,
        "suspension.rear.stiffness_N_m": 28000.0,
        "suspension.rear.damping_N_s_m": 1700.0,
        "wheel.front.unsprung_mass_kg": 9.5,
        "wheel.front.tyre_stiffness_N_m": 95000.0,
        "wheel.front.tyre_damping_N_s_m": 250.0,
        "wheel.front.radius_m": 0.229,
        "wheel.rear.unsprung_mass_kg": 11.0,
        "wheel.rear.tyre_stiffness_N_m": 98000.0,
        "wheel.rear.tyre_damping_N_s_m": 250.0,
        "wheel.rear.radius_m": 0.229,
        "driver.mass_kg": 72.0,
        "driver.x_m": 0.10,
        "driver.y_m": 0.0,
        "engine.mass_kg": 55.0,
        "engine.x_m": -0.40,
        "engine.y_m": 0.0,
    },
    (
        Surface("washboard-low", "washboard", 4.0, 400.0, 7.5, 9.5),
        Surface("washboard-high", "washboard", 6.0, 600.0, 12.0, 16.0),
        Surface("herringbone-low", "herringbone", 3.0, 500.0, 9.0, 16.0),
        Surface("herringbone-medium", "herringbone", 4.0, 600.0, 21.0, 26.0),
        Surface("herringbone-high", "herringbone", 6.0, 800.0, 15.0, 22.0),
        Surface("chassis-twist-low", "chassis-twist", 40.0, 1500.0, 9.0, 17.0),
        Surface("chassis-twist-medium", "chassis-twist", 55.0, 2200.0, 9.0, 23.0),
        Surface("chassis-twist-high", "chassis-twist", 70.0, 3000.0, 8.0, 18.0),
        Surface("one-sided-washboard-low", "one-sided-washboard", 4.0, 400.0, 8.0),
        Surface("one-sided-washboard-high", "one-sided-washboard", 6.0, 600.0, 15.0),
    ),
)

_PASSENGER_CAR = Preset(
    "small passenger car",
    {
        "geometry.wheelbase_m": 2.46,
        "geometry.track_width_m": 1.46,
        "geometry.cg_to_front_axle_m": 1.05,
        "geometry.cg_height_m": 0.54,
        "body.mass_kg": 980.0,
        "body.pitch_inertia_kg_m2": 1350.0,
        "body.roll_inertia_kg_m2": 380.0,
        "suspension.front.stiffness_N_m": 21000.0,
        "suspension.front.damping_N_s_m": 1500.0,
        "suspension.rear.stiffness_N_m": 20000.0,
        "suspension.rear.damping_N_s_m": 1350.0,
        "wheel.front.unsprung_mass_kg": 36.0,
        "wheel.front.tyre_stiffness_N_m": 190000.0,
        "wheel.front.tyre_damping_N_s_m": 300.0,
        "wheel.front.radius_m": 0.290,
        "wheel.rear.unsprung_mass_kg": 32.0,
        "wheel.rear.tyre_stiffness_N_m": 185000.0,
        "wheel.rear.tyre_damping_N_s_m": 300.0,
        "wheel.rear.radius_m": 0.290,
        "driver.mass_kg": 78.0,
        "driver.x_m": 0.05,
        "driver.y_m": 0.35,
        "engine.mass_kg": 140.0,
        "engine.x_m": 1.00,
        "engine.y_m": 0.0,
    },
    (
        Surface("washboard-low", "washboard", 8.0, 500.0, 8.0, 11.0),
        Surface("washboard-high", "washboard", 14.0, 800.0, 14.0, 19.0),
        Surface("herringbone-low", "herringbone", 6.0, 500.0, 9.0, 14.0),
        Surface("herringbone-medium", "herringbone", 9.0, 600.0, 20.0, 25.0),
        Surface("herringbone-high", "herringbone", 18.0, 700.0, 16.0, 24.0),
        Surface("chassis-twist-low", "chassis-twist", 60.0, 2000.0, 8.0, 17.0),
        Surface("chassis-twist-medium", "chassis-twist", 80.0, 3000.0, 8.0, 22.0),
        Surface("chassis-twist-high", "chassis-twist", 110.0, 4000.0, 7.0, 18.0),
        Surface("one-sided-washboard-low", "one-sided-washboard", 8.0, 500.0, 8.0),
        Surface("one-sided-washboard-high", "one-sided-washboard", 14.0, 800.0, 17.0),
    ),
)

PRESETS = {"atv": _ATV, "formula-student": _FORMULA_STUDENT, "passenger-car": _PASSENGER_CAR}
