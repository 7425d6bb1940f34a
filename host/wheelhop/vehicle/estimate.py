"""From what everybody can measure of a vehicle to a whole vehicle.toml: the rest is estimated.

Every estimate has a wide uncertainty and says where it comes from; docs/vehicle-file.md has the
sources, and how to measure each number instead.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import hypot, pi, sqrt

from wheelhop.campaign.types import CampaignError
from wheelhop.files import quoted
from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.vehicle.measured import AXLE, MEASURED, RIDE
from wheelhop.vehicle.vehicle import TABLES

GIVEN, ESTIMATED = "given", "estimated"

SCALES, TAPE_M, SPRING = 0.02, 0.01, 0.05
"""Standard deviations of what is given: weights and springs relative, lengths in metres."""
RIDE_FREQUENCY = 0.10
USUAL_RIDE_HZ, USUAL_RIDE = 1.7, 0.35
UNSPRUNG_SHARE, UNSPRUNG = 0.13, 0.40
STABILITY_FACTOR, HEIGHT = 1.2, 0.25
DYNAMIC_INDEX, PITCH = 0.8, 0.40
ROLL_GYRATION, ROLL = 0.35, 0.60
TYRE_DEFLECTION_M, TYRE = 0.018, 0.40
TYRE_DAMPING_RATIO, TYRE_DAMPING = 0.1, 1.0
DAMPING_RATIO, DAMPING = 0.3, 0.50
USUAL_RADIUS_M, RADIUS = 0.28, 0.15
DRIVER_KG, DRIVER = 75.0, 0.20
DRIVER_PLACE = 0.15  # of wheelbase and track width


@dataclass(frozen=True)
class Axle:
    """What is known of an axle: `load_kg` on both its wheels, driver aboard; `spring_N_m`, the rate
    of one spring, with `motion_ratio`, its travel over the wheel's; or `ride_hz`, the frequency at
    which the body bounces above it, tyres included. None: not known."""

    load_kg: float
    spring_N_m: float | None = None
    motion_ratio: float = 1.0
    ride_hz: float | None = None


@dataclass(frozen=True)
class Known:
    """What is known of a vehicle, in SI."""

    name: str
    front: Axle
    rear: Axle
    wheelbase_m: float
    track_width_m: float
    wheel_radius_m: float | None = None
    driver_kg: float | None = None


@dataclass(frozen=True)
class Number:
    """A value, one standard deviation, and where both come from."""

    value: float
    uncertainty: float
    source: str


def estimate(known: Known) -> dict[str, Number]:
    """The numbers of vehicle.toml by their dotted names.

    Raises CampaignError for a ride frequency that the tyres alone do not allow, and for both a
    spring and a ride frequency of one axle.
    """
    ends = {"front": known.front, "rear": known.rear}
    wheels = {end: _wheel(axle, known.wheel_radius_m) for end, axle in ends.items()}
    unsprung = {end: 2 * wheel["unsprung_mass_kg"].value for end, wheel in wheels.items()}
    sprung = {end: axle.load_kg - unsprung[end] for end, axle in ends.items()}
    mass = sum(sprung.values())
    ahead = known.wheelbase_m * sprung["rear"] / mass
    found = dict(_geometry(known, ahead)) | dict(_body(known, mass, ahead, unsprung))
    for end, axle in ends.items():
        tyre = wheels[end]["tyre_stiffness_N_m"].value
        spring = _spring(end, axle, sprung[end] / 2, tyre)
        damping = 2 * DAMPING_RATIO * sqrt(spring.value * sprung[end] / 2)
        found[f"suspension.{end}.stiffness_N_m"] = spring
        found[f"suspension.{end}.damping_N_s_m"] = _guess(
            damping, DAMPING, f"{DAMPING_RATIO:g} of critical, body on its springs"
        )
        found |= {f"wheel.{end}.{key}": number for key, number in wheels[end].items()}
    return found | dict(_driver(known))


def measured(known: Known) -> dict[str, Number]:
    """What [measured] of vehicle.toml says: the weights and ride frequencies that are given. How
    much of a weight is wheels is a guess, the weight is not."""
    ends = {"front": known.front, "rear": known.rear}
    found = {
        f"{end}_{AXLE}": Number(axle.load_kg, SCALES * axle.load_kg, GIVEN)
        for end, axle in ends.items()
    }
    hz = {end: axle.ride_hz for end, axle in ends.items() if axle.ride_hz is not None}
    return found | {
        f"{end}_{RIDE}": Number(one, RIDE_FREQUENCY * one, GIVEN) for end, one in hz.items()
    }


def vehicle_toml(known: Known, better: Mapping[str, Number] | None = None) -> str:
    """The text of a vehicle.toml; the numbers that are estimated are marked so. Those known
    `better`, by their dotted names, replace them. Raises as `estimate` does."""
    numbers = estimate(known) | dict(better or {})
    lines = [
        "format = 1",
        f"name = {quoted(known.name)}",
        '# A number marked "estimated" is a guess, and its uncertainty is wide. Measure what you',
        "# can, put it in with its uncertainty (one standard deviation), and delete the mark:",
        "# docs/vehicle-file.md says how.",
        f"relative_uncertainty = {SPRING}  # of a number that stands without its own",
    ]
    tables = {
        table: {key: numbers[f"{table}.{key}"] for key in keys}
        for table, keys in TABLES.items()
        if f"{table}.{keys[0]}" in numbers
    }
    for table, stated in {**tables, MEASURED: measured(known)}.items():
        lines += ["", f"[{table}]"]
        for key, number in stated.items():
            lines.append(f"{key} = {number.value:.4g}  # {number.source}")
            lines.append(f"{key}_uncertainty = {number.uncertainty:.2g}")
    return "\n".join(lines) + "\n"


def _guess(value: float, relative: float, source: str) -> Number:
    return Number(value, relative * value, f"{ESTIMATED}: {source}")


def _geometry(known: Known, ahead: float) -> Iterator[tuple[str, Number]]:
    yield "geometry.wheelbase_m", Number(known.wheelbase_m, TAPE_M, GIVEN)
    yield "geometry.track_width_m", Number(known.track_width_m, TAPE_M, GIVEN)
    behind = known.wheelbase_m - ahead
    scales = sqrt(2) * SCALES * ahead * behind / known.wheelbase_m
    yield "geometry.cg_to_front_axle_m", Number(ahead, hypot(scales, TAPE_M), "from the weights")
    yield (
        "geometry.cg_height_m",
        _guess(
            known.track_width_m / (2 * STABILITY_FACTOR),
            HEIGHT,
            f"static stability factor {STABILITY_FACTOR:g}",
        ),
    )


def _body(
    known: Known, mass: float, ahead: float, unsprung: Mapping[str, float]
) -> Iterator[tuple[str, Number]]:
    weighed = SCALES * hypot(known.front.load_kg, known.rear.load_kg)
    uncertainty = hypot(weighed, UNSPRUNG * sum(unsprung.values()))
    yield "body.mass_kg", Number(mass, uncertainty, "the weights less the unsprung masses")
    yield (
        "body.pitch_inertia_kg_m2",
        _guess(
            DYNAMIC_INDEX * mass * ahead * (known.wheelbase_m - ahead),
            PITCH,
            f"dynamic index {DYNAMIC_INDEX:g}",
        ),
    )
    yield (
        "body.roll_inertia_kg_m2",
        _guess(
            mass * (ROLL_GYRATION * known.track_width_m) ** 2,
            ROLL,
            f"radius of gyration {ROLL_GYRATION:g} of the track width",
        ),
    )


def _wheel(axle: Axle, radius_m: float | None) -> dict[str, Number]:
    mass = UNSPRUNG_SHARE * axle.load_kg / 2
    stiffness = axle.load_kg / 2 * STANDARD_GRAVITY_M_S2 / TYRE_DEFLECTION_M
    damping = 2 * TYRE_DAMPING_RATIO * sqrt(stiffness * mass)
    return {
        "unsprung_mass_kg": _guess(mass, UNSPRUNG, f"{UNSPRUNG_SHARE:.0%} of the wheel's load"),
        "tyre_stiffness_N_m": _guess(
            stiffness, TYRE, f"{1e3 * TYRE_DEFLECTION_M:g} mm under its load"
        ),
        "tyre_damping_N_s_m": _guess(
            damping, TYRE_DAMPING, f"{TYRE_DAMPING_RATIO:g} of critical, wheel on its tyre"
        ),
        "radius_m": _guess(USUAL_RADIUS_M, RADIUS, "usual")
        if radius_m is None
        else Number(radius_m, TAPE_M, GIVEN),
    }


def _spring(end: str, axle: Axle, mass: float, tyre: float) -> Number:
    """The rate at the wheel; `mass` is a quarter of the body's."""
    if axle.spring_N_m is not None:
        if axle.ride_hz is not None:
            raise CampaignError(
                f"{end} axle: a spring rate and a ride frequency: give the one you are surer of"
            )
        rate = axle.spring_N_m * axle.motion_ratio**2
        return Number(rate, SPRING * rate, f"{GIVEN}: rate of the spring × motion ratio²")
    hz = axle.ride_hz or USUAL_RIDE_HZ
    ride = mass * (2 * pi * hz) ** 2  # spring and tyre in series
    if ride > tyre / 2:
        raise CampaignError(
            f"{end} axle: {hz:g} Hz takes {ride:.3g} N/m between body and ground, and its tyres "
            f"have {tyre:.3g} N/m: give the spring rate instead"
        )
    rate = ride * tyre / (tyre - ride)
    if axle.ride_hz is None:
        return _guess(rate, 2 * USUAL_RIDE, f"a ride frequency of {hz:g} Hz")
    return Number(rate, 2 * RIDE_FREQUENCY * rate, f"{GIVEN}: from the ride frequency")


def _driver(known: Known) -> Iterator[tuple[str, Number]]:
    if known.driver_kg is None:
        yield "driver.mass_kg", _guess(DRIVER_KG, DRIVER, "usual")
    else:
        yield "driver.mass_kg", Number(known.driver_kg, SCALES * known.driver_kg, GIVEN)
    source = f"{ESTIMATED}: at the centre of mass"
    yield "driver.x_m", Number(0.0, DRIVER_PLACE * known.wheelbase_m, source)
    yield "driver.y_m", Number(0.0, DRIVER_PLACE * known.track_width_m, source)
