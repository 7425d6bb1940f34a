"""A spring that stiffens with travel."""

from __future__ import annotations

from collections.abc import Sequence
from math import copysign

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Values, law
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import COMPONENT, Assembly, Strut, ends, struts

POLYTROPIC_EXPONENT = 1.3
"""Between isothermal (1) and adiabatic (1.4): a small gas volume at some hertz."""


@law
def cubic(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] x³."""
    return p[0] * x * x * x, z


@law
def gas(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """What a polytropic gas spring of static load p[0], inverse column length p[1] and exponent
    p[2] adds to its own tangent. In compression the column cannot become shorter than a tenth."""
    stretch = p[1] * x
    column = max(1.0 + stretch, 0.1)
    return p[0] * (1.0 - column ** (-p[2]) - p[2] * stretch), z


class ProgressiveSpring(Effect):
    """Gas or cubic: the linear rate stays vehicle.toml's, the effect is what departs from it."""

    id = "progressive-spring"
    place = "suspension"
    on_rig = True
    title = "spring stiffness grows with travel: air spring or cubic"
    equation = (
        r"\text{air: } f = F_0\,[1 - (1 + x/h)^{-n} - n x/h],\ n = 1.3;"
        r"\quad \text{cubic: } f = k_3 x^3"
    )
    source = (
        "polytropic column about its static load F0, e.g. M. Mitschke, H. Wallentowitz, Dynamik der"
        " Kraftfahrzeuge, 5th ed. (Springer 2014), ch. 13; the thesis's Fox Float shocks (4.1.1)"
    )

    def __init__(self, form: str = "air") -> None:
        self.form = form

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """Two laws."""
        return ("air", "cubic")

    def with_choice(self, choice: str) -> ProgressiveSpring:
        """This effect with the law `choice`."""
        return ProgressiveSpring(choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Inverse length of the gas column, or the cubic rate, per axle. On a rig neither the load
        that the gas carries nor which way compresses it is known: the load is left free, too."""
        law = _column if self.form == "air" else _cubic
        return [p for end, strut in ends(vehicle).items() for p in law(end, strut)]

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the force to each strut."""
        for strut in struts(vehicle):
            if self.form == "cubic":
                parts.add_law(strut.row, cubic, (theta[f"{strut.end}_N_m3"],))
                continue
            inverse = theta[f"{strut.end}_1_m"]
            load = theta.get(f"{strut.end}_N", strut.static_load_N)
            parts.add_law(strut.row, gas, (load, copysign(inverse, load), POLYTROPIC_EXPONENT))


def _column(end: str, strut: Strut) -> Sequence[Parameter]:
    meaning = f"inverse length of the gas column of {strut.name}"
    if strut.end == COMPONENT:
        load = "load on the gas at displacement 0; negative: pulling compresses it"
        short = 1.0 / strut.usual.travel_m
        starts = (0.2 * short, 0.5 * short)
        return (
            Amplitude(f"{end}_N", "N", load, strut.usual.load_N),
            Shape(
                f"{end}_1_m",
                "1/m",
                meaning,
                0.3 * short,
                lower=0.0,
                upper=1.5 * short,
                starts=starts,
            ),
        )
    # A strut carried by gas alone has n F0 / h for its rate.
    whole = strut.stiffness_N_m / (POLYTROPIC_EXPONENT * strut.static_load_N)
    return (Amplitude(f"{end}_1_m", "1/m", meaning, whole, lower=0.0, upper=4 * whole),)


def _cubic(end: str, strut: Strut) -> Sequence[Parameter]:
    meaning = f"cubic rate of the spring of {strut.name}"
    scale = strut.usual.stiffness_N_m / strut.usual.travel_m**2
    return (Amplitude(f"{end}_N_m3", "N/m³", meaning, scale, lower=0.0),)
