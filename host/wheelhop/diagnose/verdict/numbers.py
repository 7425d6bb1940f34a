"""The numbers of a fit as the critic looks at them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.diagnosis import Step
from wheelhop.fit import Free

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Number:
    """A number that runs share, as fitted: what was believed of it, its value and standard
    deviation, and how much further it would go without bounds."""

    free: Free
    value: float
    sd: float
    ahead: float

    @property
    def name(self) -> str:
        """As the model calls it."""
        return self.free.name

    @property
    def sigma(self) -> float:
        """What it was believed to, where it lies; infinite where nothing was."""
        return self.free.sigma_at(self.value)


def numbers_of(step: Step) -> tuple[list[Number], Array]:
    """All that the critic wants to know of a fit: its shared numbers and their covariance."""
    fitted = step.rung.fit
    values, covariance = fitted.model.values, np.asarray(fitted.covariance)
    scale = fitted.belief.scale(values)
    return [
        Number(f.at(scale), values[f.name], sd, fitted.ahead[f.name])
        for f, sd in zip(fitted.shared, np.sqrt(np.diag(covariance)).tolist(), strict=True)
    ], covariance


def measured_of(step: Step) -> list[Number]:
    """What was measured of several numbers at once, as fitted."""
    fitted = step.rung.fit
    return [
        Number(Free.of(m), value, sd, 0.0)
        for m in fitted.measured
        for value, sd in [fitted.relations[m.name]]
    ]
