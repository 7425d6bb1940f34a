"""The generalized quarter car: an identified body on other suspensions and wheels.

The body with its suspensions' far ends held answers forces F at the attachment points by X = S F.
Other suspensions act as the force D_n (Y - X) + D_o X: the new strut, and the old one taken away,
which S contains. Each wheel is m s² Y = D_n (X - Y) + D_t (U - Y) on the ground's height U. Closing
these loops in state space gives X = G U without inverting a matrix of polynomials: thesis 2.16,
2.18 and 2.25 at once, and 5.16, 5.21 and 5.23 with S = H D_o⁻¹. Raising the ground raises the
body. The published H_n has the opposite sign: B of 5.22 was taken as positive there, as the check
after 2.25 has it, which says that B = I for a tyre that does not yield, where 2.21 gives -I.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.identify.statespace import StateSpace

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
    return _closed(s, old, new, None)


def on_wheels(s: StateSpace, old: Struts, new: Struts, wheels: Wheels) -> StateSpace:
    """G: from the ground under the wheels to the body (thesis 2.25; H_n of 5.23)."""
    return _closed(s, old, new, wheels)


def _closed(s: StateSpace, old: Struts, new: Struts, wheels: Wheels | None) -> StateSpace:
    """All loops closed. The states are those of S, then what carries the far ends: their position
    alone, or position and momentum less the tyre damper's share of the ground's motion."""
    if s.d.any():
        raise ValueError("a body that jumps when pushed has no inertia: S must be strictly proper")
    n = s.order
    eye = np.eye(4)
    kn, cn = np.diag(new.stiffness), np.diag(new.damping)
    dk, dc = kn - np.diag(old.stiffness), cn - np.diag(old.damping)
    # F = kn Y + cn Y' - dk X - dc X', with X' = C A x + C B F: solved for F.
    through = np.linalg.inv(eye + dc @ s.c @ s.b)
    if wheels is None:
        # Y' is no state here: F = kn Y + cn Y', and the integral of F's second part is cn Y.
        shift = s.b @ through @ cn
        a = s.a - s.b @ through @ (dk @ s.c + dc @ s.c @ s.a)
        b = a @ shift + s.b @ through @ kn
        return StateSpace(a, b, s.c, s.c @ shift)
    m, kt, ct = (
        np.diag(corners(pair))
        for pair in (wheels.mass_kg, wheels.stiffness_N_m, wheels.damping_N_s_m)
    )
    inverse = np.linalg.inv(m)
    # States x, Y and p = m Y' - ct U, so that Y' = m⁻¹ (p + ct U).
    from_x = np.hstack([s.c, np.zeros((4, 8))])
    y = np.hstack([np.zeros((4, n)), eye, np.zeros((4, 4))])
    rate_y = np.hstack([np.zeros((4, n + 4)), inverse])
    rate_y_u = inverse @ ct
    x_a = np.hstack([s.c @ s.a, np.zeros((4, 8))])
    force = through @ (kn @ y + cn @ rate_y - dk @ from_x - dc @ x_a)
    force_u = through @ cn @ rate_y_u
    rate_x = x_a + s.c @ s.b @ force
    rate_x_u = s.c @ s.b @ force_u
    strut = kn @ (from_x - y) + cn @ (rate_x - rate_y)
    strut_u = cn @ (rate_x_u - rate_y_u)
    momentum = strut - kt @ y - ct @ rate_y
    momentum_u = strut_u + kt - ct @ rate_y_u
    body = np.hstack([s.a, np.zeros((n, 8))]) + s.b @ force
    a = np.vstack([body, rate_y, momentum])
    b = np.vstack([s.b @ force_u, rate_y_u, momentum_u])
    return StateSpace(a, b, from_x, np.zeros((4, 4)))


def free_motion(
    s: StateSpace, old: Struts, new: Struts, wheels: Wheels
) -> tuple[ComplexArray, ComplexArray]:
    """Poles (k,), rad/s, of the modes of :func:`on_wheels` that oscillate, one of each conjugate
    pair, and how B1 to B4 and A1 to A4 move in them (k, 8)."""
    system = on_wheels(s, old, new, wheels)
    pole, vector = np.linalg.eig(system.a)
    oscillates = (pole.imag > 0.0) & (-pole.real < np.abs(pole))
    vector = vector[:, oscillates]
    shape = np.vstack([system.c @ vector, vector[s.order : s.order + 4]]).T
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
