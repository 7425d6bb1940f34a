"""The driver is not bolted to the frame: the upper body sways sideways."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

from wheelhop.campaign import Channel
from wheelhop.effects.base import Becomes, Effect, Values
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import Assembly, between
from wheelhop.vehicle.assembly import Coordinate

ARM_M = 0.3
"""Radius of gyration, about the roll axis, of what sways: half an upper body's height."""

LEAN_1_M = 2.5
"""Mass × height per inertia of a rod of an upper body's height, 0.6 m, that stands on its end."""


class DriverRocking(Effect):
    """Part of the body's roll inertia sits on a torsional spring and damper. It stands upright: as
    it leans, its mass comes down, which is felt in heave at twice the frequency of large rolls."""

    id = "driver-rocking"
    place = "body"
    becomes = (
        Becomes(
            "freq_hz", "upper", "body.roll_inertia_kg_m2", "held stiffly he rolls with the body"
        ),
    )
    needs_motions = ("roll",)
    title = "the driver sways laterally on a torsional restraint (roll)"
    equation = (
        r"I_d \ddot\phi_d = -k (\phi_d - \phi) - c (\dot\phi_d - \dot\phi),"
        r"\ k = I_d (2\pi f)^2,\ c = 4\pi \zeta f I_d; \quad F_z = \frac{1}{2} \lambda I_d"
        r" \frac{d^2}{dt^2}(\phi_d^2 - \phi^2),\ M_d = \lambda I_d \ddot z \phi_d,"
        r"\ M = -\lambda I_d \ddot z \phi"
    )
    source = (
        "one-mass model of the seated human in the lateral direction: T. E. Fairley, M. J. Griffin,"
        " J. Sound Vib. 139 (1990) 299 (resonances near 0.7 and 2 Hz, 1.5 Hz with a backrest)"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Roll inertia that sways, the resonance of the restraint, and how high its mass is."""
        inertia = vehicle.get("driver.mass_kg", 75.0) * ARM_M**2
        return (
            Amplitude(
                "inertia_kg_m2",
                "kg·m²",
                "roll inertia that sways, part of body.roll_inertia_kg_m2",
                inertia,
                lower=0.0,
                upper=0.8 * vehicle["body.roll_inertia_kg_m2"],
            ),
            Shape(
                "freq_hz",
                "Hz",
                "resonance of the driver on the restraint",
                1.5,
                lower=0.5,
                upper=15.0,
                starts=(1.2, 2.2, 3.8, 6.5),
            ),
            Shape("zeta", "1", "its damping ratio", 0.15, lower=0.02, upper=1.5, starts=(0.3,)),
            Shape(
                "lean_1_m",
                "1/m",
                "mass × height of what sways, per its inertia",
                LEAN_1_M / 2,
                lower=0.0,
                upper=4 * LEAN_1_M,
                starts=(LEAN_1_M,),
            ),
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Move the inertia from the body to the restraint."""
        inertia, omega = theta["inertia_kg_m2"], 2 * pi * theta["freq_hz"]
        if inertia < 1e-6 * vehicle["body.roll_inertia_kg_m2"]:
            return
        body, driver = Coordinate("roll"), parts.add_coordinate("driver roll")
        parts.add_mass(((1.0, body),), -inertia)
        parts.add_mass(((1.0, driver),), inertia)
        damping = 2 * theta["zeta"] * inertia * omega
        parts.add_spring(between(driver, body), inertia * omega**2, damping)
        if moment := theta.get("lean_1_m", 0.0) * inertia:
            # The body's centre of mass is known with him upright: what he takes with him, it lacks.
            for sways, sign in ((driver, 1.0), (body, -1.0)):
                parts.add_upright(((1.0, Coordinate("heave")),), ((1.0, sways),), sign * moment)
