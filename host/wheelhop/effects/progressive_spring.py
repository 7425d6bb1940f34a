"""A spring that stiffens with travel."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Parameter, Values, law
from wheelhop.vehicle import CORNERS, Assembly, axle_name, static_load, suspension

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
        """Inverse length of the gas column, or the cubic rate, per axle."""
        parameters = []
        for corner, end in ((0, "front"), (2, "rear")):
            stiffness = vehicle[f"suspension.{end}.stiffness_N_m"]
            if self.form == "air":
                # A strut carried by gas alone has n F0 / h for its rate.
                whole = stiffness / (POLYTROPIC_EXPONENT * static_load(vehicle, corner))
                parameters.append(
                    Parameter(
                        f"{end}_1_m",
                        "1/m",
                        f"inverse length of the {end} gas column",
                        whole,
                        lower=0.0,
                        upper=4 * whole,
                    )
                )
            else:
                parameters.append(
                    Parameter(
                        f"{end}_N_m3",
                        "N/m³",
                        f"cubic rate of the {end} spring at the wheel",
                        stiffness / 0.05**2,
                        lower=0.0,
                    )
                )
        return parameters

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the force to each strut."""
        for i in CORNERS:
            strut, end = suspension(vehicle, i), axle_name(i)
            if self.form == "air":
                load = static_load(vehicle, i)
                parts.add_law(strut, gas, (load, theta[f"{end}_1_m"], POLYTROPIC_EXPONENT))
            else:
                parts.add_law(strut, cubic, (theta[f"{end}_N_m3"],))
