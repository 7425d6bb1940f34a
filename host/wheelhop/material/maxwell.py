"""The generalized Maxwell (Prony) model: a spring beside spring–damper chains."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from wheelhop.material.model import Array, Coefficient, ComplexArray, ModulusModel

PER_DECADE = 2
"""Relaxation times in a decade; more are hardly told apart by data."""


class GeneralizedMaxwell(ModulusModel):
    """M = E∞ + Σ Eᵢ iωτᵢ/(1 + iωτᵢ) with given times τᵢ, (3.3) in the frequency domain.

    Causal for real Eᵢ, passive for Eᵢ ≥ 0.
    """

    id = "generalized-maxwell"
    title = "generalized Maxwell (Prony)"
    equation = r"M = E_\infty + \sum_i E_i\,\frac{i\omega\tau_i}{1 + i\omega\tau_i}"
    source = "J. D. Ferry, Viscoelastic Properties of Polymers, 3rd ed. (Wiley 1980), ch. 3"
    non_negative = True

    def __init__(self, times_s: Sequence[float]) -> None:
        self.times_s = np.asarray(times_s, dtype=np.float64)
        self.coefficients = tuple(
            Coefficient(name, "N/m", 0.0)
            for name in ("E_inf", *(f"E{i + 1}" for i in range(len(self.times_s))))
        )

    @classmethod
    def over(cls, omega: Array) -> GeneralizedMaxwell:
        """With times over the range of ω (f,), half a decade beyond its ends, evenly on a
        logarithmic scale, and no more of them than half the numbers measured."""
        low, high = np.log10(1 / omega.max()) - 0.5, np.log10(1 / omega.min()) + 0.5
        count = min(1 + round(PER_DECADE * (high - low)), max(1, len(omega) - 2))
        return cls(np.logspace(low, high, count).tolist())

    def modulus(self, omega: Array, parameters: Array) -> ComplexArray:
        """The sum."""
        return np.asarray(self.derivatives(omega, parameters) @ parameters)

    def derivatives(self, omega: Array, parameters: Array) -> ComplexArray:
        """The basis itself: the model is linear."""
        return self.basis(omega, np.empty(0))

    def shapes(self, omega: Array) -> Iterable[Array]:
        """None to choose."""
        return [np.empty(0)]

    def basis(self, omega: Array, shape: Array) -> ComplexArray:
        """1 and iωτ/(1 + iωτ)."""
        phase = 1j * omega[:, None] * self.times_s
        return np.concatenate([np.ones((len(omega), 1)), phase / (1 + phase)], axis=1)

    def admits(self, shape: Array) -> bool:
        """There is none."""
        return True

    def assembled(self, weights: Array, shape: Array) -> Array:
        """E∞, E₁ …"""
        return weights
