"""A damper that resists rebound more than compression."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Values, law
from wheelhop.effects.parameters import Amplitude, Parameter
from wheelhop.vehicle import Assembly, ends, struts


@law
def one_sided_difference(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """Adds p[0] to the damping in rebound (v > 0), takes it away in compression."""
    return p[0] * abs(v), z


class AsymmetricDamper(Effect):
    """Rebound and compression damping differ by twice the parameter, about the same mean."""

    id = "asymmetric-damper"
    place = "suspension"
    on_rig = True
    title = "rebound and compression damping differ"
    equation = r"f = a\,|\dot x|,\quad a = (c_\mathrm{rebound} - c_\mathrm{compression})/2"
    source = (
        "J. C. Dixon, The Shock Absorber Handbook, 2nd ed. (Wiley 2007), ch. 7, bilinear damper"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Half the difference of the two damping rates, per axle."""
        return tuple(
            Amplitude(
                f"{end}_N_s_m",
                "N·s/m",
                f"half of rebound less compression damping, {strut.name}",
                0.4 * strut.usual.damping_N_s_m,
            )
            for end, strut in ends(vehicle).items()
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the force to each strut."""
        for strut in struts(vehicle):
            parts.add_law(strut.row, one_sided_difference, (theta[f"{strut.end}_N_s_m"],))
