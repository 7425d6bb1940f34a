"""Fit of a modulus model by the logarithmic error (3.41), with intervals.

J = Σ (log M_d/M̂_d)² + (log M_l/M̂_l)² weighs both parts by what they are a fraction of, though the
loss is much the smaller. Every start that the model offers is solved for its weights by least
squares: the error is nonlinear in them only through the logarithm, and a few steps of Gauss and
Newton's arrive. What is left is a search over one or two shapes, from the best of the starts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from wheelhop.material.data import ModulusData
from wheelhop.material.error import MaterialError
from wheelhop.material.model import Array, ComplexArray, ModulusModel

REFINED = 2
"""Starts that are refined."""
MOST_STEPS = 30
CONVERGED = 1e-9
"""Relative fall of J at which the weights have arrived."""
SHORTEST = 1e-4
"""Least share of a step that is tried."""
LEVEL = 0.95


@dataclass(frozen=True, eq=False)
class ModulusFit:
    """A model fitted to data: its parameters (n,), the shape among them, and the error J of
    (3.41)."""

    model: ModulusModel
    data: ModulusData
    parameters: Array
    shape: Array
    error: float

    @property
    def free(self) -> NDArray[np.bool_]:
        """Which parameters (n,) rest on no bound."""
        at = (self.parameters <= self.model.lower) | (self.parameters >= self.model.upper)
        return ~at

    @property
    def count(self) -> int:
        """Number of parameters that rest on no bound."""
        return int(self.free.sum())

    @property
    def rms(self) -> float:
        """Root mean square of the logarithmic error: 0.01 is one per cent."""
        return float(np.sqrt(self.error / (2 * len(self.data.omega))))

    def modulus(self, omega: Array) -> ComplexArray:
        """The fitted modulus (f,), N/m."""
        return self.model.modulus(omega, self.parameters)

    @cached_property
    def covariance(self) -> Array:
        """Covariance (n, n) of the parameters, from the slope of the residuals and what is left of
        them; zero for those on a bound, infinite where there are not more numbers than
        parameters."""
        free = self.free
        slope = _slope(self.model, self.data.omega, self.parameters)[:, free]
        spare = len(slope) - free.sum()
        size = np.sqrt((slope**2).sum(axis=0))
        inverse = np.linalg.pinv(slope / size, rcond=1e-13)
        scale = self.error / spare if spare > 0 else np.inf
        covariance = np.zeros((len(free), len(free)))
        covariance[np.ix_(free, free)] = scale * (inverse @ inverse.T) / np.outer(size, size)
        return covariance

    def half_widths(self, level: float = LEVEL) -> Array:
        """Half of each parameter's interval (n,) at this level, as if the model were linear near
        its optimum and the residuals independent."""
        spare = max(2 * len(self.data.omega) - self.count, 1)
        quantile = special.stdtrit(spare, 0.5 + level / 2)
        return np.asarray(quantile * np.sqrt(np.diag(self.covariance)))

    def band(self, omega: Array, level: float = LEVEL) -> tuple[Array, Array]:
        """Half-widths (f,) of the intervals of M_d and M_l, N/m."""
        spare = max(2 * len(self.data.omega) - self.count, 1)
        quantile = special.stdtrit(spare, 0.5 + level / 2)
        slope = self.model.derivatives(omega, self.parameters)
        parts = []
        for part in (slope.real, slope.imag):
            parts.append(
                quantile * np.sqrt(np.einsum("fi,ij,fj->f", part, self.covariance, part).clip(0.0))
            )
        return parts[0], parts[1]


def log_error(model: ComplexArray, data: ComplexArray) -> float:
    """J of (3.41); infinite where a modelled part is not positive."""
    modelled = _stacked(model)
    if not (modelled > 0.0).all():
        return np.inf
    residual = np.log(modelled / _stacked(data))
    return float(residual @ residual)


def fit_modulus(
    model: ModulusModel, data: ModulusData, shapes: Sequence[Array] | None = None
) -> ModulusFit:
    """The parameters of least J, from the best of the model's own shapes, or from those given.

    Raises `MaterialError` if the model cannot take a positive dynamic and loss modulus at all
    frequencies of the data.
    """
    problem = _Problem(model, data)
    trials = list(model.shapes(data.omega) if shapes is None else shapes)
    errors = np.array([problem.solve(shape, steps=1)[0] for shape in trials])
    best = np.argsort(errors)[:REFINED]
    error, weights, shape = min(
        (problem.refine(trials[i]) for i in best), key=lambda found: found[0]
    )
    if not np.isfinite(error):
        raise MaterialError(
            f"{data.name}: the {model.title} model cannot follow these data with both moduli"
            " positive"
        )
    parameters = np.clip(model.assembled(weights, shape), model.lower, model.upper)
    return ModulusFit(model, data, parameters, shape, error)


class _Problem:
    """J as a function of the shape alone, weights being the best for it."""

    def __init__(self, model: ModulusModel, data: ModulusData) -> None:
        self.model, self.omega = model, data.omega
        self.measured = _stacked(data.modulus)

    def solve(self, shape: Array, steps: int = MOST_STEPS) -> tuple[float, Array]:
        """J and the weights after so many steps from those of least relative error."""
        basis = _stacked(self.model.basis(self.omega, shape))
        weights = self._least(basis / self.measured[:, None], np.ones(len(basis)))
        error = self._error(basis @ weights)
        for _ in range(steps):
            if not np.isfinite(error):
                break
            modelled = basis @ weights
            residual = np.log(modelled / self.measured)
            target = self._least(basis / modelled[:, None], 1 - residual)
            before, share = error, 1.0
            while share > SHORTEST:
                trial = weights + share * (target - weights)
                error = self._error(basis @ trial)
                if error < before:
                    weights = trial
                    break
                share /= 4
            else:
                error = before
            if before - error <= CONVERGED * before:
                break
        return error, weights

    def refine(self, shape: Array) -> tuple[float, Array, Array]:
        """J, weights and shape at the nearest minimum: J. A. Nelder, R. Mead, Computer Journal 7
        (1965) 308–313, over the logarithms of the shape."""
        if len(shape):
            corners = np.log(shape) + np.vstack([np.zeros(len(shape)), 0.2 * np.eye(len(shape))])
            found = optimize.minimize(
                lambda x: self._error_of(np.exp(x)),
                corners[0],
                method="Nelder-Mead",
                options={"initial_simplex": corners, "xatol": 1e-5, "fatol": 1e-10},
            )
            shape = np.exp(found.x)
        return *self.solve(shape), shape

    def _error_of(self, shape: Array) -> float:
        return self.solve(shape)[0] if self.model.admits(shape) else np.inf

    def _least(self, columns: Array, target: Array) -> Array:
        if self.model.non_negative:
            return np.asarray(optimize.nnls(columns, target)[0])
        size = np.sqrt((columns**2).sum(axis=0))
        return np.asarray(np.linalg.lstsq(columns / size, target, rcond=1e-14)[0] / size)

    def _error(self, modelled: Array) -> float:
        if not (modelled > 0.0).all():
            return np.inf
        residual = np.log(modelled / self.measured)
        return float(residual @ residual)


def _stacked(values: ComplexArray) -> Array:
    """Real parts above imaginary parts."""
    return np.concatenate([values.real, values.imag])


def _slope(model: ModulusModel, omega: Array, parameters: Array) -> Array:
    """Derivatives (2f, n) of the logarithms of both parts."""
    value = _stacked(model.modulus(omega, parameters))
    return np.asarray(_stacked(model.derivatives(omega, parameters)) / value[:, None])
