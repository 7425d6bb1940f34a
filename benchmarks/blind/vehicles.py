"""Vehicles that differ more than the simulator's presets do, and how far they move."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tests.truth import PRESETS, Preset, Run, integrate
from tests.truth.presets import draw_vehicles, planned_runs
from tests.truth.vehicle import Vehicle, suspension_static_load

Array = NDArray[np.float64]

LOUD = (  # among the runs of a short campaign: fitted, and held out
    ("chassis-twist-low-fast", "washboard-high-fast"),
    ("chassis-twist-medium-fast", "herringbone-high-fast"),
)
COARSE_STEP_S = 1e-3
LOOK_S = 4.0


def varied(name: str, rng: np.random.Generator) -> Preset:
    """A preset's vehicle grown, loaded, sprung and damped differently, its speeds off by 10 %.

    Stiffness follows mass, so that the natural frequencies of the body and of the wheels stay
    within 15 % of the preset's.
    """
    preset = PRESETS[name]
    size, mass, wheel_mass = rng.uniform(0.9, 1.1), rng.uniform(0.8, 1.25), rng.uniform(0.75, 1.3)
    wheel_hz_squared, damping = rng.uniform(0.85, 1.15) ** 2, rng.uniform(0.7, 1.4)
    factor = {
        "geometry.wheelbase_m": size,
        "geometry.track_width_m": size,
        "geometry.cg_height_m": size,
        "body.mass_kg": mass,
        "body.pitch_inertia_kg_m2": mass * size**2 * rng.uniform(0.85, 1.15),
        "body.roll_inertia_kg_m2": mass * size**2 * rng.uniform(0.85, 1.15),
        "driver.x_m": size,
        "driver.y_m": size,
        "engine.x_m": size,
        "engine.y_m": size,
    }
    for end in ("front", "rear"):
        factor |= {
            f"suspension.{end}.stiffness_N_m": mass * rng.uniform(0.85, 1.15) ** 2,
            f"suspension.{end}.damping_N_s_m": mass * damping * rng.uniform(0.9, 1.1),
            f"wheel.{end}.unsprung_mass_kg": wheel_mass,
            f"wheel.{end}.tyre_stiffness_N_m": wheel_mass * wheel_hz_squared,
            f"wheel.{end}.tyre_damping_N_s_m": wheel_mass * rng.uniform(0.6, 1.5),
        }
    vehicle = {k: float(f"{v * factor.get(k, 1.0):.4g}") for k, v in preset.vehicle.items()}
    ahead = preset.vehicle["geometry.cg_to_front_axle_m"] + rng.uniform(-0.06, 0.06)
    vehicle["geometry.cg_to_front_axle_m"] = float(f"{ahead * size:.4g}")
    pace = rng.uniform(0.9, 1.1)
    surfaces = [
        s._replace(slow_kmph=round(s.slow_kmph * pace, 1), fast_kmph=round(s.fast_kmph * pace, 1))
        for s in preset.surfaces
    ]
    return Preset(preset.name, vehicle, tuple(surfaces))


def rougher(preset: Preset, severity: float) -> Preset:
    """The same vehicle on tracks of `severity` times the height."""
    surfaces = [s._replace(amplitude_mm=s.amplitude_mm * severity) for s in preset.surfaces]
    surfaces = [s._replace(amplitude_mm=float(f"{s.amplitude_mm:.4g}")) for s in surfaces]
    return replace(preset, surfaces=tuple(surfaces))


@dataclass(frozen=True)
class Car:
    """The true vehicle and how far it moves on loud tracks, both fitted and held out, when nothing
    is hidden in it."""

    vehicle: Vehicle
    static_load_N: Array  # (4,) on the suspensions
    travel_m: Array  # (4,) largest compression of each suspension
    rate_m_s: Array  # (4,) its largest rate
    tyre_m: float  # largest deflection of a tyre
    peak_m_s2: Array  # (8,) largest acceleration of each channel


def car_of(preset: Preset, seed: int) -> Car:
    """The car that a campaign of this seed will hold."""
    vehicle, _ = draw_vehicles(preset, np.random.default_rng(seed))
    planned = planned_runs(preset, short=True, lateral_offset_mm=0.0)
    largest = []
    for names in LOUD:
        runs = [
            Run(plan.track, plan.speed_kmph / 3.6, 35.0, np.array([0.0, LOOK_S]))
            for plan in planned
            if plan.id in names
        ]
        largest.append(np.max([_extent(vehicle, run) for run in runs], axis=0))
    travel, rate, tyre, peak = np.split(np.min(largest, axis=0), [4, 8, 12])
    return Car(
        vehicle=vehicle,
        static_load_N=np.asarray(suspension_static_load(vehicle)),
        travel_m=travel,
        rate_m_s=rate,
        tyre_m=float(tyre.max()),
        peak_m_s2=peak,
    )


def _extent(vehicle: Vehicle, run: Run) -> Array:
    """Largest travel, rate and tyre deflection per corner, acceleration per channel (20,)."""
    motion = integrate(vehicle, run, step_s=COARSE_STEP_S)
    body, axle = slice(0, 4), slice(4, 8)
    seen = [
        motion.position[:, axle] - motion.position[:, body],
        motion.velocity[:, axle] - motion.velocity[:, body],
        motion.road - motion.position[:, axle],
        np.gradient(motion.velocity, motion.time, axis=0),
    ]
    return np.asarray(np.max(np.abs(np.hstack(seen)[motion.time > 0.0]), axis=0))
