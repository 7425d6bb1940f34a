"""Covariance of what a fit says of the numbers that runs share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wheelhop.fit.result import Fit

Array = NDArray[np.float64]


def covariance_of(fit: Fit) -> Array:
    """Covariance (g, g) of the shared numbers, in their units and in the order of `fit.shared`.

    It has the correlation of a matrix that in every direction is at least that of white noise,
    `Fit.covariance`, and wider where the pulls of the half-seconds scatter more than noise makes
    them, and along the common scale of masses and forces, of which records say nothing, as wide as
    is believed. Its diagonal is the square of `Fit.deviations`.
    """
    white, scale = fit.covariance, np.array([free.scale for free in fit.shared])
    unit = np.sqrt(np.diag(white))
    factor = np.linalg.cholesky(white / np.outer(unit, unit))
    scatter = fit.scatter / np.outer(unit, unit)
    # Per white noise: what scatters less than that in some direction counts as that.
    half = np.linalg.solve(factor, np.linalg.solve(factor, scatter).T)
    size, direction = np.linalg.eigh(0.5 * (half + half.T))
    wider = factor @ direction
    matrix = factor @ factor.T + (wider * np.maximum(size, 0.0)) @ wider.T
    along = fit.of_scale * scale / unit
    told = float(along @ np.linalg.solve(matrix, along))
    if told > 1.0:  # the least that is added so that the matrix is nowhere less than that direction
        matrix = matrix + (1.0 - 1.0 / told) * np.outer(along, along)
    deviations = np.array([fit.deviations[free.name] for free in fit.shared])
    spread = deviations / np.sqrt(np.diag(matrix))
    return np.asarray(matrix * np.outer(spread, spread))
