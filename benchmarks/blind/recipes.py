"""What to hide: for every effect its shape, drawn to suit the car, and its strength, left open."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from benchmarks.blind.folder import Rng
from benchmarks.blind.strength import Hidden
from benchmarks.blind.vehicles import Car
from tests.truth import CHANNELS, make_effect

Recipe = Callable[[Rng, Car], Hidden]


def _law(
    effect_id: str, parameters: Callable[[float], Mapping[str, float | str]], most: float = 20.0
) -> Hidden:
    return Hidden(lambda amount: make_effect(effect_id, parameters(amount)), most)


def speed_fluctuation(rng: Rng, car: Car) -> Hidden:
    """Periods drawn, the fraction is open."""
    shortest, longer = rng.uniform(1.5, 3.5), rng.uniform(2.0, 5.0)
    periods = {"period_min_s": shortest, "period_max_s": shortest + longer}
    return _law("speed-fluctuation", lambda s: {"fraction": 0.001 * s, **periods}, 60.0)


def left_right_drift(rng: Rng, car: Car) -> Hidden:
    """Some only drift, some wander too."""
    rate, wander = rng.choice([-2e-4, 2e-4]), rng.choice([0.0, rng.uniform(2e-4, 2e-3)])
    period = rng.uniform(5.0, 12.0)
    return _law(
        "left-right-drift",
        lambda s: {"rate": rate * s, "wander_m": wander * s, "wander_period_s": period},
        60.0,
    )


def tyre_lift_off(rng: Rng, car: Car) -> Hidden:
    """There or not."""
    return Hidden(lambda s: make_effect("tyre-lift-off", {}), by_severity=True)


def tyre_envelope(rng: Rng, car: Car) -> Hidden:
    """The contact length is open; what it averages differs."""
    length = {"front_m": rng.uniform(0.05, 0.09), "rear_m": rng.uniform(0.05, 0.09)}
    averages = str(rng.choice(["path", "ground"]))
    return _law(
        "tyre-envelope",
        lambda s: {k: v * s for k, v in length.items()} | {"averages": averages},
        4.0,
    )


def small_scale_roughness(rng: Rng, car: Car) -> Hidden:
    """A random road on top of the track, its two paths more or less alike."""
    shape = {"waviness": rng.uniform(1.6, 2.4), "likeness": rng.uniform(0.0, 0.8)}
    return _law("small-scale-roughness", lambda s: {"unevenness_m3": 3e-8 * s**2, **shape})


def progressive_tyre(rng: Rng, car: Car) -> Hidden:
    """Growth over the tyre's largest deflection."""
    growth = rng.uniform(0.1, 0.2) / car.tyre_m
    return _law("progressive-tyre", lambda s: {"growth_per_m": growth * s})


def wheel_imbalance(rng: Rng, car: Car) -> Hidden:
    """One wheel of the four."""
    corner, mass = float(rng.integers(1, 5)), car.vehicle["wheel.front.unsprung_mass_kg"]
    return _law("wheel-imbalance", lambda s: {"imbalance_kg_m": 0.01 * mass * s, "corner": corner})


def progressive_spring(rng: Rng, car: Car) -> Hidden:
    """Cubic; or air, of which there is as much as the static load allows: only its severity is
    open."""
    if rng.random() < 0.4:
        exponent = rng.uniform(1.05, 1.4)
        return Hidden(
            lambda s: make_effect("progressive-spring", {"polytropic_exponent": exponent}),
            by_severity=True,
        )
    share = rng.uniform(0.05, 0.3, 2)
    front, rear = (
        share[k] * car.vehicle[f"suspension.{end}.stiffness_N_m"] / car.travel_m[2 * k] ** 2
        for k, end in enumerate(("front", "rear"))
    )
    return _law(
        "progressive-spring",
        lambda s: {"cubic_front_N_m3": front * s, "cubic_rear_N_m3": rear * s},
    )


def bump_stop(rng: Rng, car: Car) -> Hidden:
    """Engaged over the last part of the travel, some in rebound too; its stiffness is open."""
    share = rng.uniform(0.5, 0.8)
    clearance = share * float(car.travel_m.max())
    shape = {"clearance_m": clearance}
    if rng.random() < 0.4:
        shape["rebound_clearance_m"] = clearance * rng.uniform(1.0, 1.5)
    stiffness = 2.0 * car.vehicle["suspension.front.stiffness_N_m"]
    return _law("bump-stop", lambda s: {**shape, "stiffness_N_m": stiffness * s})


