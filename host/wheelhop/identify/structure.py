"""Which elements of the transfer matrix are one and the same, and what physics fixes of them.

Axle motion y moves the body points x = H y. With the suspensions D = diag(K + C s) the struts push
with D (y - x), and the body with its suspensions clamped answers a force by S: H = S D. The
mechanism is reciprocal, so S = H D⁻¹ is symmetric. H itself is symmetric only if front and rear
suspensions are alike; the thesis takes it so (5.5), which is a misfit for most vehicles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import AXLE_POINTS
from wheelhop.identify.sections import ComplexArray, Points

Array = NDArray[np.float64]

Symmetry = Literal["reciprocal", "symmetric", "free"]
"""S = H D⁻¹ symmetric (physics), H symmetric (thesis 5.5), or neither."""

MIRROR = (1, 0, 3, 2, 5, 4, 7, 6)
"""Of the inputs: the axles' vertical motion, and fore and aft."""
VERTICAL = 4
"""So many inputs are vertical; those from here on are the same axles' motion fore and aft."""
RIGID = np.array([[1.0, 1, 1, 1], [1, 1, -1, -1], [1, -1, 1, -1]]).T
"""Heave, pitch and roll of the four corners (4, 3); each axle as wide as the other."""


@dataclass(frozen=True)
class Structure:
    """Physics imposed on the matrix, each switchable.

    symmetry
        See `Symmetry`.
    left_right
        The vehicle is its own mirror image: H₁₁ = H₂₂, H₁₃ = H₂₄ and so on. With "symmetric" these
        are the six elements of thesis 5.5.
    rigid
        The axles raised along any plane raise the body along the same plane: H(0) r = r for heave,
        pitch and roll. The rows of H(0) then sum to 1. Needs all four axles. All moved
        forward alike, they do not raise it.
    stable
        Every pole decays.
    """

    symmetry: Symmetry = "reciprocal"
    left_right: bool = True
    rigid: bool = True
    stable: bool = True

    def elements(self, outputs: tuple[int, ...], inputs: tuple[int, ...]) -> NDArray[np.int64]:
        """Number of the free element at each place (n outputs, m inputs), from 0 up, in the order
        in which the rows are read."""
        number: dict[tuple[int, int], int] = {}
        out = np.empty((len(outputs), len(inputs)), int)
        for i, row in enumerate(outputs):
            for j, column in enumerate(inputs):
                same = self._same(row, column)
                found = next((number[place] for place in same if place in number), None)
                number[row, column] = len(set(number.values())) if found is None else found
                out[i, j] = number[row, column]
        return out

    def _same(self, row: int, column: int) -> set[tuple[int, int]]:
        places = {(row, column)}
        if self.left_right:
            places |= {(MIRROR[i], MIRROR[j]) for i, j in places}
        if self.symmetry != "free" and column < VERTICAL:
            places |= {(j, i) for i, j in places}
        return places


@dataclass(frozen=True, eq=False)
class Suspensions:
    """What is believed of D, of which only the ratio rear over front and the time constants matter.

    `value` and `sd` (3,): K_rear / K_front, C/K front, C/K rear, s. A zero `sd` holds the number.
    """

    value: Array
    sd: Array

    def factor(self, numbers: Array, s: Points, corners: tuple[int, ...]) -> ComplexArray:
        """D over K_front (len(s), len(corners)) for the three `numbers`."""
        return np.stack([self._one(numbers, s, corner) for corner in corners], axis=1)

    @staticmethod
    def _one(numbers: Array, s: Points, corner: int) -> ComplexArray:
        if corner >= VERTICAL:  # no strut
            return np.ones(len(s), complex)
        if corner < 2:
            return np.asarray(1.0 + numbers[1] * s, complex)
        return np.asarray(numbers[0] * (1.0 + numbers[2] * s), complex)

    def slopes(self, numbers: Array, s: Points, corners: tuple[int, ...]) -> ComplexArray:
        """Derivatives (3, len(s), len(corners)) of `factor` by the three numbers."""
        out = np.zeros((3, len(s), len(corners)), complex)
        for j, corner in enumerate(corners):
            if corner < 2:
                out[1, :, j] = s
            elif corner < VERTICAL:
                out[0, :, j] = 1.0 + numbers[2] * s
                out[2, :, j] = numbers[0] * s
        return out


def input_name(number: int) -> str:
    """What a column is of: "A1" or, fore and aft, "A1 x"."""
    return AXLE_POINTS[number % VERTICAL] + (" x" if number >= VERTICAL else "")


def suspensions(values: Mapping[str, float], uncertainty: Mapping[str, float]) -> Suspensions:
    """D from the numbers of vehicle.toml and their standard deviations."""
    k, c, relative = {}, {}, {}
    for end in ("front", "rear"):
        stiffness, damping = (f"suspension.{end}.{q}" for q in ("stiffness_N_m", "damping_N_s_m"))
        k[end], c[end] = values[stiffness], values[damping]
        relative[end] = uncertainty[stiffness] / k[end]
        relative[f"{end} time"] = np.hypot(
            relative[end], uncertainty[damping] / c[end] if c[end] else 0.0
        )
    value = np.array([k["rear"] / k["front"], c["front"] / k["front"], c["rear"] / k["rear"]])
    sd = value * np.array(
        [
            np.hypot(relative["front"], relative["rear"]),
            relative["front time"],
            relative["rear time"],
        ]
    )
    return Suspensions(value, sd)
