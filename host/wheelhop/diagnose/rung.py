"""A fitted model and the runs that judge it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wheelhop.fit import Fit
from wheelhop.simulate import Model


@dataclass(frozen=True, eq=False)
class Rung:
    """A model fitted to the "fit" runs, and what it does on the "validate" runs: when only what
    those leave free is fitted there (``validation``), and, where that leaves more than a model
    which explains the fitted runs should, when the numbers that runs share may move as far as they
    are uncertain (``update``). ``inexact`` is the power, in units of the noise's, by which the
    simulation of its effects may itself be wrong on the runs that judge."""

    fit: Fit
    validation: Fit | None
    update: Fit | None = None
    inexact: float = 0.0

    @property
    def judging(self) -> Fit:
        """The fit whose runs judge the model: those held out, or the fitted ones if there are no
        others."""
        return self.update or self.validation or self.fit

    @property
    def model(self) -> Model:
        """The model, what every run leaves free included."""
        fitted = self.fit.model
        if self.validation is None:
            return fitted
        other = self.validation.model
        runs, heights = {**fitted.runs, **other.runs}, {**fitted.heights, **other.heights}
        return Model(fitted.values, fitted.effects, runs, heights)

    @property
    def error_fit(self) -> float:
        """E over the runs fitted."""
        return self.fit.error

    @property
    def error_validate(self) -> float:
        """E over the other runs as foreseen, charged for the degrees of freedom each was given."""
        return float("nan") if self.validation is None else _error(self.validation)

    @property
    def error(self) -> float:
        """E over the other runs as foreseen, or over the fitted ones if there are no others."""
        return self.error_fit if self.validation is None else self.error_validate

    @property
    def error_judging(self) -> float:
        """The same once shared numbers may move as far as they are uncertain."""
        return self.error_fit if self.validation is None else _error(self.judging)

    @property
    def evidence(self) -> float:
        """Logarithm of the model's evidence by Laplace's method, up to a constant of the data: that
        of the runs fitted, and of the others given what was fitted."""
        held_out = 0.0 if self.validation is None else self.judging.evidence
        return self.fit.evidence + held_out


def _error(held_out: Fit) -> float:
    left = sum(run.left / run.spare for run in held_out.runs)
    return float(np.sqrt(left / sum(run.bench.energy for run in held_out.runs)))
