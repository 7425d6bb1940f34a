"""The tyre averages the road over its contact patch."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Values
from wheelhop.effects.parameters import Amplitude, Parameter, Switch
from wheelhop.effects.special import WheelShape
from wheelhop.track import Wheel, WheelPath
from wheelhop.vehicle import axle_name, axles

CONTACT_M = 0.1
"""Contacts are 0.05 to 0.25 m long, from a kart's to a lorry's."""


class TyreEnvelope(WheelShape):
    """Three ideas of what a tyre averages; a rigid wheel has a contact of no length.

    "path": the path of the rigid wheel; "ground": the ground, over which the rigid wheel then
    rolls; "footprint": the ground, and the wheel's radius is of no consequence.
    """

    id = "tyre-envelope"
    place = "wheel"
    title = "the tyre's contact patch averages the profile over a length; the rigid wheel does not"
    equation = (
        r"\text{path: } \bar h(x) = \frac{1}{\ell} \int_{-\ell/2}^{\ell/2} h(x + s)\,ds;"
        r"\quad \text{ground: } h \text{ of } \bar z;\quad \text{footprint: } \bar z"
    )
    source = (
        "footprint: K. M. Captain, A. B. Boghani, D. N. Wormley, Analytical tire models for dynamic"
        " vehicle simulation, Veh. Syst. Dyn. 8 (1979) 1, fixed footprint model; path: the mean"
        " over the contact of a rolling basic curve, P. W. A. Zegelaar, The dynamic response of"
        " tyres to brake torque variations and road unevennesses, PhD thesis, Delft 1998"
    )
    needs_road = True

    def __init__(self, form: str = "path") -> None:
        self.form = form

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """What is averaged."""
        return ("path", "ground", "footprint")

    def with_choice(self, choice: str) -> TyreEnvelope:
        """This effect in the form `choice`."""
        return TyreEnvelope(choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The length averaged over, per axle."""
        # Where the model's wheels have shrunk to less than a contact, to follow the ground, no
        # rigid wheel is left to average: the footprint alone tells what they stand for.
        shrunk = any(vehicle[f"wheel.{end}.radius_m"] < CONTACT_M / 2 for end in axles(vehicle))
        if shrunk and self.form != "footprint":
            return ()
        lengths = [
            Amplitude(
                f"{end}_m",
                "m",
                f"length of a {end} tyre's contact",
                CONTACT_M,
                lower=0.0,
                upper=5 * CONTACT_M,
            )
            for end in axles(vehicle)
        ]
        if self.form != "footprint":
            return lengths
        meaning = "1: the tyre follows the ground's average instead of rolling over it"
        return [*lengths, Switch("follows", "1", meaning)]

    def wheel_path(self, theta: Values, corner: int, wheel: Wheel) -> WheelPath:
        """The average."""
        length = theta[f"{axle_name(corner)}_m"]
        if self.form == "path":
            return wheel.averaged(length)
        if self.form == "ground":
            return wheel.over_averaged_ground(length)
        if theta["follows"] > 0:
            return wheel.on_footprint(length)
        # Screening sees one number at a time: what the length does to the ground is added here to
        # the rigid wheel's path, and what following it does comes with the switch.
        return wheel.rigid_changed_as_ground(length)
