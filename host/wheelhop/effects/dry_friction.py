"""Dry friction in the strut and its joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Becomes, Effect, Parameter, Values, law
from wheelhop.vehicle import Assembly, ends, struts


@law
def elastic_slip(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """Jenkins element: a spring of stiffness p[1] that slips at the force p[0]; z is its force.
    Exact for any step as long as the motion does not turn within it."""
    force = min(max(z + p[1] * dx, -p[0]), p[0])
    return force, force


class DryFriction(Effect):
    """A spring and a Coulomb slider in series, beside the spring and damper of every strut."""

    id = "dry-friction"
    place = "suspension"
    on_rig = True
    becomes = (
        Becomes(
            "presliding_N_m",
            "lower",
            "suspension stiffness",
            "a joint no stiffer than the spring hardly slips, it only adds to the spring",
        ),
    )
    title = "Coulomb friction in the strut and its joints, elastic before it slips"
    equation = (
        r"\dot f = k_p \dot x \text{ while } |f| < F_c,\ 0 \text{ where the motion would exceed it}"
    )
    longest_step_s = 0.00125  # the joint's stiffness against the unsprung mass: 50 Hz and more
    source = (
        "Jenkins element: W. D. Iwan, A distributed-element model for hysteresis and its"
        " steady-state dynamic response, J. Appl. Mech. 33 (1966) 893, eq. 1"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Slip force per axle; stiffness before slip."""
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
            Parameter(
                "presliding_N_m",
                "N/m",
                "stiffness of the joint before it slips",
                100 * spring,
                lower=spring,
                upper=300 * spring if len(found) > 1 else np.inf,  # a rig may hold it rigidly
                starts=(20 * spring, 150 * spring),
            ),
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the element to each strut."""
        for strut in struts(vehicle):
            slip = theta[f"{strut.end}_N"]
            parts.add_law(strut.row, elastic_slip, (slip, theta["presliding_N_m"]))