def asymmetric_damper(rng: Rng, car: Car) -> Hidden:
    """Softer in compression."""
    return _law("asymmetric-damper", lambda s: {"asymmetry": 0.05 * s}, 15.0)


def digressive_damper(rng: Rng, car: Car) -> Hidden:
    """A knee within the rates there are; the loss beyond it is open."""
    knee = rng.uniform(0.1, 0.4) * float(car.rate_m_s.max())
    return _law(
        "digressive-damper", lambda s: {"knee_m_s": knee, "slope_ratio": 1.0 - 0.1 * s}, 9.0
    )


def dry_friction(rng: Rng, car: Car) -> Hidden:
    """A few per cent of the static load, unequal between the axles."""
    front, rear = 0.02 * car.static_load_N[[0, 2]] * rng.uniform(0.6, 1.4, 2)
    wheel = min(car.vehicle[f"wheel.{end}.unsprung_mass_kg"] for end in ("front", "rear"))
    presliding = wheel * rng.uniform(100.0, 300.0) ** 2  # rad/s of the wheel on the stuck joint
    return _law(
        "dry-friction",
        lambda s: {
            "coulomb_front_N": front * s,
            "coulomb_rear_N": rear * s,
            "presliding_N_m": presliding,
        },
    )


def backlash(rng: Rng, car: Car) -> Hidden:
    """The gap is open."""
    return _law("backlash", lambda s: {"gap_m": 0.001 * s}, 10.0)


def mount_bushing(rng: Rng, car: Car) -> Hidden:
    """More or less damped; its compliance is open."""
    stiffness = rng.uniform(5.0, 12.0) * car.vehicle["suspension.front.stiffness_N_m"]
    damping = rng.uniform(0.05, 0.4) * car.vehicle["suspension.front.damping_N_s_m"]
    return _law(
        "mount-bushing", lambda s: {"stiffness_N_m": stiffness / s, "damping_N_s_m": damping}
    )


def anti_roll_bar(rng: Rng, car: Car) -> Hidden:
    """On one axle or both."""
    front, rear = rng.permutation([rng.uniform(0.1, 0.3), rng.choice([0.0, rng.uniform(0.0, 0.3)])])
    stiffness = car.vehicle["suspension.front.stiffness_N_m"]
    return _law(
        "anti-roll-bar",
        lambda s: {
            "stiffness_front_N_m": front * stiffness * s,
            "stiffness_rear_N_m": rear * stiffness * s,
        },
    )


def corner_asymmetry(rng: Rng, car: Car) -> Hidden:
    """One corner, its spring and its damper apart."""
    corner, sign = float(rng.integers(1, 5)), rng.choice([-1.0, 1.0], 2)
    spring, damper = sign * rng.uniform(0.05, 0.25, 2)
    return _law(
        "corner-asymmetry",
        lambda s: {"corner": corner, "stiffness_change": spring * s, "damping_change": damper * s},
        3.5,
    )


def driver_seat(rng: Rng, car: Car) -> Hidden:
    """A driver near the place stated; how much of him moves is open, or how soft his seat is."""
    mass = car.vehicle["driver.mass_kg"] * rng.uniform(0.75, 1.05)
    freq, zeta = rng.uniform(2.5, 6.0), rng.uniform(0.15, 0.45)
    x = car.vehicle["driver.x_m"] + rng.uniform(-0.05, 0.05)
    place = {"zeta": zeta, "x_m": x, "y_m": car.vehicle["driver.y_m"]}
    if rng.random() < 0.5:  # a stiffer seat shows less
        return _law(
            "driver-seat", lambda s: {"mass_kg": mass, "freq_hz": freq / np.sqrt(s), **place}
        )
    return _law("driver-seat", lambda s: {"mass_kg": 0.5 * mass * s, "freq_hz": freq, **place}, 2.5)


def driver_rocking(rng: Rng, car: Car) -> Hidden:
    """The inertia that sways is open."""
    inertia = rng.uniform(0.08, 0.2) * car.vehicle["body.roll_inertia_kg_m2"]
    shape = {"freq_hz": rng.uniform(1.5, 5.0), "zeta": rng.uniform(0.1, 0.4)}
    return _law("driver-rocking", lambda s: {"roll_inertia_kg_m2": inertia * s, **shape}, 4.0)


def engine_vibration(rng: Rng, car: Car) -> Hidden:
    """A force at the engine between 10 and 28 Hz."""
    force = 0.2 * car.vehicle["body.mass_kg"]
    place = {"x_m": car.vehicle["engine.x_m"], "y_m": car.vehicle["engine.y_m"]}
    freq = rng.uniform(10.0, 28.0)
    return _law("engine-vibration", lambda s: {"force_N": force * s, "freq_hz": freq, **place})


