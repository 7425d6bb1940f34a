"""The full car on a frame that bends: the frame's modes as added modes of the sprung body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Channel
from wheelhop.frame import CORNERS, FiniteElements, mass_properties, reduce
from wheelhop.vehicle.assembly import Assembly, System
from wheelhop.vehicle.full_car import Drive, baseline
from wheelhop.vehicle.layout import body_inertia

Array = NDArray[np.float64]

FIXED_MODES = 20


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
    """The baseline vehicle with a flexible frame.

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
    parts = baseline(values, channels, drive)
    add_frame(parts, values, elements, zeta, fixed_modes)
    return parts.system(body_inertia(values))


def add_frame(
    parts: Assembly,
    values: Mapping[str, float],
    elements: FiniteElements,
    zeta: float,
    fixed_modes: int = FIXED_MODES,
) -> None:
    """Add all modes of the frame's Craig–Bampton reduction without supports, 1 kg each.

    They are orthogonal to heave, pitch and roll in the frame's mass, so that the body's equations
    stay as they are: body points move by z − xθ + yφ + Σ φᵣ(x, y) ηᵣ, η̈ᵣ + 2ζωᵣη̇ᵣ + ωᵣ²ηᵣ = fᵣ.
    All of them together deflect under constant forces at the corners exactly as the frame does.
    Between and beside the corners φᵣ is 1, x, y and xy through its four values there.
    """
    reduced = reduce(elements, fixed_modes)
    frequency_hz, shape = reduced.free_modes()
    x, y, _ = elements.position[elements.corners].T
    x = x - x[:2].mean() + values["geometry.cg_to_front_axle_m"]
    y = y - y.mean()
    heights = shape[[reduced.interface[corner] + 2 for corner in CORNERS]]
    through = np.linalg.solve(np.stack([np.ones(4), x, y, x * y], axis=1), heights)
    for i, (frequency, surface) in enumerate(zip(frequency_hz.tolist(), through.T, strict=True)):
        omega = 2 * pi * frequency

        def at(x: float, y: float, surface: Array = surface) -> float:
            return float(surface @ (1.0, x, y, x * y))

        mode = parts.add_body_mode(f"frame {i + 1}", at)
        parts.add_mass(((1.0, mode),), 1.0)
        parts.add_spring(((1.0, mode),), omega**2, 2 * zeta * omega)
