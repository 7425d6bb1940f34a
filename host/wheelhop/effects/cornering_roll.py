"""The path is curved, and the body rolls."""

from __future__ import annotations

from wheelhop.effects.acceleration_moment import AccelerationMoment
from wheelhop.vehicle import Coordinate


class CorneringRoll(AccelerationMoment):
    """Load transfer between the sides, to the right wheels in a curve to the left."""

    id = "cornering-roll"
    needs_motions = ("roll",)
    title = "a curved path rolls the body: a slowly varying roll moment"
    equation = (
        r"M_\phi = m h\,a_y(t),\quad a_y = \sum_j c_j B_j(t),"
        r"\quad B_j \text{ cubic B-splines, 0.15 s apart}"
    )
    source = (
        "load transfer, e.g. T. D. Gillespie, Fundamentals of Vehicle Dynamics (SAE 1992), ch. 6;"
        " roll axis on the road, as vertical suspensions have it"
    )
    direction, axis = "to the left", "y"
    turns = ((1.0, Coordinate("roll")),)  # right side down
