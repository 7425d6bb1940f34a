"""Which model the data ask for: small-sample information criterion and held-out frequencies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, log

import numpy as np

from wheelhop.material.data import FEWEST, ModulusData
from wheelhop.material.error import MaterialError
from wheelhop.material.fit import ModulusFit, fit_modulus, log_error
from wheelhop.material.maxwell import GeneralizedMaxwell
from wheelhop.material.model import Array, ModulusModel
from wheelhop.material.models import (
    CausalPowerLaw,
    FractionalKelvinVoigt,
    FractionalZener,
    LogarithmicPolynomial,
    ModifiedPowerLaw,
    PowerLogarithm,
)

BLOCKS = 5
"""Neighbouring frequencies are held out together, so many parts in turn."""

MODELS: dict[str, Callable[[Array], ModulusModel]] = {
    ModifiedPowerLaw.id: lambda omega: ModifiedPowerLaw(),
    CausalPowerLaw.id: lambda omega: CausalPowerLaw(),
    LogarithmicPolynomial.id: lambda omega: LogarithmicPolynomial(),
    FractionalKelvinVoigt.id: lambda omega: FractionalKelvinVoigt(),
    FractionalZener.id: lambda omega: FractionalZener(),
    PowerLogarithm.id: lambda omega: PowerLogarithm(),
    GeneralizedMaxwell.id: GeneralizedMaxwell.over,
}
"""Every model by its id, made for data at angular frequencies ω (f,)."""


@dataclass(frozen=True)
class Candidate:
    """A fitted model, its AICc, and the rms logarithmic error at frequencies held out of its fit
    (infinite where the model loses its sign there, NaN with too few frequencies)."""

    fit: ModulusFit
    aicc: float
    held_out: float


def candidates(data: ModulusData, models: Sequence[str] = tuple(MODELS)) -> list[Candidate]:
    """These models fitted to the data, the least AICc first; those that cannot follow the data
    with both moduli positive are left out."""
    found = []
    for name in models:
        model = MODELS[name](data.omega)
        try:
            fit = fit_modulus(model, data)
        except MaterialError:
            continue
        found.append(Candidate(fit, aicc(fit), _held_out(fit)))
    if not found:
        raise MaterialError(f"{data.name}: no model can follow these data")
    return sorted(found, key=lambda candidate: candidate.aicc)


def aicc(fit: ModulusFit) -> float:
    """Akaike's criterion for small samples with the variance estimated: K. P. Burnham, D. R.
    Anderson, Model Selection and Multimodel Inference, 2nd ed. (Springer 2002), (2.13), (7.10)."""
    n, k = 2 * len(fit.data.omega), fit.count + 1
    if n <= k + 1:
        return inf
    return n * log(max(fit.error, 1e-300) / n) + 2 * k + 2 * k * (k + 1) / (n - k - 1)


def _held_out(full: ModulusFit) -> float:
    """Rms logarithmic error where the fit has not seen the data, over all blocks in turn."""
    data, total = full.data, 0.0
    for block in np.array_split(np.arange(len(data.omega)), BLOCKS):
        kept = np.setdiff1d(np.arange(len(data.omega)), block)
        if len(kept) < FEWEST or not len(block):
            return float("nan")
        try:
            fit = fit_modulus(full.model, data.part(kept), [full.shape])
        except MaterialError:
            return inf
        away = data.part(block)
        total += log_error(fit.modulus(away.omega), away.modulus)
    return float(np.sqrt(total / (2 * len(data.omega))))
