"""The generalized quarter car: an identified body on other suspensions and wheels.

The body with its suspensions' far ends held answers forces F at the attachment points by X = S F.
Other suspensions act as the force D_n (Y - X) + D_o X: the new strut, and the old one taken away,
which S contains. Each wheel is m s² Y = D_n (X - Y) + D_t (U - Y) on the ground's height U. Closing
these loops in state space gives X = G U without inverting a matrix of polynomials: thesis 2.16,
2.18 and 2.25 at once, and 5.16, 5.21 and 5.23 with S = H D_o⁻¹. Raising the ground raises the
body. The published H_n has the opposite sign: B of 5.22 was taken as positive there, as the check
after 2.25 has it, which says that B = I for a tyre that does not yield, where 2.21 gives -I.
`legs` closes the loops, for struts and wheels richer than the thesis's as well (its section 2.12).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.identify.legs import BODY, FIXED, GROUND, Legs, Link, check_body, closed
from wheelhop.identify.statespace import StateSpace
from wheelhop.material.rational import Elements

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True)
class Struts:
    """Stiffness, N/m, and damping, N·s/m, of the four suspensions; each side like the other."""

    front_N_m: float
    rear_N_m: float
    front_N_s_m: float
    rear_N_s_m: float

    @property
    def stiffness(self) -> Array:
        """(4,)"""
        return np.array([self.front_N_m] * 2 + [self.rear_N_m] * 2)

    @property
    def damping(self) -> Array:
        """(4,)"""
        return np.array([self.front_N_s_m] * 2 + [self.rear_N_s_m] * 2)


@dataclass(frozen=True)
class Wheels:
    """Unsprung mass, kg, tyre stiffness, N/m, and damping, N·s/m, as (front, rear)."""

    mass_kg: tuple[float, float]
    stiffness_N_m: tuple[float, float]
    damping_N_s_m: tuple[float, float]


@dataclass(frozen=True)
class Part:
    """A second mass in each wheel, kg, on springs, N/m, and dampers, N·s/m, of its own, as (front,
    rear): a hub motor that hangs in the wheel or, with `on_ground`, the tyre's belt, between which
    and the rim these springs are and on which the tyre's own stand."""

    mass_kg: tuple[float, float]
    stiffness_N_m: tuple[float, float]
    damping_N_s_m: tuple[float, float]
    on_ground: bool = False


@dataclass(frozen=True, eq=False)
class Bushings:
    """A bushing in line with each strut, `elements` times so much (front, rear)."""

    elements: Elements
    factor: tuple[float, float] = (1.0, 1.0)


def corners(pair: tuple[float, float]) -> Array:
    """Front and rear values as those of the four corners."""
    return np.repeat(pair, 2)


def compliance(h: StateSpace, old: Struts) -> StateSpace:
    """S = H D_o⁻¹, N to m, of a transfer matrix H from axle to body motion (thesis 5.11-5.16)."""
    k, c = old.stiffness, old.damping
    if (c == 0).any():
        if (c > 0).any():
            raise ValueError("suspensions with and without damping: give all of them some")
        return StateSpace(h.a, h.b / k, h.c, h.d / k)
    # The force through D_o⁻¹ = 1/(K + C s) is a displacement with a state of its own.
    n = h.order
    a = np.zeros((n + 4, n + 4))
    a[:n, :n], a[:n, n:] = h.a, h.b
    a[n:, n:] = -np.diag(k / c)
    b = np.vstack([np.zeros((n, 4)), np.diag(1.0 / c)])
    return StateSpace(a, b, np.hstack([h.c, h.d]), np.zeros((4, 4)))


def other_suspensions(s: StateSpace, old: Struts, new: Struts) -> StateSpace:
    """H_n: from the motion of the suspensions' far ends to the body's (thesis 2.18, 5.21)."""
    check_body(s)
    kn, cn = np.diag(new.stiffness), np.diag(new.damping)
    dk, dc = kn - np.diag(old.stiffness), cn - np.diag(old.damping)
    # F = kn Y + cn Y' - dk X - dc X', with X' = C A x + C B F: solved for F. Y' is no state: the
    # integral of F's second part is cn Y.
    through = np.linalg.inv(np.eye(4) + dc @ s.c @ s.b)
    shift = s.b @ through @ cn
    a = s.a - s.b @ through @ (dk @ s.c + dc @ s.c @ s.a)
    b = a @ shift + s.b @ through @ kn
    return StateSpace(a, b, s.c, s.c @ shift)


