"""A damper whose oil passes through a fixed orifice."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Values, law
from wheelhop.effects.parameters import Amplitude, Parameter
from wheelhop.vehicle import Assembly, ends, struts


@law
def through_an_orifice(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """p[0] v |v|."""
    return p[0] * v * abs(v), z


class QuadraticDamper(Effect):
    """Turbulent flow through an orifice: beside the linear damping a force that grows with the
    square of the speed."""

    id = "quadratic-damper"
    place = "suspension"
    on_rig = True
    on_vehicle = False
    title = "the damper's force grows with the square of the speed"
    equation = r"f = c_2\,|\dot x|\,\dot x"
    source = (
        "Bernoulli's equation for an orifice, pressure drop proportional to flow squared: J. C."
        " Dixon, The Shock Absorber Handbook, 2nd ed. (Wiley 2007), ch. 5"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The quadratic damping, per axle."""
        return tuple(
            Amplitude(
                f"{end}_N_s2_m2",
                "N·s²/m²",
                f"quadratic damping of {strut.name}",
                0.5 * strut.usual.damping_N_s_m / strut.usual.speed_m_s,
                lower=0.0,
            )
            for end, strut in ends(vehicle).items()
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the force to each strut."""
        for strut in struts(vehicle):
            parts.add_law(strut.row, through_an_orifice, (theta[f"{strut.end}_N_s2_m2"],))
