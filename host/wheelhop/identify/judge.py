"""How well a transfer matrix explains runs, seen by its fit or not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.identify.gram import projected, transient_basis
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.spectra import Spectra, through

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Judged:
    """What a transfer matrix leaves of some runs, their initial states projected out.

    Per run and output, as sums of squares in band: `residual`, `measured`, and what the noise
    of inputs and outputs alone is expected to leave, `expected` (r, n). `freedom` is the share of a
    run's coordinates that its initial state leaves.
    """

    runs: tuple[str, ...]
    residual: Array
    measured: Array
    expected: Array

    @property
    def error(self) -> float:
        """√(Σ residual² / Σ measured²)."""
        return float(np.sqrt(self.residual.sum() / self.measured.sum()))

    @property
    def floor(self) -> float:
        """The error that noise alone would leave; NaN where none is stated."""
        return float(np.sqrt(self.expected.sum() / self.measured.sum()))


def judge(h: TransferMatrix, runs: Sequence[Spectra], noise_rms: float | None = None) -> Judged:
    """Error of H on runs, with the degrees of freedom charged that each initial state takes."""
    names: list[str] = []
    parts: list[tuple[Array, Array, Array]] = []
    noise = np.nan if noise_rms is None else noise_rms
    for part in runs:
        k = len(part.omega)
        basis = transient_basis(part.omega, h.sections, np.ones(k))
        response = h(1j * part.omega)
        rest = part.outputs - through(response, part.inputs)
        rows = projected(rest, basis).reshape(len(part.runs), 2 * k, -1)
        charged = 2 * k / (2 * k - basis.shape[1])
        growth = 1.0 + np.mean(np.sum(np.abs(response) ** 2, axis=2), axis=0)
        residual = charged * np.sum(rows**2, axis=1)
        parts.append(
            (
                residual,
                np.sum(np.abs(part.outputs) ** 2, axis=1),
                np.broadcast_to(part.samples * noise**2 * growth, residual.shape),
            )
        )
        names += part.runs
    return Judged(tuple(names), *(np.concatenate(column) for column in zip(*parts, strict=True)))
