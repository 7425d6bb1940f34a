"""A bar that couples the left wheel's travel to the right wheel's."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Effect, Values
from wheelhop.effects.parameters import Amplitude, Parameter
from wheelhop.vehicle import Assembly, pairs


class AntiRollBar(Effect):
    """A spring that is stretched by the difference of an axle's two travels."""

    id = "anti-roll-bar"
    place = "suspension"
    needs_motions = ("roll",)
    title = "left and right travel coupled by a spring"
    equation = r"f_\mathrm{left} = -f_\mathrm{right} = k_b\,(x_\mathrm{left} - x_\mathrm{right})"
    source = (
        "e.g. M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed. (Springer 2014),"
        " ch. 13 (stabiliser)"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The bar's stiffness per axle."""
        return tuple(
            Amplitude(
                f"{end}_N_m",
                "N/m",
                f"stiffness of the {end} bar: force at a wheel per difference of travel",
                0.3 * left.stiffness_N_m,
                lower=0.0,
            )
            for end, (left, _) in pairs(vehicle).items()
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add a spring along the difference of travels, for each axle."""
        for end, (left, right) in pairs(vehicle).items():
            difference = (*left.row, *((-factor, node) for factor, node in right.row))
            parts.add_spring(difference, theta[f"{end}_N_m"])
