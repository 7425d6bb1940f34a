"""Turbulent flow through a damper's orifice, an effect for wheelhop."""

from collections.abc import Mapping, Sequence

from wheelhop.campaign import Channel
from wheelhop.effects import Amplitude, Effect, Parameter, law
from wheelhop.vehicle import Assembly, ends, struts


@law
def orifice(x, v, dx, dt, z, p):  # type: ignore[no-untyped-def]
    """p[0] v |v|: opposes the motion, grows with its square."""
    return p[0] * v * abs(v), z


class OrificeDamper(Effect):
    """A force proportional to velocity squared, beside the linear damper of every strut."""

    id = "orifice-damper"
    place = "suspension"
    title = "the damper's force grows with velocity squared"
    equation = r"f = c_2 |\dot x| \dot x"
    source = "Bernoulli's equation for an orifice: pressure drop proportional to flow squared"
    on_rig = True

    def parameters_for(
        self, vehicle: Mapping[str, float], channels: Sequence[Channel]
    ) -> Sequence[Parameter]:
        """One amplitude for each axle; its scale is as much force as c v at 1 m/s."""
        return tuple(
            Amplitude(
                f"{end}_N_s2_m2",
                "N·s²/m²",
                f"quadratic damping of {strut.name}",
                scale=strut.usual.damping_N_s_m,
                lower=0.0,
            )
            for end, strut in ends(vehicle).items()
        )

    def modify(
        self, theta: Mapping[str, float], vehicle: Mapping[str, float], parts: Assembly
    ) -> None:
        """Add the law to every strut."""
        for strut in struts(vehicle):
            parts.add_law(strut.row, orifice, (theta[f"{strut.end}_N_s2_m2"],))
