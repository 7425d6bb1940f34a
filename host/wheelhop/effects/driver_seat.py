"""The driver is not bolted to the frame: a mass on a seat."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, pi

from wheelhop.campaign import Channel
from wheelhop.effects.base import Becomes, Effect, Values
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import Assembly, Body, between, motions, on_mounts

HEAVIER = 1.4
"""So many times what is stated of him a driver weighs at most, with helmet, cushion and luggage."""

AWAY_M = 0.3
"""So far from where vehicle.toml puts him a driver sits at most: the length of a seat's rail."""


class DriverSeat(Effect):
    """Part of the sprung mass sits on a spring and damper (vertical)."""

    id = "driver-seat"
    place = "body"
    becomes = (Becomes("freq_hz", "upper", "body.mass_kg", "a hard seat bolts him to the body"),)
    title = "the driver is a mass on a compliant seat (vertical)"
    equation = (
        r"m_d \ddot z_d = -k_s (z_d - z_s) - c_s (\dot z_d - \dot z_s),"
        r"\ k_s = m_d (2\pi f)^2,\ c_s = 4\pi \zeta f m_d"
    )
    source = (
        "one-mass model of the seated human: ISO 5982:2019 (apparent mass, resonance near 4 to"
        " 5 Hz on a rigid seat, lower on a cushion)"
    )

    def applies_to(self, vehicle: Values) -> bool:
        """Not to a vehicle whose file has the seat already."""
        return "driver" not in on_mounts(vehicle)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Mass that moves on the seat, the seat's resonance, and where it is."""
        x_m, away = vehicle.get("driver.x_m", 0.0), AWAY_M if "driver.x_m" in vehicle else inf
        place = Shape(
            "x_m",
            "m",
            "how far the seat is ahead of the centre of mass",
            0.05,
            lower=x_m - away,
            upper=x_m + away,
            starts=(x_m,),
        )
        stated = vehicle.get("driver.mass_kg", 75.0)
        heaviest = HEAVIER * stated if "driver.mass_kg" in vehicle else inf
        return (
            Amplitude(
                "mass_kg",
                "kg",
                "mass that moves on the seat, part of body.mass_kg",
                stated,
                lower=0.0,
                upper=min(0.8 * vehicle["body.mass_kg"], heaviest),
            ),
            Shape(
                "freq_hz",
                "Hz",
                "resonance of the driver on the seat",
                1.5,
                lower=0.8,
                upper=15.0,
                starts=(2.0, 3.5, 6.0, 10.0),
            ),
            Shape("zeta", "1", "its damping ratio", 0.15, lower=0.02, upper=1.5, starts=(0.3,)),
            *((place,) if "pitch" in motions(vehicle) else ()),
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Move the mass from the body to the seat."""
        mass, omega = theta["mass_kg"], 2 * pi * theta["freq_hz"]
        seat = Body(theta.get("x_m", 0.0), vehicle.get("driver.y_m", 0.0))
        if mass < 1e-6 * vehicle["body.mass_kg"]:
            return
        driver = parts.add_coordinate("driver")
        parts.add_mass(((1.0, seat),), -mass)
        parts.add_mass(((1.0, driver),), mass)
        parts.add_spring(between(driver, seat), mass * omega**2, 2 * theta["zeta"] * mass * omega)
