"""The currency of the breakdown: a part of the residual, and what noise would leave there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Slice:
    """One part of the residual: sums of squares in band, in the channels' unit squared,
    summed over samples.

    ``noise`` is what the sensors' noise is expected to contribute, ``share`` the part of the
    residual of all slices of the same cut that is in this one.
    """

    name: str
    residual: float
    measured: float
    noise: float
    share: float

    @property
    def error(self) -> float:
        """Residual relative to the measurement in the same slice."""
        return _root_ratio(self.residual, self.measured)

    @property
    def floor(self) -> float:
        """The error noise alone would leave in this slice."""
        return _root_ratio(self.noise, self.measured)

    @property
    def ratio(self) -> float:
        """Error over floor: about 1 where the model has not failed."""
        return _root_ratio(self.residual, self.noise)

    @property
    def excess(self) -> float:
        """Residual beyond the noise expected, at least 0."""
        return max(self.residual - self.noise, 0.0)


@dataclass(frozen=True, eq=False)
class Grid:
    """The residual cut along two axes at once: sums of squares (n_rows, n_columns)."""

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    residual: Array
    measured: Array
    noise: Array

    @property
    def by_row(self) -> tuple[Slice, ...]:
        """Slices of the rows, all columns together."""
        return slices(self.rows, *(a.sum(axis=1) for a in self._sums))

    @property
    def by_column(self) -> tuple[Slice, ...]:
        """Slices of the columns, all rows together."""
        return slices(self.columns, *(a.sum(axis=0) for a in self._sums))

    @property
    def ratio(self) -> Array:
        """Residual over noise in each cell, as amplitudes; NaN where nothing was compared."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return np.asarray(
                np.sqrt(np.where(self.noise > 0.0, self.residual / self.noise, np.nan))
            )

    @property
    def _sums(self) -> tuple[Array, Array, Array]:
        return self.residual, self.measured, self.noise


def slices(
    names: Sequence[str], residual: Array, measured: Array, noise: Array
) -> tuple[Slice, ...]:
    """Slices of one cut; their shares sum to 1."""
    total = float(residual.sum())
    return tuple(
        Slice(name, float(r), float(m), float(v), float(r) / total if total > 0.0 else 0.0)
        for name, r, m, v in zip(names, residual, measured, noise, strict=True)
    )


def _root_ratio(a: float, b: float) -> float:
    return float(np.sqrt(a / b)) if b > 0.0 else float("nan")
