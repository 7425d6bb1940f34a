"""A strut on a mount: the force of a spring and damper in series with Maxwell elements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wheelhop.material.model import Array, ComplexArray
from wheelhop.material.rational import Elements

QUICKEST_S = 2e-6
"""Least relaxation time of a mount as a whole: at 50 Hz it adds 0.06 % of the modulus."""


@dataclass(frozen=True, eq=False)
class Series:
    """Force k₀ δ + c₀ δ̇ + Σ gⱼ yⱼ of an extension δ, with ẏⱼ = λⱼ (δ − yⱼ): N/m, N·s/m, and the
    gains gⱼ, N/m, and rates λⱼ > 0, 1/s, of as many states as it takes."""

    stiffness_N_m: float
    damping_N_s_m: float
    gains_N_m: Array
    rates_1_s: Array

    def modulus(self, omega: Array) -> ComplexArray:
        """k₀ + iωc₀ + Σ gⱼ λⱼ/(λⱼ + iω) (f,), N/m."""
        modes = self.rates_1_s / (self.rates_1_s + 1j * omega[:, None])
        return np.asarray(
            self.stiffness_N_m + 1j * omega * self.damping_N_s_m + modes @ self.gains_N_m
        )


def exactly_in_series(strut: ComplexArray, mount: ComplexArray, share: float) -> ComplexArray:
    """D = S M/(M + share · S) (f,), N/m, of the dynamic stiffnesses (f,) of strut and mount: what
    `in_series` is with the specimen's own modulus, at given frequencies."""
    return strut * mount / (mount + share * strut)


def in_series(
    stiffness_N_m: float, damping_N_s_m: float, elements: Elements, share: float
) -> Series:
    """A strut S = k + c s on a mount whose compliance is `share` times that of the elements M:
    D = S M/(M + share · S), the strut alone for a share of 0.

    With w the mount's extension over the share, (M + share · S) w = S δ: with the elements' own
    states a linear system, whose rates are real and positive as are those of all springs and
    dampers. It is taken apart into its modes.
    """
    k, c = stiffness_N_m, damping_N_s_m
    strengths, times = elements.strengths_N_m, elements.times_s
    whole = elements.stiffness_N_m + float(strengths.sum())
    mount = max(elements.damping_N_s_m, QUICKEST_S * whole)
    resisting, spring = share * c + mount, share * k + whole
    # States w' = w − (c/C) δ, which holds no δ̇, and what each damper has come.
    n = len(times) + 1
    a = np.zeros((n, n))
    a[0, 0], a[0, 1:] = -spring / resisting, strengths / resisting
    a[1:, 0], a[1:, 1:] = 1 / times, -np.diag(1 / times)
    b = np.concatenate([[(k - spring * c / resisting) / resisting], c / resisting / times])
    rates, modes = np.linalg.eig(a)
    rates, modes = rates.real, modes.real
    out = -share * (k * np.eye(n)[0] + c * a[0])
    residues = (out @ modes) * np.linalg.solve(modes, b)
    return Series(
        k - share * k * c / resisting - share * c * b[0],
        c - share * c**2 / resisting,
        -residues / rates,
        -rates,
    )
