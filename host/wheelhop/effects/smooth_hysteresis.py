"""A force that unloads along another path than it loads, and need not have a limit."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Becomes, Effect, RunSetting, Values, law
from wheelhop.effects.dry_friction import LONGEST_STEP_S
from wheelhop.effects.hysteresis import bouc_wen
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import Assembly, ends, struts


@law
def beside_its_tangent(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """Bouc and Wen's force less that of a spring as stiff as its first slope, p[0] / p[1]."""
    force, z = bouc_wen(x, v, dx, dt, z, p)
    return force - p[0] / p[1] * x, z


class SmoothHysteresis(Effect):
    """Bouc and Wen's law in full: a force that depends on the way come and not on its speed.
    Loading it softens towards a limit, stays straight or hardens; unloading is stiffer. The
    component's stiffness is that of small motion, this law's first slope included; the effect is
    what departs from it. Stranded wire, leaf springs and joints that tighten as they are loaded
    behave so; a force that reaches its limit within the motion is dry friction."""

    id = "smooth-hysteresis"
    place = "suspension"
    on_rig = True
    on_vehicle = False
    title = "hysteresis without a limit: unloading is stiffer than loading, which may harden"
    becomes = (
        Becomes("softening", "upper", "dry-friction", "softening to a limit, it is friction"),
    )
    equation = (
        r"f = F (z - x / d),\quad d\,\dot z = \dot x\,(1 - |z|\,"
        r"(\frac{1}{2}\,\mathrm{sgn}(\dot x z) + h - \frac{1}{2}))"
    )
    longest_step_s = LONGEST_STEP_S["smooth"]
    source = (
        "Y.-K. Wen, Method for random vibration of hysteretic systems, J. Eng. Mech. Div. ASCE 102"
        " (1976) 249, exponent 1, γ + δ of either sign: J.-P. Noël, M. Schoukens, Hysteretic"
        " benchmark with a dynamic nonlinearity, Workshop on Nonlinear System Identification"
        " Benchmarks (2016), eq. 2"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Force per axle; the way on which the slopes of loading and unloading part, and whether
        loading softens."""
        found = ends(vehicle)
        travel = next(iter(found.values())).usual.travel_m
        return (
            *(
                Amplitude(
                    f"{end}_N",
                    "N",
                    f"first slope of {strut.name}’s hysteresis times the way",
                    0.2 * strut.usual.load_N,
                    lower=0.0,
                )
                for end, strut in found.items()
            ),
            Shape(
                "way_m",
                "m",
                "way on which the slopes of loading and unloading part by as much as the first one",
                0.2 * travel,
                lower=0.01 * travel,
                upper=10.0 * travel,
                starts=(0.2 * travel, travel),
            ),
            Shape(
                "softening",
                "1",
                "1/2: loading softens to twice the force, 0: it is straight, below: it hardens",
                0.2,
                lower=-1.0,
                upper=0.5,
                starts=(-0.2, 0.2),
            ),
        )

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """What the motion before the record has left: it is forgotten slowly."""
        meaning = "force as the record begins, over the first slope times the way"
        return (Shape("initial", "1", meaning, 1.0, starts=(0.0,)),)

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the element to each strut."""
        softening = theta["softening"]
        shape = (theta["way_m"], softening, 1.0 - softening)
        for strut in struts(vehicle):
            numbers = (theta[f"{strut.end}_N"], *shape)
            parts.add_law(strut.row, beside_its_tangent, numbers, begins=f"{self.id}.initial")
