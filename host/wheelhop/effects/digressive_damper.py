"""A damper whose valve blows off: its slope falls beyond a knee velocity."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Becomes, Effect, Values, law
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import Assembly, ends, struts


@law
def blow_off(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """Takes away p[0] of the slope beyond the knee velocity p[1]."""
    beyond = max(abs(v) - p[1], 0.0)
    return (-p[0] * beyond if v > 0.0 else p[0] * beyond), z


class DigressiveDamper(Effect):
    """Beyond the knee the damping rate falls from c to c (1 − loss)."""

    id = "digressive-damper"
    place = "suspension"
    on_rig = True
    becomes = (
        Becomes("knee_m_s", "lower", "dry-friction", "beyond a knee at rest the force is constant"),
    )
    title = "the damper's slope falls beyond a knee velocity"
    equation = (
        r"f = -\lambda c\,(|\dot x| - v_k)\,\mathrm{sgn}\,\dot x \text{ for } |\dot x| > v_k,"
        r"\ 0 \text{ else}"
    )
    source = "J. C. Dixon, The Shock Absorber Handbook, 2nd ed. (Wiley 2007), ch. 7, knee damper"

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Share of the damping lost beyond the knee, per axle; the knee."""
        found = ends(vehicle)
        speed = next(iter(found.values())).usual.speed_m_s
        return (
            *(
                Amplitude(
                    f"{end}_loss",
                    "1",
                    f"share of the damping rate lost beyond the knee, {strut.name}",
                    0.5,
                    lower=0.0,
                    upper=1.0,
                )
                for end, strut in found.items()
            ),
            Shape(
                "knee_m_s",
                "m/s",
                "velocity of the strut beyond which the slope falls",
                speed,
                lower=0.05 * speed,
                starts=(0.25 * speed, 0.75 * speed, 1.5 * speed, 3.0 * speed),
            ),
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the force to each strut."""
        for strut in struts(vehicle):
            lost = theta[f"{strut.end}_loss"] * strut.damping_N_s_m
            parts.add_law(strut.row, blow_off, (lost, theta["knee_m_s"]))
