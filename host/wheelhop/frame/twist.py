"""Torsion between the axles: static stiffness, and the modes a diagnosis would find."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from wheelhop.frame.assemble import FiniteElements, dofs_of
from wheelhop.frame.modes import Modes
from wheelhop.frame.statics import floating

Array = NDArray[np.float64]

TORSIONAL_SHARE = 0.1
"""A mode that makes less of the static twist than this is not called torsional."""


@dataclass(frozen=True, eq=False)
class FrameTwist:
    """Each of k modes in the parameters of the effect `frame-twist`, and its part of the twist."""

    freq_hz: Array  #: (k,)
    participation_1_kg: Array  #: (k,)
    share: Array  #: (k,) of the corners' static twist under twisting loads; all modes make 1

    @property
    def first(self) -> int | None:
        """The first torsional mode: the lowest that makes a tenth of the static twist, if any."""
        large = np.flatnonzero(self.share >= TORSIONAL_SHARE)
        return int(large[0]) if len(large) else None


def warp(elements: FiniteElements) -> Array:
    """The vertical forces (4,) at the four corners that balance by themselves, of mean square 1:
    (1, −1, −1, 1) for a rectangle.

    Neither their sum nor their moments about x and y are anything, so they twist the frame and
    need no support.
    """
    x, y, _ = elements.position[elements.corners].T
    *_, last = np.linalg.svd(np.stack([np.ones(4), x, y]))[2]
    return np.asarray(2 * last * np.sign(last[0]))


def torsional_stiffness(elements: FiniteElements) -> float:
    """Torque of an opposite pair of vertical forces at the front corners over the angle of the
    front against the rear, where the other pair holds it; N m/rad.

    The rear holds no more than it must, vertical forces alone: T² / fᵀx with f the forces of
    `warp` and x the corners' displacements. Rear corners clamped in every direction would
    make the frame stiffer by what those clamps add.
    """
    force = warp(elements)
    torque = float(force[:2] @ elements.position[elements.corners[:2], 1])
    return torque**2 / _flexibility(elements, force)


def frame_twist(elements: FiniteElements, modes: Modes) -> FrameTwist:
    """Every mode in the parameters of the effect `frame-twist`.

    The effect moves the corners by the pattern s = (1, −1, −1, 1) times τ, with
    m_τ (τ̈ + 2ζωτ̇ + ω²τ) = Σ sᵢFᵢ. A mode of shape φ at the corners, normalised to 1 kg, moves
    them by φη with η̈ + 2ζωη̇ + ω²η = Σ φᵢFᵢ. The part of φ that is no heave, pitch or roll of
    the four corners is a s, with a = sᵀφ / sᵀs. Of this part alone τ = aη, and 1/m_τ = a²: the
    participation, 1/kg. Corners that are no rectangle take the pattern of `warp` for s.

    The static twist under forces s is Σ (sᵀφ)²/ω² over all modes; each term is a mode's share.
    Frequencies are those of the frame with what it carries, without wheels, as the effect's.
    """
    pattern = warp(elements)
    along = pattern @ modes.shape[dofs_of(elements.corners, (2,))]
    twisted = (along / (2 * pi * modes.frequency_hz)) ** 2
    return FrameTwist(
        modes.frequency_hz,
        (along / (pattern @ pattern)) ** 2,
        twisted / _flexibility(elements, pattern),
    )


def _flexibility(elements: FiniteElements, force: Array) -> float:
    """Work of vertical forces at the corners on the displacements they cause."""
    load = np.zeros(elements.mass.shape[0])
    load[dofs_of(elements.corners, (2,))] = force
    return float(load @ floating(elements)(load))
