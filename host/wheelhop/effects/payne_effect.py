"""An elastomer that softens with amplitude."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Effect, Values
from wheelhop.effects.dry_friction import LONGEST_STEP_S, elastic_slip
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import Assembly, ends, struts

WAYS = np.geomspace(1.0 / 16.0, 32.0, 14)
"""Ways after which the sliders slip, over the way at which half of their force is reached."""


class PayneEffect(Effect):
    """Filler in rubber breaks up as it is strained: a stiffness that falls with the amplitude, and
    a loss with it that depends on the amplitude and hardly on the frequency. Fourteen sliders
    behind springs, whose forces follow from one curve of first loading."""

    id = "payne-effect"
    place = "suspension"
    on_rig = True
    on_vehicle = False
    title = "an elastomer's stiffness falls with the amplitude (Payne)"
    equation = (
        r"f = \sum_j k_j z_j,\ |z_j| \leq d_j;\quad \text{first loading } f = F x/(x_{1/2} + x),"
        r"\ \text{so that } k(X) = k_\infty + \frac{F/x_{1/2}}{1 + X/x_{1/2}}"
    )
    longest_step_s = LONGEST_STEP_S["elastic"]
    source = (
        "amplitude dependence of filled rubber: G. Kraus, Mechanical losses in carbon-black-filled"
        " rubbers, J. Appl. Polym. Sci.: Appl. Polym. Symp. 39 (1984) 75, with exponent m = 1/2;"
        " the same curve of first loading: M. Berg, A non-linear rubber spring model for rail"
        " vehicle dynamics analysis, Vehicle System Dynamics 30 (1998) 197; sliders in"
        " parallel: W. D. Iwan, J. Appl. Mech. 33 (1966) 893"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Force of the filler per axle, and the way at which half of it is reached."""
        found = ends(vehicle)
        travel = next(iter(found.values())).usual.travel_m
        return (
            *(
                Amplitude(
                    f"{end}_N",
                    "N",
                    f"force of the filler in {strut.name}, at large amplitudes",
                    0.1 * strut.usual.load_N,
                    lower=0.0,
                )
                for end, strut in found.items()
            ),
            Shape(
                "half_way_m",
                "m",
                "way at which half of that force is reached",
                0.1 * travel,
                lower=2e-3 * travel,
                upper=travel,
                starts=(0.02 * travel, 0.1 * travel, 0.4 * travel),
            ),
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the sliders to each strut."""
        half_way = theta["half_way_m"]
        for strut in struts(vehicle):
            for way, stiffness in zip(WAYS * half_way, stiffnesses() / half_way, strict=True):
                pull = theta[f"{strut.end}_N"] * stiffness
                parts.add_law(strut.row, elastic_slip, (float(pull * way), float(pull)))


def stiffnesses() -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Stiffness (14,) of each slider for a force and a half way of 1: what the slope of the first
    loading, x / (1 + x) between the ways at which they slip, loses there."""
    at = np.concatenate([[0.0], WAYS])
    slopes = np.diff(at / (1.0 + at)) / np.diff(at)
    return np.asarray(slopes - np.append(slopes[1:], 0.0))
