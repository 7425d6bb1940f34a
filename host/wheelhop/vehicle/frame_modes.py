"""The modes of a frame that bends, among the numbers of a vehicle, and in its equations.

They are known, not estimated: "frame.FL.x_m" and "frame.FL.y_m" say where a corner of the frame is,
ahead of the front corners and to the left of the middle; "frame.1.frequency_hz" and
"frame.1.damping_ratio" are a mode's, and "frame.1.FL" is how far that corner moves in it, per √kg.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, pi

import numpy as np
from numpy.typing import NDArray

from wheelhop.frame import CORNERS, CornerModes
from wheelhop.vehicle.assembly import Assembly

Array = NDArray[np.float64]
PREFIX = "frame."
TINY = 1e-9


def mode_values(modes: CornerModes, count: int, damping_ratio: float) -> dict[str, float]:
    """The lowest modes of a frame without supports under dotted keys, normalised to 1 kg.

    All others give way to forces at the corners as to constant ones, R = Σ φφᵀ/ω² (residual
    flexibility, e.g. R. R. Craig, A. J. Kurdila, Fundamentals of Structural Dynamics (Wiley 2006),
    ch. 17). Up to four more modes at the frequency of the first left out have this R together.
    """
    frequency, heights = modes.frequency_hz, modes.height
    if count < len(frequency):
        rest, limit = heights[:, count:], frequency[count]
        give = (rest * (limit / frequency[count:]) ** 2) @ rest.T
        power, direction = np.linalg.eigh(give)
        there = power > TINY * power.max()
        residual = direction[:, there] * np.sqrt(power[there])
        frequency = np.concatenate([frequency[:count], np.full(there.sum(), limit)])
        heights = np.concatenate([heights[:, :count], residual], axis=1)
    return values_of(CornerModes(modes.position, frequency, heights), damping_ratio)


def values_of(modes: CornerModes, damping_ratio: float) -> dict[str, float]:
    """All modes under dotted keys."""
    x, y, _ = modes.position.T
    x, y = x - x[:2].mean(), y - y.mean()
    values: dict[str, float] = {}
    for corner, ahead, left in zip(CORNERS, x.tolist(), y.tolist(), strict=True):
        values[f"{PREFIX}{corner}.x_m"], values[f"{PREFIX}{corner}.y_m"] = ahead, left
    for i, frequency in enumerate(modes.frequency_hz.tolist(), start=1):
        values[f"{PREFIX}{i}.frequency_hz"] = frequency
        values[f"{PREFIX}{i}.damping_ratio"] = damping_ratio
        for corner, height in zip(CORNERS, modes.height[:, i - 1].tolist(), strict=True):
            values[f"{PREFIX}{i}.{corner}"] = height
    return values


def longest_step_s(values: Mapping[str, float]) -> float:
    """A step of integration that follows the highest of these modes: a radian of it."""
    highest = max((values[f"{PREFIX}{i}.frequency_hz"] for i in _numbers(values)), default=0.0)
    return 1.0 / (2 * pi * highest) if highest > 0.0 else inf


def add_modes(parts: Assembly, values: Mapping[str, float]) -> None:
    """Add the modes there are among these numbers, 1 kg each.

    They are orthogonal to heave, pitch and roll in the frame's mass, so that the body's equations
    stay as they are: body points move by z − xθ + yφ + Σ φᵣ(x, y) ηᵣ, η̈ᵣ + 2ζωᵣη̇ᵣ + ωᵣ²ηᵣ = fᵣ.
    Between and beside the corners φᵣ is 1, x, y and xy through its four values there.
    """
    if f"{PREFIX}1.frequency_hz" not in values:
        return
    x, y = (np.array([values[f"{PREFIX}{c}.{axis}"] for c in CORNERS]) for axis in ("x_m", "y_m"))
    x = x + values["geometry.cg_to_front_axle_m"]
    through = np.linalg.inv(np.stack([np.ones(4), x, y, x * y], axis=1))
    for i in _numbers(values):
        omega = 2 * pi * values[f"{PREFIX}{i}.frequency_hz"]
        surface = through @ [values[f"{PREFIX}{i}.{corner}"] for corner in CORNERS]

        def at(x: float, y: float, surface: Array = surface) -> float:
            return float(surface @ (1.0, x, y, x * y))

        mode = parts.add_body_mode(f"frame {i}", at)
        damping = 2 * values[f"{PREFIX}{i}.damping_ratio"] * omega
        parts.add_mass(((1.0, mode),), 1.0)
        parts.add_spring(((1.0, mode),), omega**2, damping)


def _numbers(values: Mapping[str, float]) -> range:
    """The modes' numbers, from 1."""
    count = sum(key.startswith(PREFIX) and key.endswith(".frequency_hz") for key in values)
    return range(1, count + 1)
