"""What no vehicle has, and numbers that nobody replaced: vehicle.toml read as an engineer would."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from math import pi, sqrt

from scipy.special import bdtrc

from wheelhop.campaign.change import Proposal
from wheelhop.campaign.sample import VEHICLE
from wheelhop.gate.finding import FALSE_ALARM, Finding
from wheelhop.gate.fixes import in_vehicle
from wheelhop.vehicle import Vehicle, axles, wheels

CHANCE_ALIKE = 0.1
"""That a number of one's own agrees with the sample's in all its digits: most are round."""

MILLI = 1e-3
"""What a number in millimetres, or per millimetre, is off by."""
LENGTHS_M = {
    "geometry.wheelbase_m": (0.3, 15.0),
    "geometry.track_width_m": (0.2, 5.0),
    "geometry.cg_height_m": (0.02, 5.0),
    "wheel.front.radius_m": (0.03, 2.0),
    "wheel.rear.radius_m": (0.03, 2.0),
}
"""From a soap-box car to a dump truck: what lies outside is in another unit."""
BODY_HZ = (0.3, 15.0)
WHEEL_HZ = (3.0, 60.0)
DAMPING_RATIO = (0.005, 5.0)
GYRATION = (0.1, 1.2)  # radius over wheelbase or track width
UNSPRUNG = (0.005, 1.5)  # mass over a quarter of the body's


def number_findings(vehicle: Vehicle) -> Iterator[Finding]:
    """Of vehicle.toml: what no vehicle has, and what nobody replaced."""
    yield from impossible(vehicle)
    yield from _left_over(vehicle)


def impossible(vehicle: Vehicle) -> Iterator[Finding]:
    """Numbers that no vehicle has, each under the key that is likeliest to be wrong."""
    for key, (low, high) in LENGTHS_M.items():
        if key in vehicle.values and not low <= vehicle[key] <= high:
            yield _no_vehicle(
                key,
                f"{key} = {vehicle[key]:g}",
                f"vehicles have {low:g} to {high:g} m",
                (in_vehicle(f"Write {key} in metres", {key: MILLI * vehicle[key]}),),
            )
    yield from _dynamics(vehicle.values)


def _dynamics(v: Mapping[str, float]) -> Iterator[Finding]:
    quarter = v["body.mass_kg"] / len(wheels(v))
    for end in axles(v):
        spring, wheel = f"suspension.{end}.stiffness_N_m", f"wheel.{end}.unsprung_mass_kg"
        tyre, damper = f"wheel.{end}.tyre_stiffness_N_m", f"suspension.{end}.damping_N_s_m"
        body_hz = sqrt(v[spring] / quarter) / (2 * pi)
        yield from _outside(spring, v, body_hz, BODY_HZ, "the body on its springs", "Hz")
        mass = v[wheel] / quarter
        yield from _outside(wheel, v, mass, UNSPRUNG, "the share of the body's mass per wheel", "")
        hop_hz = sqrt((v[spring] + v[tyre]) / v[wheel]) / (2 * pi)
        if UNSPRUNG[0] <= mass <= UNSPRUNG[1] and BODY_HZ[0] <= body_hz <= BODY_HZ[1]:
            yield from _outside(tyre, v, hop_hz, WHEEL_HZ, "the wheel on its tyre", "Hz")
            ratio = v[damper] / (2 * sqrt(v[spring] * quarter))
            if v[damper] > 0.0:
                yield from _outside(damper, v, ratio, DAMPING_RATIO, "the damping ratio", "")
    for key, length in (
        ("body.pitch_inertia_kg_m2", "geometry.wheelbase_m"),
        ("body.roll_inertia_kg_m2", "geometry.track_width_m"),
    ):
        if key in v and LENGTHS_M[length][0] <= v[length] <= LENGTHS_M[length][1]:
            share = sqrt(v[key] / v["body.mass_kg"]) / v[length]
            yield from _outside(key, v, share, GYRATION, "the radius of gyration over the", length)


def _outside(
    key: str,
    v: Mapping[str, float],
    value: float,
    bounds: tuple[float, float],
    what: str,
    unit: str,
) -> Iterator[Finding]:
    if not bounds[0] <= value <= bounds[1]:
        times = MILLI if value > bounds[1] else 1.0 / MILLI
        if unit.startswith("geometry."):
            what, unit = f"{what} {unit[9:-2].replace('_', ' ')}", ""
        unit = f" {unit}" if unit else ""
        yield _no_vehicle(
            key,
            f"{key} = {v[key]:g} puts {what} at {value:.3g}{unit}",
            f"vehicles have {bounds[0]:g} to {bounds[1]:g}{unit}",
            (in_vehicle(f"Write {key} × {times:g}", {key: v[key] * times}),),
        )


def _no_vehicle(key: str, what: str, usual: str, fixes: tuple[Proposal, ...]) -> Finding:
    return Finding(
        "before",
        "no-vehicle",
        key,
        f"{what}; {usual}.",
        "Look at its unit: keys take N/m, N s/m, kg, kg m² and m; 10.5 N/mm is 10500 N/m.",
        "certain",
        fixes,
    )


def _left_over(vehicle: Vehicle) -> Iterator[Finding]:
    sample = dict(_flat(tomllib.loads(VEHICLE.format(title='""'))))
    relative = float(sample.pop("relative_uncertainty"))
    keys = [key for key in sample if key in vehicle.values and vehicle[key] != 0.0]
    alike = [
        key
        for key in keys
        if vehicle[key] == sample[key]
        and abs(vehicle.uncertainty[key] - relative * abs(vehicle[key])) < 1e-9 * abs(vehicle[key])
    ]
    if bdtrc(len(alike) - 1, len(keys), CHANCE_ALIKE) < FALSE_ALARM:
        names = "" if len(alike) == len(keys) else f": {', '.join(alike)}"
        yield Finding(
            "before",
            "template",
            "vehicle.toml",
            f"{len(alike)} of {len(keys)} numbers in vehicle.toml are those of the sample file,"
            f" a student-built ATV{names}.",
            "Put in your own, and how sure you are of them.",
            "certain",
        )


def _flat(table: Mapping[str, object], prefix: str = "") -> Iterator[tuple[str, float]]:
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{key}.")
        elif isinstance(value, float):
            yield prefix + key, value
