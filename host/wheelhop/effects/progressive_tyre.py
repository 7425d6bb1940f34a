"""A tyre that stiffens with deflection."""

from __future__ import annotations

from collections.abc import Sequence

import numba

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Values, law
from wheelhop.effects.parameters import Amplitude, Parameter
from wheelhop.vehicle import Assembly, axle_name, axles, static_tyre_load, tyre, wheels


@numba.njit("float64(float64, float64, float64, float64)", cache=True, error_model="numpy")
def beyond_linear(x: float, stiffness: float, growth: float, bend: float) -> float:
    """What opposes the extension x of a tyre of stiffness k (1 − growth x + bend x²) beyond k x,
    N; the part that grows softens down to no stiffness, and no further."""
    if growth == 0.0 and bend == 0.0:  # most models' tyres: what follows takes longer than no_pull
        return 0.0
    slack = max(x - 1.0 / growth, 0.0) if growth > 0.0 else 0.0
    return stiffness * (bend * x * x * x / 3.0 - 0.5 * growth * (x * x - slack * slack))


@law
def stiffening(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """`beyond_linear` with stiffness, growth and bend from p."""
    return beyond_linear(x, p[0], p[1], p[2]), z


def bend_of(values: Values, corner: int) -> tuple[float, float]:
    """Growth (1/m) and bend (1/m²) of the stiffness of a tyre in a model; none: both are 0."""
    key = f"{ProgressiveTyre.id}.{axle_name(corner)}"
    return values.get(f"{key}_1_m", 0.0), values.get(f"{key}_1_m2", 0.0)


class ProgressiveTyre(Effect):
    """The stiffness at the static load stays vehicle.toml's; the effect is what departs from it."""

    id = "progressive-tyre"
    place = "tyre"
    title = "tyre stiffness grows with deflection"
    equation = (
        r"\text{quadratic: } k = k_t (1 + g\,d) \geq 0;\quad \text{cubic: } k = k_t (1 + b\,d^2),"
        r"\quad d \text{ the deflection beyond that at rest}"
    )
    source = (
        "load quadratic in the deflection: H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed."
        " (Butterworth-Heinemann 2012), section 4.3 (q_Fz1, q_Fz2); cubic: the next term of a"
        " series about the static load, for a tyre that stiffens both ways"
    )
    needs_road = True

    def __init__(self, form: str = "quadratic") -> None:
        self.form = form

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """Two laws."""
        return ("quadratic", "cubic")

    def with_choice(self, choice: str) -> ProgressiveTyre:
        """This effect with the law `choice`."""
        return ProgressiveTyre(choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Growth of the stiffness, or its bend, per axle."""
        parameters = []
        for corner, end in zip((0, 2), axles(vehicle), strict=False):
            # A load ∝ (deflection)ⁿ has growth (n − 1) / deflection at rest; n is 1.0 to 1.5.
            at_rest = static_tyre_load(vehicle, corner) / vehicle[f"wheel.{end}.tyre_stiffness_N_m"]
            if self.form == "quadratic":
                parameters.append(
                    Amplitude(
                        f"{end}_1_m",
                        "1/m",
                        f"growth of the {end} tyres' stiffness with deflection",
                        0.5 / at_rest,
                        lower=0.0,
                        upper=2.0 / at_rest,
                    )
                )
            else:
                parameters.append(
                    Amplitude(
                        f"{end}_1_m2",
                        "1/m²",
                        f"growth of the {end} tyres' stiffness with deflection squared",
                        1.0 / at_rest**2,
                        lower=0.0,
                        upper=10.0 / at_rest**2,
                    )
                )
        return parameters

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the force to each tyre."""
        for i in wheels(vehicle):
            end = axle_name(i)
            stiffness = vehicle[f"wheel.{end}.tyre_stiffness_N_m"]
            growth, bend = theta.get(f"{end}_1_m", 0.0), theta.get(f"{end}_1_m2", 0.0)
            parts.add_law(tyre(i), stiffening, (stiffness, growth, bend))
