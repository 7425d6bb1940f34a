"""The frame is not rigid: its first torsional mode."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

from wheelhop.campaign import Channel
from wheelhop.effects.base import Becomes, Effect, Values
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import Assembly


class FrameTwist(Effect):
    """Front and rear of the body roll against each other: one flexible mode."""

    id = "frame-twist"
    place = "body"
    becomes = (Becomes("freq_hz", "upper", "a rigid body", "a mode beyond the band hardly moves"),)
    needs_motions = ("pitch", "roll")
    title = "the frame's first torsional mode"
    equation = (
        r"z(x, y) = z - x\theta + y\phi + \tau\,\frac{(x - x_m)\,y}{(L/2)(t/2)},"
        r"\quad m_\tau(\ddot\tau + 2\zeta\omega\dot\tau + \omega^2\tau) = f_\tau"
    )
    source = (
        "mode superposition, e.g. L. Meirovitch, Fundamentals of Vibrations (McGraw-Hill 2001),"
        " ch. 7; uniform twist, zero in the middle of the wheelbase (x_m), as shape"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Inverse modal mass, frequency and damping of the twist of a frame without wheels."""
        return (
            Amplitude(
                "participation_1_kg",
                "1/kg",
                "inverse modal mass (mode shape ±1 at the corners)",
                5.0 / vehicle["body.mass_kg"],
                lower=0.0,
            ),
            Shape(
                "freq_hz",
                "Hz",
                "frequency of the mode",
                5.0,
                lower=3.0,
                upper=60.0,
                starts=(8.0, 12.0, 18.0, 26.0, 5.3),
            ),
            Shape("zeta", "1", "its damping ratio", 0.04, lower=0.003, upper=0.5, starts=(0.05,)),
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the mode: every point of the body takes part in it."""
        participation = theta["participation_1_kg"]
        if participation < 1e-6 / vehicle["body.mass_kg"]:
            return
        mass, omega = 1.0 / participation, 2 * pi * theta["freq_hz"]
        area = vehicle["geometry.wheelbase_m"] * vehicle["geometry.track_width_m"] / 4
        middle = vehicle["geometry.cg_to_front_axle_m"] - vehicle["geometry.wheelbase_m"] / 2
        twist = parts.add_body_mode("frame twist", lambda x, y: (x - middle) * y / area)
        parts.add_mass(((1.0, twist),), mass)
        parts.add_spring(((1.0, twist),), mass * omega**2, 2 * theta["zeta"] * mass * omega)
