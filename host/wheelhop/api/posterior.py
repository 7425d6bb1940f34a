"""What a fit leaves open of the numbers that runs share: covariance, correlation, draws."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wheelhop.diagnose import Step
from wheelhop.fit.covariance import covariance_of

if TYPE_CHECKING:
    from pandas import DataFrame


def covariance_frame(step: Step) -> DataFrame:
    """Covariance (g, g) of the shared numbers, in their units; its diagonal is the square of the
    uncertainties of the step, which may be wider than those of its fit (other laws would do)."""
    import pandas

    fitted = step.rung.fit
    names = [free.name for free in fitted.shared]
    own = np.array([fitted.deviations[name] for name in names])
    wider = np.array([step.parameters[name][1] for name in names]) / own
    matrix = covariance_of(fitted) * np.outer(wider, wider)
    return pandas.DataFrame(matrix, index=names, columns=names)


def correlation_frame(step: Step) -> DataFrame:
    """The correlation matrix: the covariance scaled to a unit diagonal."""
    covariance = covariance_frame(step)
    deviation = np.sqrt(np.diag(covariance))
    return covariance / np.outer(deviation, deviation)


def draws_frame(step: Step, count: int, seed: int) -> DataFrame:
    """Normal draws (count, g) within the bounds of the fit."""
    import pandas

    if count < 1:
        raise ValueError(f"count = {count}: draw one set of numbers or more")
    covariance = covariance_frame(step)
    deviation = np.sqrt(np.diag(covariance))
    size, direction = np.linalg.eigh(covariance / np.outer(deviation, deviation))
    half = direction * np.sqrt(np.maximum(size, 0.0))
    normal = np.random.default_rng(seed).standard_normal((count, len(size)))
    shared = step.rung.fit.shared
    mean = np.array([step.parameters[free.name][0] for free in shared])
    drawn = mean + deviation * (normal @ half.T)
    kept = np.clip(drawn, [f.lower for f in shared], [f.upper for f in shared])
    return pandas.DataFrame(kept, columns=covariance.columns)
