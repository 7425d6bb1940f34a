"""Frequency responses without a model: H1, H2, Hv, several inputs, coherence and confidence.

At each line the runs are samples of inputs and outputs; neighbouring lines are taken with them (a
half-cosine weight), since one run is one sample a line. With few runs and many inputs the estimate
needs that smoothing, and blurs what is narrower (J. Bendat and A. Piersol, Random Data, 4th ed.,
chapters 7 and 9).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.identify.spectra import Spectra

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

Kind = Literal["H1", "H2", "Hv"]


@dataclass(frozen=True, eq=False)
class Frf:
    """Estimated at k lines: `matrix` (k, n, m), its standard error (of real and of imaginary part),
    the multiple `coherence` (k, n) of each output with all inputs, and `averages`, how many
    independent samples a line has."""

    omega: Array
    matrix: ComplexArray
    standard_error: Array
    coherence: Array
    averages: float


def frf(runs: Sequence[Spectra], kind: Kind = "H1", *, lines: int = 9) -> Frf:
    """Estimate from runs of one length.

    "H1" takes all noise to be on the outputs, "H2" on the inputs (as many outputs as inputs), "Hv"
    on both alike (total least squares, each output with all inputs).

    Parameters
    ----------
    lines : width of the average over neighbouring lines, odd.

    Raises
    ------
    CampaignError : runs of different length, fewer samples at a line than inputs, an even width, or
        H2 of a matrix that is not square.
    """
    from scipy.signal.windows import cosine  # takes long to import

    if len({part.samples for part in runs}) != 1:
        raise CampaignError("runs of different length have no lines in common: cut them alike")
    if lines % 2 == 0 or lines < 1:
        raise CampaignError(f"an average over {lines} lines has no middle: give an odd number")
    y = np.concatenate([part.inputs for part in runs])
    x = np.concatenate([part.outputs for part in runs])
    m, n = y.shape[2], x.shape[2]
    weight = cosine(lines + 2)[1:-1] if lines > 1 else np.ones(1)
    weight = weight / weight.sum()
    averages = len(y) / float(np.sum(weight**2))
    if averages <= m:
        raise CampaignError(
            f"{len(y)} runs and {lines} lines are {averages:.0f} samples for {m} inputs: average"
            " over more lines, or record more runs"
        )
    if kind == "H2" and m != n:
        raise CampaignError(f"H2 needs as many outputs as inputs: there are {n} and {m}")
    both = np.concatenate([y, x], axis=2)
    cross = np.einsum("rki,rkj->kij", both, both.conj())
    smooth = np.apply_along_axis(_smoothed, 0, cross.reshape(len(cross), -1), weight)
    smooth = smooth.reshape(cross.shape)
    yy, xy, xx = smooth[:, :m, :m], smooth[:, m:, :m], smooth[:, m:, m:]
    h1 = xy @ np.linalg.pinv(yy, hermitian=True)
    matrix = h1
    if kind == "H2":
        matrix = xx @ np.linalg.pinv(xy.conj().transpose(0, 2, 1))
    elif kind == "Hv":
        matrix = _total(smooth, m, n)
    power = np.einsum("kii->ki", xx).real
    explained = np.einsum("kij,kij->ki", h1, xy.conj()).real
    coherence = np.clip(explained / np.maximum(power, 1e-300), 0.0, 1.0)
    rest = np.maximum(power - explained, 0.0) * averages / (averages - m)
    inverse = np.einsum("kjj->kj", np.linalg.pinv(yy, hermitian=True)).real
    error = np.sqrt(rest[:, :, None] * inverse[:, None, :] / (2 * averages))
    return Frf(runs[0].omega, matrix, error, coherence, averages)


def frf_h1(runs: Sequence[Spectra], *, lines: int = 9) -> Frf:
    """`frf` of kind "H1"."""
    return frf(runs, "H1", lines=lines)


def _smoothed(values: ComplexArray, weight: Array) -> ComplexArray:
    """Weighted mean over neighbours; at the ends over those that are there."""
    total = np.convolve(values, weight, mode="same")
    return np.asarray(total / np.convolve(np.ones(len(values)), weight, mode="same"))


def _total(smooth: ComplexArray, m: int, n: int) -> ComplexArray:
    """Each output's smallest eigenvector of the cross powers with all inputs: (h, -1) ⟂ data."""
    out = np.empty((len(smooth), n, m), complex)
    for i in range(n):
        use = [*range(m), m + i]
        _, vectors = np.linalg.eigh(smooth[:, use][:, :, use])
        least = vectors[:, :, 0].conj()
        out[:, i] = -least[:, :m] / least[:, m:]
    return out
