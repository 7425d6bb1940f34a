"""A smooth history that is free in every run: a cubic spline in time."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy import interpolate

from wheelhop.effects.base import Array, RunSetting, Values
from wheelhop.effects.parameters import Amplitude, Parameter, Shape

LEAD_S = 0.8
"""Histories begin this long before the record: the vehicle remembers no longer."""

KNOTS_S = {"slow": 0.4, "fast": 0.15}
"""Spacing of the knots of a driver who lets the speed wander, and of one who brakes and swerves: a
wander of 2.5 s period is followed to 0.3 %, or one of 0.9 s."""


class History:
    """Cubic B-splines over one run, constant before and after.

    Parameters
    ----------
    run
        The run.
    spacing_s
        Distance of the knots. A sine of period T is followed to about (2π spacing / T)⁴ / 384 of
        its amplitude (C. de Boor, A Practical Guide to Splines, Springer 1978, ch. XII).
    unit
        Of the coefficients, as it stands in names.
    """

    def __init__(self, run: RunSetting, spacing_s: float, unit: str = "m") -> None:
        self.begin_s, self.end_s = run.record_start_s - LEAD_S, run.end_s
        count = max(int(np.ceil((self.end_s - self.begin_s) / spacing_s)), 1)
        inner = np.linspace(self.begin_s, self.end_s, count + 1)
        self._knots = np.concatenate([[self.begin_s] * 3, inner, [self.end_s] * 3])
        self.names = tuple(f"coefficient_{j}_{unit}" for j in range(count + 3))

    def parameters(
        self, unit: str, meaning: str, scale: float, *, is_shape: bool = False
    ) -> tuple[Parameter, ...]:
        """The coefficients as numbers that a run leaves free, amplitudes or shapes."""
        kind = partial(Shape, starts=(0.0,)) if is_shape else Amplitude
        spans = zip(self._knots[:-4].tolist(), self._knots[4:].tolist(), strict=True)
        return tuple(
            kind(name, unit, meaning, scale, span_s=span)
            for name, span in zip(self.names, spans, strict=True)
        )

    def at(self, theta: Values, time_s: Array) -> tuple[Array, Array] | None:
        """Value and rate at the given times; None where no coefficient is stated or all vanish."""
        coefficients = np.array([theta.get(name, 0.0) for name in self.names])
        if not coefficients.any():
            return None
        # Piece by piece it is evaluated four times as fast as from its basis.
        spline = interpolate.PPoly.from_spline((self._knots, coefficients, 3))
        inside = np.clip(time_s, self.begin_s, self.end_s)
        return spline(inside), np.where(inside == time_s, spline(inside, 1), 0.0)

    def through(self, time_s: Array, values: Array) -> dict[str, float]:
        """Coefficients of a smooth spline near the given points, constant beyond them."""
        count = len(self.names)
        basis = interpolate.BSpline(self._knots, np.eye(count), 3)
        bend = np.diff(np.eye(count), 2, axis=0)
        matrix = np.vstack([basis(time_s), 0.3 * bend])
        target = np.concatenate([values, np.zeros(len(bend))])
        fitted = np.linalg.lstsq(matrix, target, rcond=None)[0]
        return dict(zip(self.names, fitted.tolist(), strict=True))

    def likely(
        self, time_s: Array, values: Array, uncertainty: Array, scale: float
    ) -> dict[str, float]:
        """Likeliest coefficients, each believed to be 0 ± `scale`, given points along the history
        with their standard deviations."""
        count = len(self.names)
        basis = interpolate.BSpline(self._knots, np.eye(count), 3)(time_s)
        matrix = np.vstack([basis / uncertainty[:, None], np.eye(count) / scale])
        target = np.concatenate([values / uncertainty, np.zeros(count)])
        found = np.linalg.lstsq(matrix, target, rcond=None)[0]
        return dict(zip(self.names, found.tolist(), strict=True))
