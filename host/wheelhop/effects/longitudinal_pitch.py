"""The vehicle gains and loses speed, and its body pitches."""

from __future__ import annotations

from wheelhop.effects.acceleration_moment import AccelerationMoment
from wheelhop.vehicle import Coordinate


class LongitudinalPitch(AccelerationMoment):
    """Load transfer between the axles, to the front one when braking."""

    id = "longitudinal-pitch"
    needs_motions = ("pitch",)
    title = "fore-aft acceleration pitches the body"
    equation = (
        r"M_\theta = -m h\,a_x(t),\quad a_x = \sum_j c_j B_j(t),"
        r"\quad B_j \text{ cubic B-splines, 0.15 s apart}"
    )
    source = (
        "load transfer, e.g. T. D. Gillespie, Fundamentals of Vehicle Dynamics (SAE 1992), ch. 1;"
        " no anti-dive geometry"
    )
    direction, axis = "forward", "x"
    turns = ((-1.0, Coordinate("pitch")),)  # nose up
