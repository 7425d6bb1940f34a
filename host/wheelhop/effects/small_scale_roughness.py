"""Unevenness nobody surveyed, on top of the track's known shape."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Values
from wheelhop.effects.parameters import Parameter, Shape
from wheelhop.effects.special import RandomHeights


class SmallScaleRoughness(RandomHeights):
    """Random heights under left and right wheels, their density a power law; those under the rear
    wheels are those the front wheels met a wheelbase before."""

    id = "small-scale-roughness"
    place = "track"
    title = "broadband unevenness on top of the track's known shape"
    equation = r"S_h(\Omega) = C\,(\Omega / \Omega_0)^{-w},\quad \Omega_0 = 1\ \mathrm{rad/m}"
    source = (
        "ISO 8608:2016, displacement density in angular spatial frequency; C. J. Dodds,"
        " J. D. Robson, The description of road surface roughness, J. Sound Vib. 31 (1973) 175"
    )
    needs_road = True

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The density's size at 1 rad/m and its slope; class A of the standard is 1e-6 m³."""
        return (
            Shape(
                "unevenness_m3",
                "m³",
                "spectral density of the height at 1 rad/m",
                1e-4,
                lower=1e-14,
                upper=1e-2,
                starts=(1e-7,),
            ),
            Shape(
                "waviness",
                "1",
                "how fast the density falls with the wave number",
                0.5,
                lower=0.5,
                upper=5.0,
                starts=(2.0,),
            ),
        )

    def height_density(self, theta: Values, wave_number_rad_m: Array) -> Array:
        """The standard's straight line in a double logarithmic plot."""
        return theta["unevenness_m3"] * wave_number_rad_m ** -theta["waviness"]
