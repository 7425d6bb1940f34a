"""Friction that is taken along only after free play."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Becomes, Effect, Values
from wheelhop.effects.dry_friction import LONGEST_STEP_S
from wheelhop.effects.hysteresis import slip_behind_play
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import Assembly, ends, struts


class FrictionWithPlay(Effect):
    """A slider behind a spring, as in dry friction, behind free play: after each reversal the force
    falls to zero and stays there until the gap is crossed. The spring and damper beside it have no
    play."""

    id = "friction-with-play"
    place = "suspension"
    on_rig = True
    on_vehicle = False
    title = "friction in series with free play: nothing is felt until the gap is crossed"
    becomes = (Becomes("gap_m", "lower", "dry-friction", "without play only friction is left"),)
    equation = (
        r"\dot z = \dot x \text{ while } |z| < \frac{g}{2} + \frac{F_c}{k_p},\ 0 \text{ where it"
        r" would exceed that};\quad f = k_p\,(|z| - \frac{g}{2})\,\mathrm{sgn}\,z \text{ for }"
        r" |z| > \frac{g}{2},\ 0 \text{ else}"
    )
    longest_step_s = LONGEST_STEP_S["elastic"]
    source = (
        "Jenkins element (W. D. Iwan, J. Appl. Mech. 33 (1966) 893, eq. 1) in series with the gap"
        " of M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash: a survey,"
        " Automatica 38 (2002) 1633, sec. 2; seen in the rotary friction damper of D. Coble et al."
        " (2022)"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Slip force per axle, stiffness before slip, and the gap."""
        found = ends(vehicle)
        usual = next(iter(found.values())).usual
        spring, travel = usual.stiffness_N_m, usual.travel_m
        return (
            *(
                Amplitude(
                    f"{end}_N",
                    "N",
                    f"slip force of {strut.name}",
                    0.06 * strut.usual.load_N,
                    lower=0.0,
                )
                for end, strut in found.items()
            ),
            Shape(
                "presliding_N_m",
                "N/m",
                "stiffness of the joint before it slips",
                100 * spring,
                lower=spring,
                starts=(5 * spring, 50 * spring),
            ),
            Shape(
                "gap_m",
                "m",
                "width of the free play",
                0.1 * travel,
                lower=0.002 * travel,
                upper=2.0 * travel,
                starts=(0.02 * travel, 0.1 * travel, 0.3 * travel),
            ),
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the element to each strut."""
        for strut in struts(vehicle):
            numbers = (theta[f"{strut.end}_N"], theta["presliding_N_m"], theta["gap_m"])
            parts.add_law(strut.row, slip_behind_play, numbers)
