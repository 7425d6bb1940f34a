"""A common denominator as second-order sections, and the fractions that stand over them.

Every element of a transfer matrix with the denominator Π (s² + 2ζωs + ω²) (thesis 5.3) is a sum of

    ω² / (s² + 2ζωs + ω²)     and     ω s / (s² + 2ζωs + ω²)

with real coefficients (partial fractions). An odd order has one section r / (s + r) more. Unlike
powers of s these are all of about the size 1, and unlike poles and residues they stay smooth
where a pair of complex poles becomes two real ones (ζ > 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Points = NDArray[np.complexfloating[Any, Any]]
"""Values of s."""


@dataclass(frozen=True, eq=False)
class Sections:
    """Natural frequencies `omega` (m,), rad/s, damping ratios `zeta` (m,), and the `rate`, 1/s, of
    the one real pole of an odd order (None: the order is even).

    A ζ below zero is an unstable pair; above one, two real poles.
    """

    omega: Array
    zeta: Array
    rate: float | None = None

    @property
    def order(self) -> int:
        """Number of poles."""
        return 2 * len(self.omega) + (self.rate is not None)

    @property
    def frequency_hz(self) -> Array:
        """Natural frequencies (m,), Hz."""
        return self.omega / (2 * np.pi)

    def poles(self) -> ComplexArray:
        """All poles (order,), rad/s."""
        root = np.sqrt((self.zeta**2 - 1.0).astype(complex))
        pairs = [self.omega * (-self.zeta + root), self.omega * (-self.zeta - root)]
        single = [] if self.rate is None else [np.array([-self.rate], complex)]
        return np.concatenate([*pairs, *single])

    def denominator(self) -> Array:
        """Coefficients (order + 1,) of the monic common denominator, highest power first
        (thesis 5.4)."""
        out = np.ones(1)
        for omega, zeta in zip(self.omega, self.zeta, strict=True):
            out = np.convolve(out, [1.0, 2 * zeta * omega, omega**2])
        return out if self.rate is None else np.convolve(out, [1.0, self.rate])

    def basis(self, s: Points) -> ComplexArray:
        """The fractions (len(s), order): first all ω²/(…), then all ωs/(…), then r/(s + r)."""
        s = np.asarray(s, complex)[:, None]
        below = s**2 + 2 * self.zeta * self.omega * s + self.omega**2
        parts: list[ComplexArray] = [self.omega**2 / below, self.omega * s / below]
        if self.rate is not None:
            parts.append(np.asarray(self.rate / (s + self.rate), complex))
        return np.hstack(parts)

    def basis_slopes(self, s: Points) -> ComplexArray:
        """Derivatives (order, len(s), order) of `basis` by ln ω (m of them), ζ (m) and ln r."""
        s = np.asarray(s, complex)
        m = len(self.omega)
        basis = self.basis(s)
        slopes = np.zeros((self.order, len(s), self.order), complex)
        for i, (omega, zeta) in enumerate(zip(self.omega, self.zeta, strict=True)):
            below = s**2 + 2 * zeta * omega * s + omega**2
            by_omega = (2 * zeta * omega * s + 2 * omega**2) / below
            by_zeta = 2 * omega * s / below
            for column, power in ((i, 2.0), (m + i, 1.0)):
                slopes[i, :, column] = basis[:, column] * (power - by_omega)
                slopes[m + i, :, column] = -basis[:, column] * by_zeta
        if self.rate is not None:
            slopes[-1, :, -1] = basis[:, -1] * s / (s + self.rate)
        return slopes

    def at_zero(self) -> tuple[Array, Array]:
        """Values and first derivatives by s (order,) of the fractions at s = 0."""
        m = len(self.omega)
        value, slope = np.zeros(self.order), np.zeros(self.order)
        value[:m] = 1.0
        slope[:m] = -2 * self.zeta / self.omega
        slope[m : 2 * m] = 1.0 / self.omega
        if self.rate is not None:
            value[-1], slope[-1] = 1.0, -1.0 / self.rate
        return value, slope

    def state_matrix(self) -> tuple[Array, Array, Array]:
        """Real A (order, order), b (order,), C (order, order) with basis(s)ᵀ = C (sI - A)⁻¹ b."""
        n, m = self.order, len(self.omega)
        a, b, c = np.zeros((n, n)), np.zeros(n), np.eye(n)
        for i, (omega, zeta) in enumerate(zip(self.omega, self.zeta, strict=True)):
            # The states are the two fractions themselves: d/dt f₀ = ω f₁.
            a[i, m + i] = omega
            a[m + i, i] = -omega
            a[m + i, m + i] = -2 * zeta * omega
            b[m + i] = omega
        if self.rate is not None:
            a[-1, -1], b[-1] = -self.rate, self.rate
        return a, b, c

    def parameters(self) -> Array:
        """ln ω (m), ζ (m) and ln r as one vector (order,)."""
        single = [] if self.rate is None else [np.log(self.rate)]
        return np.concatenate([np.log(self.omega), self.zeta, single])

    def sorted(self) -> Sections:
        """These sections from the lowest natural frequency to the highest."""
        order = np.argsort(self.omega)
        return Sections(self.omega[order], self.zeta[order], self.rate)


def from_parameters(parameters: Array) -> Sections:
    """The inverse of `Sections.parameters`."""
    m = len(parameters) // 2
    rate = float(np.exp(parameters[-1])) if len(parameters) % 2 else None
    return Sections(np.exp(parameters[:m]), np.array(parameters[m : 2 * m]), rate)


def from_poles(poles: ComplexArray, *, stable: bool = True) -> Sections:
    """Sections with these poles (conjugates given in pairs); `stable` mirrors those on the right.

    Real poles are paired, the slowest with the fastest, which keeps ζ moderate; of an odd number
    of them the middle one stays single.
    """
    poles = np.asarray(poles, complex)
    if stable:
        poles = -np.abs(poles.real) + 1j * poles.imag
    upper = poles[poles.imag > 1e-12 * np.abs(poles)]
    real = np.sort(np.abs(poles[np.abs(poles.imag) <= 1e-12 * np.abs(poles)].real))
    sign = np.sign(poles[np.abs(poles.imag) <= 1e-12 * np.abs(poles)].real)
    half = len(real) // 2
    low, high = real[:half], real[len(real) - half :][::-1]
    if not stable and (sign > 0).any():
        raise ValueError("an unstable real pole has no section; start from complex poles")
    omega = np.concatenate([np.abs(upper), np.sqrt(low * high)])
    zeta = np.concatenate([-upper.real / np.abs(upper), (low + high) / (2 * np.sqrt(low * high))])
    return Sections(omega, zeta, float(real[half]) if len(real) % 2 else None).sorted()
