"""What to hide outside the library: drawn like the effects of `recipes.py`."""

from __future__ import annotations

from benchmarks.blind.folder import Rng
from benchmarks.blind.recipes import Recipe
from benchmarks.blind.strength import Hidden
from benchmarks.blind.vehicles import Car
from tests.truth import CHANNELS
from tests.truth.outside_effects import (
    BoucWenSpring,
    BypassDamping,
    DamperFade,
    FrameBending,
    OrificeDamping,
    OutOfRoundness,
    SensorNonlinearity,
    TyreHysteresis,
    UnlatchedPayload,
)


def _orifice_damping(rng: Rng, car: Car) -> Hidden:
    return Hidden(lambda s: OrificeDamping(0.5 * s, float(car.rate_m_s.max())))


def _damper_fade(rng: Rng, car: Car) -> Hidden:
    return Hidden(lambda s: DamperFade(0.3 * s), most=3.0)


def _bypass_damping(rng: Rng, car: Car) -> Hidden:
    return Hidden(lambda s: BypassDamping(0.5 * s, float(car.travel_m.max())))


def _bouc_wen_spring(rng: Rng, car: Car) -> Hidden:
    force, share = 0.08 * float(car.static_load_N.mean()), rng.uniform(0.1, 0.4)
    return Hidden(lambda s: BoucWenSpring(force * s, share * float(car.travel_m.max())))


def _tyre_hysteresis(rng: Rng, car: Car) -> Hidden:
    ratio = rng.uniform(0.3, 1.0)
    return Hidden(lambda s: TyreHysteresis(0.05 * s, ratio))


def _out_of_roundness(rng: Rng, car: Car) -> Hidden:
    corner = float(rng.integers(1, 5))
    return Hidden(lambda s: OutOfRoundness(5e-4 * s, corner))


def _frame_bending(rng: Rng, car: Car) -> Hidden:
    freq, zeta = rng.uniform(8.0, 24.0), rng.uniform(0.02, 0.08)
    return Hidden(lambda s: FrameBending(freq, zeta, 2.0 * car.vehicle["body.mass_kg"] / s))


def _unlatched_payload(rng: Rng, car: Car) -> Hidden:
    mass = 0.05 * car.vehicle["body.mass_kg"]
    x = car.vehicle["geometry.cg_to_front_axle_m"] - car.vehicle["geometry.wheelbase_m"]
    y = rng.choice([-0.3, 0.3]) * car.vehicle["geometry.track_width_m"]
    freq, zeta = rng.uniform(4.0, 12.0), rng.uniform(0.05, 0.15)
    return Hidden(lambda s: UnlatchedPayload(mass * s, freq, zeta, x, y), most=4.0)


def _sensor_nonlinearity(rng: Rng, car: Car) -> Hidden:
    one, sign = int(rng.integers(len(CHANNELS))), rng.choice([-1.0, 1.0])
    share = sign * 0.1 / float(car.peak_m_s2[one])
    return Hidden(lambda s: SensorNonlinearity(CHANNELS[one], share * s), most=8.0)


OUTSIDE: dict[str, Recipe] = {
    "orifice-damping": _orifice_damping,
    "frame-bending": _frame_bending,
    "unlatched-payload": _unlatched_payload,
    "tyre-hysteresis": _tyre_hysteresis,
    "damper-fade": _damper_fade,
    "out-of-roundness": _out_of_roundness,
    "bouc-wen-spring": _bouc_wen_spring,
    "bypass-damping": _bypass_damping,
    "sensor-nonlinearity": _sensor_nonlinearity,
}
"""In this order: an effect keeps its seeds for good."""
