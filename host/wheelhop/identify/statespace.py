"""Linear systems as matrices A, B, C, D: what transfer matrices are computed with at any order.

Numerators and denominators of order 44, as in the thesis, cannot be computed with in double
precision: their coefficients span seventy decades. States can.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg

from wheelhop.identify.sections import Sections

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class StateSpace:
    """ẋ = A x + B u, y = C x + D u (thesis A.10), with n states, m inputs, p outputs."""

    a: Array  #: (n, n)
    b: Array  #: (n, m)
    c: Array  #: (p, n)
    d: Array  #: (p, m)

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.a)

    def __call__(self, s: ArrayLike) -> ComplexArray:
        """The transfer matrix at the points s, (len(s), p, m)."""
        s = np.atleast_1d(np.asarray(s, complex))
        inner = np.linalg.solve(s[:, None, None] * np.eye(self.order) - self.a, self.b)
        return np.asarray(self.c @ inner + self.d)

    def poles(self) -> ComplexArray:
        """Eigenvalues of A (n,), rad/s."""
        return np.asarray(np.linalg.eigvals(self.a), complex)

    def static(self) -> Array:
        """The transfer matrix at s = 0, (p, m)."""
        out: Array = self.d - self.c @ np.linalg.solve(self.a, self.b)
        return out

    def part(self, output: int, input_: int) -> StateSpace:
        """One element, with all states."""
        return StateSpace(
            self.a,
            self.b[:, [input_]],
            self.c[[output]],
            self.d[[output]][:, [input_]],
        )

    def block(self, places: Sequence[int]) -> StateSpace:
        """The elements between these inputs and the outputs of the same numbers."""
        at = list(places)
        return StateSpace(self.a, self.b[:, at], self.c[at], self.d[np.ix_(at, at)])

    def step(self, time_s: Array) -> Array:
        """Response (len(time_s), p, m) to a unit step of each input at time 0; uniform times."""
        dt = float(time_s[1] - time_s[0])
        n, m = self.b.shape
        both = np.zeros((n + m, n + m))
        both[:n, :n], both[:n, n:] = self.a * dt, self.b * dt
        forward = linalg.expm(both)
        state = np.zeros((n, m))
        out = np.empty((len(time_s), *self.d.shape))
        for k in range(len(time_s)):
            out[k] = self.c @ state + self.d
            state = forward[:n, :n] @ state + forward[:n, n:]
        return out


def of_fractions(sections: Sections, theta: Array, direct: Array | None = None) -> StateSpace:
    """State space of Σ theta[i, j] · fractions(s) + direct, (p, m, order) -> order · m states."""
    a, b, _ = sections.state_matrix()
    outputs, inputs, _ = theta.shape
    eye: Array = np.eye(inputs)
    return StateSpace(
        np.asarray(np.kron(eye, a), float),
        np.asarray(np.kron(eye, b[:, None]), float),
        theta.reshape(outputs, -1),
        np.zeros((outputs, inputs)) if direct is None else direct,
    )


def balanced_reduction(system: StateSpace, order: int) -> tuple[StateSpace, Array]:
    """The stable system with `order` states left, and its Hankel singular values (n,).

    Balanced by the square-root method (M. Tombs and I. Postlethwaite, Int. J. Control 46 (1987)
    1319), the weak states then set to rest and not dropped, so that the static response is kept:
    `balred` with MatchDC in the thesis (A.3, A.13).

    Raises
    ------
    ValueError : an order that is not from 1 up, or a system that does not decay.
    """
    if not order >= 1:
        raise ValueError(f"an order of {order} is no model: give 1 or more")
    if (system.poles().real >= 0).any():
        raise ValueError("balanced reduction needs a system that decays: it has a pole with σ >= 0")
    reach = _factor(system.a, system.b)
    observe = _factor(system.a.T, system.c.T)
    u, hankel, vt = np.linalg.svd(observe.T @ reach)
    keep = int(np.sum(hankel > hankel[0] * 1e-13))
    scale = 1.0 / np.sqrt(hankel[:keep])
    left = (observe @ u[:, :keep]) * scale
    right = (reach @ vt[:keep].T) * scale
    a, b, c = left.T @ system.a @ right, left.T @ system.b, system.c @ right
    # What the balanced form cut off below 1e-13 still counts at s = 0: keep it exactly.
    d = system.static() + c @ np.linalg.solve(a, b)
    if order < keep:
        strong, weak = slice(0, order), slice(order, None)
        rest = np.linalg.solve(a[weak, weak], np.hstack([a[weak, strong], b[weak]]))
        d = d - c[:, weak] @ rest[:, order:]
        b, c = (
            b[strong] - a[strong, weak] @ rest[:, order:],
            c[:, strong] - c[:, weak] @ rest[:, :order],
        )
        a = a[strong, strong] - a[strong, weak] @ rest[:, :order]
    return StateSpace(a, b, c, d), np.asarray(hankel)


def _factor(a: Array, b: Array) -> Array:
    """L with L Lᵀ the Gramian ∫ e^{At} B Bᵀ e^{Aᵀt} dt."""
    gramian = linalg.solve_continuous_lyapunov(a, -b @ b.T)
    values, vectors = np.linalg.eigh((gramian + gramian.T) / 2)
    out: Array = vectors * np.sqrt(np.maximum(values, 0.0))
    return out