def on_wheels(
    s: StateSpace,
    old: Struts,
    new: Struts,
    wheels: Wheels,
    bushings: Bushings | None = None,
    part: Part | None = None,
) -> StateSpace:
    """G: from the ground under the wheels to the body (thesis 2.25; H_n of 5.23).

    With `bushings` D_n is that of strut and bushing in line, D M / (D + M); with a `part` the
    wheel's T of (2.19) has two masses.
    """
    return closed(s, legs(old, new, wheels, bushings, part))


def legs(
    old: Struts, new: Struts, wheels: Wheels, bushings: Bushings | None, part: Part | None
) -> Legs:
    """What is between ground and body, less the suspension that the body was identified on. Raises
    CampaignError for a place without mass that no damper holds."""
    mass = [corners(wheels.mass_kg)]
    stands = 0
    links = [Link(BODY, FIXED, -old.stiffness, -old.damping)]
    if part is not None:
        mass.append(corners(part.mass_kg))
        stands = 1 if part.on_ground else 0
        links.append(Link(0, 1, corners(part.stiffness_N_m), corners(part.damping_N_s_m)))
    tyre = corners(wheels.stiffness_N_m), corners(wheels.damping_N_s_m)
    links.append(Link(GROUND, stands, *tyre))
    top = BODY
    if bushings is not None:
        top = len(mass)
        mass.append(np.zeros(4))
        of, times = bushings.elements, corners(bushings.factor)
        stiffness, damping = of.stiffness_N_m * times, of.damping_N_s_m * times
        strengths = np.outer(of.strengths_N_m, times)
        links.append(Link(top, BODY, stiffness, damping, strengths, of.times_s))
        if not (new.damping + damping > 0.0).all():
            raise CampaignError("a strut in line with a bushing needs damping, or the bushing some")
    links.append(Link(0, top, new.stiffness, new.damping))
    return Legs(np.array(mass), tuple(links))


def free_motion(s: StateSpace, between: Legs) -> tuple[ComplexArray, ComplexArray]:
    """Poles (k,), rad/s, of the modes of :func:`on_wheels` that oscillate, one of each conjugate
    pair, and how B1 to B4 and the legs' masses move in them (k, 4 + 4 masses): A1 to A4 first."""
    system = closed(s, between)
    pole, vector = np.linalg.eig(system.a)
    oscillates = (pole.imag > 0.0) & (-pole.real < np.abs(pole))
    vector = vector[:, oscillates]
    heavy = vector[s.order : s.order + int(np.sum(between.mass_kg > 0.0))]
    shape = np.vstack([system.c @ vector, heavy]).T
    return np.asarray(pole[oscillates], complex), np.asarray(shape, complex)


def inertia_at_points(motions: Array, inertia: Array) -> Array:
    """M (4, 4), kg, with ẋᵀ M ẋ / 2 the kinetic energy of a body whose points B1 to B4 move by x.

    Its four motions, with `inertia` (4,) each, move the points by the columns of `motions` (4, 4).
    """
    inverse = np.linalg.inv(motions)
    return np.asarray(inverse.T @ (inertia[:, None] * inverse))


def rigid_inertia(positions: Array, inertia: Sequence[float]) -> Array:
    """Mass matrix (4, 4) in point motions of a rigid body with its points at `positions` (4, 2),
    (x, y) from its centre of mass, m; `inertia` is its mass, kg, and its inertia in pitch and in
    roll, kg m².

    It cannot twist. If it is seen to, by a frame that bends or by noise, this counts as though all
    its mass moved as its points do.
    """
    x, y = positions.T
    motions = np.column_stack([np.ones(4), -x, y, [1.0, -1.0, -1.0, 1.0]])
    return inertia_at_points(motions, np.array([*inertia, inertia[0]]))


def wheel_hop_hz(mass_kg: float, tyre_N_m: float, strut_N_m: float) -> float:
    """Frequency of a wheel under a body held still (thesis 2.27)."""
    return float(np.sqrt((tyre_N_m + strut_N_m) / mass_kg) / (2 * np.pi))
