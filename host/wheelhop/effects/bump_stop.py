"""Elastic stops at the ends of the travel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.balance import balance, share
from wheelhop.effects.base import Array, Becomes, Effect, Probe, Values, law
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import Assembly, ends, struts

SHARES = (0.2, 0.4, 0.6, 0.8)
"""Clearances to screen, as shares of the longest travel the model without stops makes."""

UNLIKE = 0.3
"""How much front and rear stops are believed to differ, as the `sigma` of a balance."""


@law
def stops(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] times the way beyond the clearance p[1] in compression and beyond p[2] in rebound."""
    return p[0] * (min(x + p[1], 0.0) + max(x - p[2], 0.0)), z


class BumpStop(Effect):
    """A spring beside every strut that begins to act beyond a clearance."""

    id = "bump-stop"
    place = "suspension"
    on_rig = True
    becomes = (
        Becomes(
            "clearance_m",
            "lower",
            "progressive-spring",
            "a stop without clearance is a spring that is stiffer one way",
        ),
    )
    title = "an elastic stop engages beyond a clearance"
    equation = r"f = k_s \min(x + d_c, 0) + k_s \max(x - d_r, 0)"
    source = (
        "piecewise linear stop, e.g. S. W. Shaw, P. J. Holmes, A periodically forced piecewise"
        " linear oscillator, J. Sound Vib. 90 (1983) 129, eq. 2.1"
    )

    def __init__(self, form: str = "compression") -> None:
        self.form = form

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """Where the stops are."""
        return ("compression", "rebound", "both")

    def with_choice(self, choice: str) -> BumpStop:
        """Stops at this end of the travel, or at both."""
        return BumpStop(choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Stiffness and clearance, how front and rear share them, and the ratio of the clearances
        of a pair of stops."""
        struts_of = ends(vehicle)
        usual = next(iter(struts_of.values())).usual
        of_both = ", mean of front and rear" if len(struts_of) > 1 else ""
        found = [
            Amplitude(
                "stiffness_N_m",
                "N/m",
                f"stiffness of a stop{of_both}",
                3 * usual.stiffness_N_m,
                lower=0.0,
            ),
            Shape(
                "clearance_m",
                "m",
                f"way from rest to a stop{of_both}",
                usual.travel_m,
                lower=0.0,
                starts=(0.2 * usual.travel_m,),
            ),
        ]
        if len(struts_of) > 1:
            found.append(balance("stiffness_balance", "stiffness", UNLIKE))
            found.append(balance("clearance_balance", "clearance", UNLIKE, most=0.9))
        if self.form == "both":
            found.append(
                Shape(
                    "rebound_ratio",
                    "1",
                    "clearance in rebound over clearance in compression",
                    1.0,
                    lower=0.05,
                    starts=(1.0,),
                )
            )
        return found

    def shape_starts(self, probe: Probe) -> Sequence[Values]:
        """Shares of the longest travel."""
        travels = [
            float(np.abs(extension).max())
            for setting in probe.settings
            for extension in probe.travel(setting.run_id).values()
        ]
        return [{"clearance_m": part * max(travels)} for part in SHARES] if travels else ()

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the stops to each strut."""
        for strut in struts(vehicle):
            stiffness = share(theta, "stiffness_N_m", "stiffness_balance", strut.end)
            clearance = share(theta, "clearance_m", "clearance_balance", strut.end)
            compression = np.inf if self.form == "rebound" else clearance
            rebound = np.inf if self.form == "compression" else clearance
            if self.form == "both":
                rebound *= theta["rebound_ratio"]
            parts.add_law(strut.row, stops, (stiffness, compression, rebound))
