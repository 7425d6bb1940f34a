"""A fitted transfer matrix, with its uncertainty."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.identify.sections import Points, Sections
from wheelhop.identify.structure import Structure, Suspensions

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class TransferMatrix:
    """H(s) over a common denominator, with its uncertainty.

    H[i, j] = D_j(s) Σ theta[i, j] · fractions(s), with D = 1 unless the structure is "reciprocal";
    then theta are the elements of S times the front stiffness.
    """

    sections: Sections
    theta: Array  #: (n, m, order)
    structure: Structure
    inputs: tuple[int, ...]  #: corners of the columns
    outputs: tuple[int, ...]  #: corners of the rows
    suspensions: Suspensions | None  #: as fitted; None unless "reciprocal"
    noise_rms: Array  #: (n,) assumed of each output, in band, m/s²
    index: NDArray[np.int64]  #: (n, m·order) which free number each theta is
    covariance: Array  #: of the free numbers, then ln ω, ζ, ln r, then the suspensions' three
    unknowns: int  #: numbers fitted
    cost: float  #: weighted sum of squares; about `freedom` where the model is right
    freedom: float  #: rows less everything fitted

    @property
    def order(self) -> int:
        """Number of poles."""
        return self.sections.order

    def __call__(self, s: Points) -> ComplexArray:
        """H(s) (len(s), n, m)."""
        s = np.atleast_1d(np.asarray(s, complex))
        values = np.tensordot(self.sections.basis(s), self.theta, axes=(1, 2))
        out: ComplexArray = values * self._factor(s)[:, None, :]
        return out

    def standard_error(self, s: Points) -> Array:
        """Standard error (len(s), n, m) of |H(s)| as √(variance of real and imaginary part / 2)."""
        s = np.atleast_1d(np.asarray(s, complex))
        out = np.zeros((len(s), len(self.outputs), len(self.inputs)))
        for i in range(len(self.outputs)):
            for j, by in enumerate(self._slopes(s, i)):
                out[:, i, j] = self._deviation(by)
        return out

    def doubt(self, s: Points, inputs: ComplexArray) -> Array:
        """Standard deviation (r, len(s), n) of real or imaginary part of what H, uncertain as it
        is, makes of inputs (r, len(s), m)."""
        s = np.atleast_1d(np.asarray(s, complex))
        out = np.zeros((*inputs.shape[:2], len(self.outputs)))
        for i in range(len(self.outputs)):
            slopes = list(self._slopes(s, i))
            for run, given in enumerate(inputs):
                by = sum(given[:, j, None] * slope for j, slope in enumerate(slopes))
                out[run, :, i] = self._deviation(np.asarray(by))
        return out

    def _slopes(self, s: Points, i: int) -> Iterator[ComplexArray]:
        """Derivatives (len(s), numbers) of each element of row i with respect to all numbers that
        the covariance is of."""
        basis, factor = self.sections.basis(s), self._factor(s)
        slopes = self.sections.basis_slopes(s)
        count, order = len(self.covariance), self.order
        free = count - order - 3
        for j in range(len(self.inputs)):
            by = np.zeros((len(s), count), complex)
            by[:, self.index[i, j * order : (j + 1) * order]] = factor[:, j, None] * basis
            moved = np.einsum("pkl,l->kp", slopes, self.theta[i, j])
            by[:, free : free + order] = factor[:, j, None] * moved
            if self.suspensions is not None:
                bend = self.suspensions.slopes(self.suspensions.value, s, (self.inputs[j],))
                by[:, -3:] = (bend[:, :, 0] * (basis @ self.theta[i, j])).T
            yield by

    def _deviation(self, by: ComplexArray) -> Array:
        """√(variance of real and imaginary part / 2) (k,) of what has these derivatives."""
        variance = np.einsum("kp,pq,kq->k", by, self.covariance, by.conj()).real
        return np.asarray(np.sqrt(np.maximum(variance, 0.0) / 2))

    def poles_table(self) -> list[tuple[float, float, float, float]]:
        """Natural frequency (Hz), its standard error, damping ratio, its standard error; one row a
        section."""
        m, free = len(self.sections.omega), len(self.covariance) - self.order - 3
        sd = np.sqrt(np.maximum(np.diag(self.covariance)[free : free + 2 * m], 0.0))
        frequency = self.sections.frequency_hz
        return [
            (float(frequency[i]), float(frequency[i] * sd[i]), float(z), float(sd[m + i]))
            for i, z in enumerate(self.sections.zeta)
        ]

    def _factor(self, s: Points) -> ComplexArray:
        if self.suspensions is None:
            return np.ones((len(s), len(self.inputs)), complex)
        return self.suspensions.factor(self.suspensions.value, s, self.inputs)
