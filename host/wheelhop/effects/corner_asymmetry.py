"""One corner's strut is not its mirror image's."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Effect, Values
from wheelhop.effects.parameters import Amplitude, Parameter
from wheelhop.vehicle import Assembly, pairs


class CornerAsymmetry(Effect):
    """Spring and damper differ from left to right on one axle, whose numbers are their means.

    A strong left strut and a weak right one are the same vehicle, seen from means that are
    estimated anyway: no record can say which of the two departs from what it should be.
    """

    id = "corner-asymmetry"
    place = "suspension"
    title = "one corner's spring and damper differ from its mirror image"
    equation = (
        r"k_\mathrm{left} = (1 + \kappa)\, k,\ k_\mathrm{right} = (1 - \kappa)\, k,"
        r"\quad c_\mathrm{left} = (1 + \gamma)\, c,\ c_\mathrm{right} = (1 - \gamma)\, c"
    )
    source = "a worn or mismatched spring or damper; the mean and half the difference of a pair"

    def __init__(self, axle: str = "front") -> None:
        self.axle = axle

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """Either axle."""
        return ("front", "rear")

    def with_choice(self, choice: str) -> CornerAsymmetry:
        """The difference on the axle `choice`."""
        return CornerAsymmetry(choice)

    def applies_to(self, vehicle: Values) -> bool:
        """Whether that axle has a left and a right strut."""
        return self.axle in pairs(vehicle)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Half the difference of left and right over the mean, of spring and of damper."""
        return tuple(
            Amplitude(
                f"{part}_excess",
                "1",
                f"{part} rate of the left strut over the axle's mean, less one",
                0.15,
                lower=-0.95,
                upper=0.95,
            )
            for part in ("spring", "damper")
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Give to the left strut what is taken from the right one."""
        for strut, sign in zip(pairs(vehicle)[self.axle], (1.0, -1.0), strict=True):
            parts.add_spring(
                strut.row,
                sign * theta["spring_excess"] * strut.stiffness_N_m,
                sign * theta["damper_excess"] * strut.damping_N_s_m,
            )
