"""Dry friction in the strut and its joints."""

from __future__ import annotations

from collections.abc import Sequence
from math import tanh

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Becomes, Effect, Parameter, Values, law
from wheelhop.vehicle import COMPONENT, Assembly, ends, struts

LONGEST_STEP_S = {"elastic": 0.00125, "creeping": 0.000625}
"""What a joint does before it slips, and the step that takes: its stiffness against the unsprung
mass makes 50 Hz and more, its slope of tens of kN s/m decays in less than a millisecond."""


@law
def elastic_slip(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """Jenkins element: a spring of stiffness p[1] that slips at the force p[0]; z is its force.
    Exact for any step as long as the motion does not turn within it."""
    force = min(max(z + p[1] * dx, -p[0]), p[0])
    return force, force


@law
def creeping_slip(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """Coulomb's law with its jump rounded: p[0] tanh(v / p[1])."""
    return p[0] * tanh(v / p[1]), z


class DryFriction(Effect):
    """Beside the spring and damper of every strut: a Coulomb slider behind a spring, so that the
    joint gives way elastically before it slips, or one that creeps before it slides, as where a
    seal drags its film of oil along."""

    id = "dry-friction"
    place = "suspension"
    on_rig = True
    title = "Coulomb friction in the strut and its joints, elastic or creeping before it slips"
    becomes = (
        Becomes(
            "presliding_N_m",
            "lower",
            "suspension stiffness",
            "a joint no stiffer than the spring hardly slips, it only adds to the spring",
        ),
    )
    equation = (
        r"\text{elastic: } \dot f = k_p \dot x \text{ while } |f| < F_c,\ 0 \text{ where the motion"
        r" would exceed it};\quad \text{creeping: } f = F_c \tanh(\dot x / w)"
    )
    source = (
        "Jenkins element: W. D. Iwan, A distributed-element model for hysteresis and its"
        " steady-state dynamic response, J. Appl. Mech. 33 (1966) 893, eq. 1; hyperbolic tangent:"
        " S. Andersson, A. Söderberg, S. Björklund, Friction models for sliding dry, boundary and"
        " mixed lubricated contacts, Tribology International 40 (2007) 580, eq. 4"
    )

    def __init__(self, form: str = "elastic") -> None:
        self.form = form
        self.longest_step_s = LONGEST_STEP_S[form]

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """What the joint does before it slips."""
        return tuple(LONGEST_STEP_S)

    def with_choice(self, choice: str) -> DryFriction:
        """This effect with the law `choice`."""
        return DryFriction(choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Slip force per axle; stiffness before slip, or the speed at which sliding sets in."""
        found = ends(vehicle)
        spring = next(iter(found.values())).usual.stiffness_N_m
        return (
            *(
                Parameter(
                    f"{end}_N",
                    "N",
                    f"slip force of {strut.name}",
                    0.06 * strut.usual.load_N,
                    lower=0.0,
                )
                for end, strut in found.items()
            ),
            self._before_slip(COMPONENT not in found, spring),
        )

    def _before_slip(self, on_car: bool, spring_N_m: float) -> Parameter:
        if self.form == "creeping":
            return Parameter(
                "creep_m_s",
                "m/s",
                "speed below which the joint creeps instead of sliding",
                0.01,
                lower=0.002,
                upper=0.04,
                starts=(0.004, 0.012),
            )
        return Parameter(
            "presliding_N_m",
            "N/m",
            "stiffness of the joint before it slips",
            100 * spring_N_m,
            lower=spring_N_m,
            upper=300 * spring_N_m if on_car else np.inf,  # a rig may hold it rigidly
            starts=(20 * spring_N_m, 150 * spring_N_m),
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the element to each strut."""
        for strut in struts(vehicle):
            slip = theta[f"{strut.end}_N"]
            if self.form == "creeping":
                parts.add_law(strut.row, creeping_slip, (slip, theta["creep_m_s"]))
            else:
                parts.add_law(strut.row, elastic_slip, (slip, theta["presliding_N_m"]))
