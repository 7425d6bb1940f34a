"""A specimen for the time domain: a spring and a damper beside as few Maxwell elements as it takes.

Every element's numbers are positive, so that the approximation is causal and passive by itself; a
modulus that cannot be followed that way is no passive specimen's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from wheelhop.material.error import MaterialError
from wheelhop.material.model import Array, ComplexArray

BAND_HZ = (0.1, 50.0)
TOLERANCE = 0.01
"""Largest |M̂/M − 1| in the band."""
MOST_ELEMENTS = 24
POINTS = 121
PADDING = (1.0, 3.0, 10.0)
"""How far beyond the band relaxation times may lie, as a factor."""


@dataclass(frozen=True, eq=False)
class Elements:
    """M = E + c s + Σ Eᵢ sτᵢ/(1 + sτᵢ), nothing negative: a spring E, N/m, a damper c, N·s/m, and
    Maxwell elements Eᵢ, N/m, with relaxation times τᵢ, s."""

    stiffness_N_m: float
    damping_N_s_m: float
    strengths_N_m: Array
    times_s: Array

    def modulus(self, omega: Array) -> ComplexArray:
        """M(iω) (f,), N/m."""
        phase = 1j * omega[:, None] * self.times_s
        chains = (phase / (1 + phase)) @ self.strengths_N_m
        return np.asarray(self.stiffness_N_m + 1j * omega * self.damping_N_s_m + chains)


def approximate(
    modulus: Callable[[Array], ComplexArray],
    band_hz: tuple[float, float] = BAND_HZ,
    tolerance: float = TOLERANCE,
) -> Elements:
    """The fewest elements that follow M(iω) within `tolerance` over `band_hz`.

    Relaxation times lie evenly on a logarithmic scale over the band and a little beyond, their
    number growing until it suffices; strengths are non-negative least squares of the relative
    error. Raises `MaterialError` if no such elements do.
    """
    omega = 2 * np.pi * np.geomspace(*band_hz, POINTS)
    exact = modulus(omega)
    nearest = np.inf
    for count in range(MOST_ELEMENTS + 1):
        for padding in PADDING:
            trial = _fitted(omega, exact, padding, count)
            error = float(np.abs(trial.modulus(omega) / exact - 1).max())
            if error <= tolerance:
                return trial
            nearest = min(nearest, error)
    raise MaterialError(
        f"springs, dampers and Maxwell elements follow the modulus within {100 * nearest:.2g} %"
        f" only over {band_hz[0]:g} to {band_hz[1]:g} Hz, not {100 * tolerance:g} %: is it that of"
        " a passive specimen there?"
    )


def _fitted(omega: Array, exact: ComplexArray, padding: float, count: int) -> Elements:
    times = np.geomspace(padding / omega[0], 1 / (padding * omega[-1]), count)
    phase = 1j * omega[:, None] * times
    columns = np.concatenate(
        [np.ones((len(omega), 1)), 1j * omega[:, None], phase / (1 + phase)], axis=1
    )
    relative = columns / exact[:, None]
    stacked = np.concatenate([relative.real, relative.imag])
    target = np.concatenate([np.ones(len(omega)), np.zeros(len(omega))])
    size = np.sqrt((stacked**2).sum(axis=0))
    weights = optimize.nnls(stacked / size, target)[0] / size
    used = weights[2:] > 0.0
    return Elements(float(weights[0]), float(weights[1]), weights[2:][used], times[used])
