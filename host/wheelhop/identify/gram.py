"""Least squares of all runs in small matrices, each run's initial state projected out.

A run of finite length is X = H Y + T with T the free decay of what was in motion when it began,
less what is still in motion when it ends. T has the poles of H and, in band, a smooth rest: it is a
combination of the same fractions and a few powers of s, other for each run and output (R. Pintelon
and J. Schoukens, System Identification, 2nd ed., section 6.3.2). Its basis is the same for all runs
of one length, so it is projected out of data and model at once, and never solved for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.identify.sections import Sections
from wheelhop.identify.spectra import Spectra

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

EDGE_POWERS = 3
"""Powers of s, from s⁰ up, that stand for the parts of T beyond the band."""
CHUNK = 4_000_000
"""Numbers of one matrix held in memory at once."""


def transient_basis(omega: Array, sections: Sections, weight: Array) -> Array:
    """Orthonormal basis (2k, order + EDGE_POWERS) of what an initial state leaves in a weighted
    spectrum, real parts above imaginary parts."""
    q: Array = np.linalg.qr(_transient_columns(omega, sections, weight))[0]
    return q


def _transient_columns(omega: Array, sections: Sections, weight: Array) -> Array:
    powers = (1j * omega[:, None] / omega[-1]) ** np.arange(EDGE_POWERS)
    columns = np.hstack([sections.basis(1j * omega), powers]) * weight[:, None]
    return np.vstack([columns.real, columns.imag])


def initial_states(omega: Array, sections: Sections, weight: Array, rest: ComplexArray) -> Array:
    """Coefficients (order, r·n) of the fractions that the initial states put into a weighted
    residual `rest` (r, k, n)."""
    columns = _transient_columns(omega, sections, weight)
    rows = np.concatenate([rest.real, rest.imag], axis=1)
    flat = rows.transpose(1, 0, 2).reshape(len(columns), -1)
    found: Array = linalg.lstsq(columns, flat, cond=1e-13, lapack_driver="gelsy")[0]
    return found[: sections.order]


def projected(values: ComplexArray, basis: Array) -> Array:
    """Spectra (r, k, c) as real rows (r 2k, c), the `basis` projected out of each run."""
    r, k, c = values.shape
    rows = np.empty((r, 2 * k, c))
    rows[:, :k], rows[:, k:] = values.real, values.imag
    if basis.shape[1]:
        rows -= basis @ (basis.T @ rows)
    return rows.reshape(r * 2 * k, c)


@dataclass(frozen=True, eq=False)
class Gram:
    """Sums over all rows: of regressors Φ with themselves and with each output, and of the outputs'
    squares. Φ has one column per input j and fraction m, at j · order + m."""

    phi_phi: Array  #: (m·order, m·order)
    phi_x: Array  #: (m·order, n)
    x_x: Array  #: (n,)


class Stack:
    """The runs, weighted, and the matrices that hang on the poles.

    Parameters
    ----------
    parts : the runs.
    weights : for each part, weights (k,) of its lines.
    at_rest : take the runs to begin and end at rest, without initial states.
    """

    def __init__(
        self,
        parts: Sequence[Spectra],
        weights: Sequence[Array],
        order: int,
        *,
        at_rest: bool = False,
    ) -> None:
        self.parts, self.weights, self.at_rest = [], [], at_rest
        for part, weight in zip(parts, weights, strict=True):
            size = 2 * len(part.omega) * part.inputs.shape[2] * order
            at_once = max(1, CHUNK // size)
            for first in range(0, len(part.runs), at_once):
                self.parts.append(part.part(first, first + at_once))
                self.weights.append(weight)
        self.inputs = parts[0].inputs.shape[2]
        self.outputs = parts[0].outputs.shape[2]
        self.rows = sum(2 * len(p.omega) * len(p.runs) for p in parts)
        self.transients = sum(len(p.runs) * (order + EDGE_POWERS) for p in parts)

    def regressors(
        self, sections: Sections, factors: Sequence[ComplexArray]
    ) -> list[tuple[Array, Array, Array]]:
        """For each part: basis of its transients, Φ and the outputs, as projected real rows.

        `factors` (k, m) multiply the inputs of each part.
        """
        out = []
        for part, weight, factor in zip(self.parts, self.weights, factors, strict=True):
            basis = (
                np.zeros((2 * len(part.omega), 0))
                if self.at_rest
                else transient_basis(part.omega, sections, weight)
            )
            fractions = sections.basis(1j * part.omega) * weight[:, None]
            phi = (part.inputs * factor)[:, :, :, None] * fractions[:, None, :]
            phi = phi.reshape(*phi.shape[:2], -1)
            out.append(
                (
                    basis,
                    projected(phi, basis),
                    projected(part.outputs * weight[:, None], basis),
                )
            )
        return out


def condensed(parts: Sequence[Spectra]) -> list[Spectra]:
    """Less data for a first fit without initial states.

    A Hann window over each run (a second difference along the lines) takes out most of what they
    leave. Then as few runs as have the same sums of squares and products at every line: of m inputs
    and n outputs no more than m + n, however many were recorded.
    """
    out = []
    for part in parts:
        both = np.concatenate([part.inputs, part.outputs], axis=2)
        both = both[:, 1:-1] - (both[:, :-2] + both[:, 2:]) / 2
        if len(both) > both.shape[2]:
            both = np.asarray(np.linalg.qr(both.swapaxes(0, 1), mode="r")).swapaxes(0, 1)
        m = part.inputs.shape[2]
        inputs, outputs = (np.ascontiguousarray(v) for v in (both[:, :, :m], both[:, :, m:]))
        names = part.runs[: len(both)]
        out.append(Spectra(names, part.omega[1:-1], inputs, outputs, part.samples))
    return out


def gram(regressors: Sequence[tuple[Array, Array, Array]]) -> Gram:
    """The sums that linear least squares needs."""
    _, phi, x = regressors[0]
    total = Gram(phi.T @ phi, phi.T @ x, np.sum(x**2, axis=0))
    for _, phi, x in regressors[1:]:
        total = Gram(
            total.phi_phi + phi.T @ phi, total.phi_x + phi.T @ x, total.x_x + np.sum(x**2, axis=0)
        )
    return total
