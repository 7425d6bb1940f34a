"""Unknown heights of the ground, eliminated from a least-squares problem run by run.

Of heights a with the prior variance s² (of real and imaginary part) in a record d = G a + noise
the ridge (Wiener) estimate is â = (GᴴG + σ²/s²)⁻¹ Gᴴ d. It leaves R = I − G (GᴴG + σ²/s²)⁻¹ Gᴴ
times any column of a linear problem, and with R as its metric the problem has no heights any more:
dᵀR d = ‖d − G â‖² + σ² ‖â/s‖². The estimate spends tr(I − R) degrees of freedom (T. Hastie,
R. Tibshirani, J. Friedman, The Elements of Statistical Learning, 2009, eq. 3.50).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.effects import RandomHeights
from wheelhop.fit.height_response import Ground
from wheelhop.fit.work import PER_HEIGHT

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Values = Mapping[str, float]

LEAST_VARIANCE_M2 = 1e-24
"""Heights of a picometre can be divided by."""


@dataclass(frozen=True, eq=False)
class Heights:
    """The heights of one run: where they are, what is believed of them, and the noise.

    ``coefficients`` (2k,), m, left and then right path; ``variance`` (2k,), m², of the real and of
    the imaginary part of each; ``sigma``, standard deviation of the noise of one in-band
    coefficient; ``slopes``, of `Ground.in_band` by the name of a shared number, per `Free.scale`.
    """

    ground: Ground
    coefficients: ComplexArray
    variance: Array
    sigma: float
    slopes: Mapping[str, ComplexArray] = field(default_factory=dict)

    def believed(self, effect: RandomHeights, theta: Values, sigma: float) -> Heights:
        """These heights with the prior that the effect's density states."""
        density = effect.height_density(theta, self.ground.wave_number_rad_m)
        variance = np.maximum(density * self.ground.step_rad_m, LEAST_VARIANCE_M2)
        return replace(self, variance=np.tile(variance, 2), sigma=sigma)

    def at(self, coefficients: ComplexArray) -> Heights:
        """This ground with other heights (2, k), of the left and the right path."""
        return replace(self, coefficients=coefficients.ravel())

    def settled(self) -> Heights:
        """These heights without the large matrices that led to them, 20 MB a run."""
        light = replace(self, ground=self.ground.anew())
        light.__dict__.update(freedom=self.freedom, log_volume=self.log_volume)
        return light

    @property
    def penalty(self) -> float:
        """Distance from what is believed, squared: Σ |a|²/s²."""
        whitened = np.abs(self.coefficients) / np.sqrt(self.variance)
        return float(whitened @ whitened)

    @cached_property
    def freedom(self) -> float:
        """Degrees of freedom that the estimate spends."""
        inverse, _ = linalg.lapack.ztrtri(self._lower, lower=1)
        return 2.0 * float(len(self.variance) - np.sum(np.abs(inverse) ** 2))

    @cached_property
    def log_volume(self) -> float:
        """Twice the logarithm of the share of the prior's volume that the record leaves."""
        return -4.0 * float(np.log(np.diag(self._lower).real).sum())

    def growths(self, names: Sequence[str]) -> Array:
        """How fast that grows (m,) along shared numbers; 0 where no slope is known. Along which of
        them it grows is told frequency by frequency, as in `freed`; how large it is, is known."""
        inner = self._inner
        apart = 2.0 * float(np.linalg.slogdet(inner)[1].sum())
        pull = self.ground.in_band @ (self._gain[:, None, None] * inner)
        found = [np.vdot(pull, self.slopes[n]).real if n in self.slopes else 0.0 for n in names]
        return -4.0 * (self.log_volume / apart if apart else 1.0) * np.array(found)

    def _count(self) -> None:
        self.ground.bench.work.add(PER_HEIGHT * len(self.coefficients) ** 3)

    def step(
        self, slope: ComplexArray, projected: ComplexArray
    ) -> tuple[ComplexArray, ComplexArray]:
        """Gauss–Newton's step (2k,) of the heights alone, Gᴴ times the residual being `slope`; and
        the heights (2k, m) that stand in for columns of which Gᴴ times each is `projected`."""
        deviation = np.sqrt(self.variance)
        pulls = np.column_stack([projected, slope]) * (deviation / self.sigma**2)[:, None]
        pulls[:, -1] -= self.coefficients / deviation
        solved = linalg.cho_solve((self._lower, True), pulls, check_finite=False)
        heights = deviation[:, None] * solved
        return heights[:, -1], heights[:, :-1]

    def freed(self, columns: Array) -> Array:
        """What heights leave of columns (size, m): R times the columns, frequency by frequency.
        Leaks between frequencies are neglected, which is good enough to screen."""
        left = self._remainder @ self.ground.complex_of(columns)
        left = left.reshape(len(columns) // 2, columns.shape[1])
        return np.concatenate([left.real, left.imag])

    def contribution(self) -> Array:
        """What the heights contribute to the record, (size,), to first order."""
        return self.ground.apply(self.coefficients[:, None])[:, 0]

    @cached_property
    def _remainder(self) -> ComplexArray:
        """R (f, c, c) at the band's frequencies."""
        response = self.ground.in_band
        adjoint = response.conj().transpose(0, 2, 1)
        gain = self._gain[:, None, None]
        return np.asarray(np.eye(response.shape[1]) - response @ (gain * self._inner) @ adjoint)

    @property
    def _gain(self) -> Array:
        """Variance (f,) of a coefficient of the heights, over that of the noise."""
        ground, count = self.ground, self.ground.series.count
        wave, variance = ground.wave_number_rad_m, self.variance[:count]
        density = np.interp(ground.in_band_rad_m, wave, variance) / ground.step_rad_m
        return np.asarray(ground.coefficient_variance * density / self.sigma**2)

    @property
    def _inner(self) -> ComplexArray:
        """(1 + gain RᴴR)⁻¹ (f, 2, 2), R the response to left and right path."""
        response = self.ground.in_band
        square = response.conj().transpose(0, 2, 1) @ response
        return np.asarray(np.linalg.inv(np.eye(2) + self._gain[:, None, None] * square))

    @cached_property
    def _lower(self) -> ComplexArray:
        """Cholesky's factor of I + s GᴴG s / σ²."""
        self._count()
        deviation = np.sqrt(self.variance) / self.sigma
        matrix = self.ground.square()
        matrix *= np.outer(deviation, deviation)
        matrix[np.diag_indices_from(matrix)] += 1.0
        return np.asarray(np.linalg.cholesky(matrix))  # leaves the other threads at work
