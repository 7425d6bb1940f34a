"""The full car on a frame that bends: the frame's modes as added modes of the sprung body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from wheelhop.campaign import Channel
from wheelhop.frame import FIXED_MODES, FiniteElements, corner_modes, mass_properties
from wheelhop.vehicle.assembly import System
from wheelhop.vehicle.frame_modes import values_of
from wheelhop.vehicle.full_car import Drive, baseline
from wheelhop.vehicle.layout import body_inertia


def frame_values(elements: FiniteElements) -> dict[str, float]:
    """What vehicle.toml would say of the sprung body if the frame with all that it carries were
    it: mass, pitch and roll inertia, and how far the front corners are ahead of its centre of mass.

    Products of inertia have no place there: the full car is alike on its left and right.
    """
    found = mass_properties(elements)
    front = elements.position[elements.corners[:2], 0].mean()
    return {
        "geometry.cg_to_front_axle_m": float(front - found.centre_m[0]),
        "body.mass_kg": found.mass_kg,
        "body.pitch_inertia_kg_m2": float(found.inertia_kg_m2[1, 1]),
        "body.roll_inertia_kg_m2": float(found.inertia_kg_m2[0, 0]),
    }


def car_on_frame(
    values: Mapping[str, float],
    elements: FiniteElements,
    channels: Sequence[Channel],
    drive: Drive,
    zeta: float = 0.02,
    fixed_modes: int = FIXED_MODES,
) -> System:
    """The baseline vehicle with all modes of the frame's Craig–Bampton reduction: together they
    deflect under constant forces at the corners exactly as the frame does.

    Parameters
    ----------
    values
        Numbers of vehicle.toml under their dotted keys, SI. Its body is the rigid part of the
        motion: `frame_values` has that of the frame itself.
    elements
        The frame with all that it carries.
    channels, drive
        As of `baseline`. A channel between the corners sees their motion interpolated.
    zeta
        Damping ratio of every mode of the frame.
    fixed_modes
        Fixed-interface modes of the frame's reduction.
    """
    bending = {**values, **values_of(corner_modes(elements, fixed_modes), zeta)}
    return baseline(bending, channels, drive).system(body_inertia(bending))
