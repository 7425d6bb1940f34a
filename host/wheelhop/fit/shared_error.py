"""Errors that channels have in common, because what moves the model is uncertain itself.

The noise of a potentiometer moves the whole body of a model that measured travel drives: all
channels err together, and by more than their own noise. At each frequency the errors of the
channels have the covariance

    S = 1 + H V Hᴴ

per σ², H (c, a) being what channels show per motion that drives the model, V (a, a) the variance of
that motion's error. Data are multiplied by L⁻¹, S = L Lᴴ: what is left of their errors is white
again, as least squares ask for (A. Aitken, Proc. R. Soc. Edinburgh 55 (1936) 42). Were each channel
only divided by its own deviation, whatever moves the body freely would explain what channels err
in common.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class SharedError:
    """The factor L (f, p, p) at the frequencies of a band, of the channels that are predicted."""

    lower: ComplexArray

    @classmethod
    def of(cls, response: ComplexArray, variance: Array) -> SharedError:
        """From H (f, p, a), per noise, and the variances (f, a) of what drives the model."""
        moved = response * np.sqrt(variance)[:, None, :]
        covariance = np.eye(response.shape[1]) + moved @ moved.conj().swapaxes(1, 2)
        return cls(np.asarray(np.linalg.cholesky(covariance)))

    def among(self, channels: Sequence[int]) -> SharedError:
        """The shared error where only these channels are recorded."""
        covariance = self.lower @ self.lower.conj().swapaxes(1, 2)
        kept = covariance[:, channels][:, :, channels]
        return SharedError(np.asarray(np.linalg.cholesky(kept)))

    @cached_property
    def _inverse(self) -> ComplexArray:
        return np.asarray(np.linalg.inv(self.lower))

    def white(self, data: Array) -> Array:
        """In-band data (2 f, p), or columns of such (2 f, p, k), with white errors."""
        return _applied(self._inverse, data)

    def recorded(self, data: Array) -> Array:
        """White data (2 f, p), or columns of such, as they were recorded."""
        return _applied(self.lower, data)

    @property
    def foreseen(self) -> float:
        """How many of the white data's variances are the driving motion's error: tr(1 − S⁻¹), of
        real and imaginary parts."""
        return float(2.0 * (self.lower.shape[0] * self.lower.shape[1] - self._size))

    @property
    def _size(self) -> float:
        return float(np.sum(np.abs(self._inverse) ** 2))


def _applied(matrices: ComplexArray, data: Array) -> Array:
    half = len(matrices)
    columns = data.reshape(*data.shape[:2], -1)
    found = matrices @ (columns[:half] + 1j * columns[half:])
    return np.concatenate([found.real, found.imag]).reshape(data.shape)
