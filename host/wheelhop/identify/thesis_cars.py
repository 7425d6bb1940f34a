"""The cars of the thesis's figures 2.15-2.17, 2.20 and 5.24."""

from __future__ import annotations

import numpy as np

from wheelhop.identify import published
from wheelhop.identify.equivalent import equivalent_vehicle, wheels
from wheelhop.identify.quarter_car import Struts, Wheels, compliance, rigid_inertia
from wheelhop.identify.study import Car, Variant, study
from wheelhop.identify.synthetic import thesis_matrix

CHAPTER_2 = {
    "2.15": ("front-stiffness", (1.0, 1.25, 1.5)),
    "2.16": ("front-damping", (1.0, 1.5, 2.0)),
    "2.17": ("rear-damping", (1.0, 1.5, 2.0)),
    "2.20": ("front-unsprung-mass", (0.75, 1.0, 1.25)),
}
"""Figure: what is varied in it, and by which factors."""


def racing_car() -> Car:
    """Chapter 2's car on its new suspensions, its body that of the equivalent vehicle."""
    old, new = (Struts(*published.TABLE_2_2[key]) for key in ("old", "new"))
    vehicle = equivalent_vehicle()
    return Car(vehicle.body(), new, wheels(), vehicle.sprung_kg(), old)


def stiffened() -> dict[str, list[Variant]]:
    """Figure 5.24: H_n,11 and H_n,33 on the old suspensions and on those stiffened by 20 %, each
    from the ground under a wheel to the body above it."""
    old = Struts(*published.TABLE_5_4["old"])
    on = Wheels(*zip(published.TABLE_5_3["front"], published.TABLE_5_3["rear"], strict=True))
    atv = published.ATV
    ahead, half = atv["cg_to_front_axle_m"], atv["track_width_m"] / 2
    x = np.repeat([ahead, ahead - atv["wheelbase_m"]], 2)
    positions = np.column_stack([x, [half, -half, half, -half]])
    inertia = [atv[key] for key in ("mass_kg", "pitch_inertia_kg_m2", "roll_inertia_kg_m2")]
    car = Car(compliance(thesis_matrix(), old), old, on, rigid_inertia(positions, inertia))
    ends = {"front": 0, "rear": 2}
    return {end: study(car, "stiffness", (1.0, 1.2), corner) for end, corner in ends.items()}
