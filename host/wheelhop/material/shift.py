"""Temperature: one specimen measured at several, brought onto one master curve.

A rubber that is warmer does the same faster: M(ω, T) = M(ω a_T, T₀), with the shift of M. Williams,
R. Landel, J. Ferry, J. Am. Chem. Soc. 77 (1955) 3701, eq. 3,

    log₁₀ a_T = −C₁ (T − T₀) / (C₂ + T − T₀).

C₁ and C₂ are those with which a model follows the moduli of all temperatures best. Stiffness that
grows with temperature itself, a vertical shift, is left out: a tenth from −20 to 10 °C.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from wheelhop.material.data import ModulusData
from wheelhop.material.error import MaterialError
from wheelhop.material.fit import ModulusFit, fit_modulus
from wheelhop.material.model import Array, ModulusModel

START = (8.86, 101.6)
"""C₁ and C₂ (K) of most rubbers 50 K above their glass transition (ibid.)."""
FEWEST = 3
"""Temperatures: two tell a shift, not how it goes on."""
NEAREST_K = 5.0
"""So far below the coldest specimen lies the temperature at which the shift has no bound."""


@dataclass(frozen=True, eq=False)
class TemperatureShift:
    """The shift to a reference temperature, and the model fitted to the master curve; ``apart``
    (n,) are the rms errors of the same model fitted to each temperature by itself."""

    reference_degC: float
    temperatures_degC: Array
    c1: float
    c2_K: float
    master: ModulusFit
    apart: Array

    def log10_shift(self, temperature_degC: Array | float) -> Array:
        """log₁₀ a_T at temperatures, °C."""
        return _shift(np.asarray(temperature_degC) - self.reference_degC, self.c1, self.c2_K)

    def at(self, temperature_degC: float, data: ModulusData) -> ModulusData:
        """The master curve's model at a temperature, at the frequencies of `data`."""
        omega = data.omega * 10.0 ** float(self.log10_shift(temperature_degC))
        return ModulusData(
            data.name, data.frequency_hz, self.master.modulus(omega), data.uncertainty
        )


def shift_temperatures(
    moduli: Sequence[ModulusData],
    temperatures_degC: Sequence[float],
    model: ModulusModel,
    reference_degC: float,
) -> TemperatureShift:
    """Fit C₁, C₂ and a model's parameters to one specimen at several temperatures.

    Raises `MaterialError` for fewer than three temperatures, or if the model cannot follow one of
    them.
    """
    away = np.asarray(temperatures_degC, dtype=float) - reference_degC
    if len(set(away.tolist())) < FEWEST:
        raise MaterialError(
            f"{moduli[0].name}: the shift with temperature takes at least {FEWEST} temperatures"
        )
    apart = [fit_modulus(model, one) for one in moduli]
    least = NEAREST_K - min(float(away.min()), 0.0)

    def numbers(x: Array) -> tuple[float, float]:
        return float(np.exp(x[0])), least + float(np.exp(x[1]))

    def error(x: Array) -> float:
        try:
            return fit_modulus(model, _master(moduli, _shift(away, *numbers(x)))).error
        except MaterialError:
            return np.inf

    begin = np.log([START[0], max(START[1] - least, 1.0)])
    found = optimize.minimize(
        error, begin, method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-6}
    )
    c1, c2 = numbers(found.x)
    master = fit_modulus(model, _master(moduli, _shift(away, c1, c2)))
    rms = np.array([one.rms for one in apart])
    return TemperatureShift(reference_degC, away + reference_degC, c1, c2, master, rms)


def _shift(away: Array, c1: float, c2: float) -> Array:
    return np.asarray(-c1 * away / (c2 + away))


def _master(moduli: Sequence[ModulusData], shift: Array) -> ModulusData:
    """All moduli at the frequencies where the reference temperature has them."""
    frequency = np.concatenate(
        [one.frequency_hz * 10.0**s for one, s in zip(moduli, shift, strict=True)]
    )
    order = np.argsort(frequency, kind="stable")
    return ModulusData(
        moduli[0].name,
        frequency[order],
        np.concatenate([one.modulus for one in moduli])[order],
        np.concatenate([one.uncertainty for one in moduli])[order],
    )