def frame_twist(rng: Rng, car: Car) -> Hidden:
    """A mode between 6 and 20 Hz; its mobility is open."""
    half_width = car.vehicle["geometry.track_width_m"] / 2.0
    mass = car.vehicle["body.roll_inertia_kg_m2"] / half_width**2
    shape = {"freq_hz": rng.uniform(6.0, 20.0), "zeta": rng.uniform(0.02, 0.08)}
    return _law("frame-twist", lambda s: {**shape, "modal_mass_kg": 4.0 * mass / s})


def longitudinal_pitch(rng: Rng, car: Car) -> Hidden:
    """The driver brakes and accelerates all the time; how hard is open."""
    periods = _sway_periods(rng)
    return _law("longitudinal-pitch", lambda s: {"peak_m_s2": 0.5 * s, **periods})


def cornering_roll(rng: Rng, car: Car) -> Hidden:
    """The driver steers to and fro; how hard is open."""
    periods = _sway_periods(rng)
    return _law("cornering-roll", lambda s: {"peak_m_s2": 0.5 * s, **periods})


def _sway_periods(rng: Rng) -> dict[str, float]:
    shortest = rng.uniform(0.6, 1.2)
    return {"period_min_s": shortest, "period_max_s": shortest * rng.uniform(1.8, 3.0)}


def sensor_gain(rng: Rng, car: Car) -> Hidden:
    """One channel, too much or too little."""
    channel, error = str(rng.choice(CHANNELS)), rng.choice([-0.05, 0.05])
    return _law("sensor-gain", lambda s: {"channel": channel, "gain_error": error * s}, 10.0)


def sensor_polarity(rng: Rng, car: Car) -> Hidden:
    """One channel inverted, or two exchanged."""
    one, other = (str(c) for c in rng.choice(CHANNELS, 2, replace=False))
    swapped = {"swapped_with": other} if rng.random() < 0.5 else {}
    return Hidden(
        lambda s: make_effect("sensor-polarity", {"channel": one, **swapped}), by_severity=True
    )


def sensor_skew(rng: Rng, car: Car) -> Hidden:
    """Up to an eighth of a sample between columns."""
    return _law("sensor-skew", lambda s: {"skew_s": 3e-4 * s}, 4.0)


def sensor_clipping(rng: Rng, car: Car) -> Hidden:
    """One channel, or all of them at the same limit."""
    one = int(rng.integers(len(CHANNELS)))
    peak, channel = float(car.peak_m_s2.max()), "all"
    if rng.random() < 0.5:
        peak, channel = float(car.peak_m_s2[one]), CHANNELS[one]
    return _law(
        "sensor-clipping", lambda s: {"limit_m_s2": peak / (1.0 + 0.25 * s), "channel": channel}
    )


def sensor_mount(rng: Rng, car: Car) -> Hidden:
    """One channel on a bracket; how soft is open."""
    channel, zeta = str(rng.choice(CHANNELS)), rng.uniform(0.02, 0.1)
    return _law(
        "sensor-mount",
        lambda s: {"channel": channel, "freq_hz": 40.0 / np.sqrt(s), "zeta": zeta},
        5.0,
    )


RECIPES: dict[str, Recipe] = {
    "speed-fluctuation": speed_fluctuation,
    "left-right-drift": left_right_drift,
    "tyre-envelope": tyre_envelope,
    "small-scale-roughness": small_scale_roughness,
    "progressive-tyre": progressive_tyre,
    "tyre-lift-off": tyre_lift_off,
    "wheel-imbalance": wheel_imbalance,
    "progressive-spring": progressive_spring,
    "bump-stop": bump_stop,
    "asymmetric-damper": asymmetric_damper,
    "digressive-damper": digressive_damper,
    "dry-friction": dry_friction,
    "backlash": backlash,
    "mount-bushing": mount_bushing,
    "anti-roll-bar": anti_roll_bar,
    "corner-asymmetry": corner_asymmetry,
    "driver-seat": driver_seat,
    "driver-rocking": driver_rocking,
    "engine-vibration": engine_vibration,
    "frame-twist": frame_twist,
    "longitudinal-pitch": longitudinal_pitch,
    "cornering-roll": cornering_roll,
    "sensor-gain": sensor_gain,
    "sensor-polarity": sensor_polarity,
    "sensor-skew": sensor_skew,
    "sensor-clipping": sensor_clipping,
    "sensor-mount": sensor_mount,
}
