"""Least squares of all runs in small matrices, each run's initial state projected out.

A run of finite length is X = H Y + T with T the free decay of what was in motion when it began,
less what is still in motion when it ends. T has the poles of H and, in band, a smooth rest: it is a
combination of the same fractions and a few powers of s, other for each run and output (R. Pintelon
and J. Schoukens, System Identification, 2nd ed., section 6.3.2). Its basis Q is the same for all
runs of one length and is projected out of data and model at once, never solved for:
⟨u, v⟩ = Re Σ conj(u) v - (Qᵀu)(Qᵀv). The first term needs the runs only as sums at each line.

Where a run does not drive a line its inputs are noise, and H would be fitted to that noise, too. Of
known level, it is taken out of the inputs' sums of squares (bias-compensated least squares:
T. Söderström, Automatica 43 (2007) 939).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.identify.sections import Sections
from wheelhop.identify.spectra import Spectra

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

EDGE_POWERS = 3
"""Powers of s, from s⁰ up, that stand for the parts of T beyond the band."""
LOST = 1e-13
"""Singular values below this share of the largest are rounding."""
CHUNK = 4_000_000
"""Numbers of one matrix held in memory at once."""


def transient_basis(omega: Array, sections: Sections, weight: Array) -> Array:
    """Orthonormal basis (…, 2k, order + EDGE_POWERS) of what an initial state leaves in a spectrum
    of these weights (…, k), real parts above imaginary parts."""
    return _transients(omega, sections, weight)[0]


def unabsorbed(omega: Array, sections: Sections, weight: Array) -> Array:
    """Share (k,) of white noise at each line that the initial states do not absorb."""
    q, k = transient_basis(omega, sections, weight), len(omega)
    out: Array = 1.0 - np.sum(q[:k] ** 2 + q[k:] ** 2, axis=1) / 2
    return out


def _transients(omega: Array, sections: Sections, weight: Array) -> tuple[Array, Array]:
    """Q and R of the weighted fractions and powers of s."""
    powers = (1j * omega[:, None] / omega[-1]) ** np.arange(EDGE_POWERS)
    columns = np.hstack([sections.basis(1j * omega), powers]) * weight[..., None]
    q, r = np.linalg.qr(np.concatenate([columns.real, columns.imag], axis=-2))
    return q, r


def projected(values: ComplexArray, basis: Array) -> Array:
    """Spectra (r, k, c) as real rows (r 2k, c), the `basis` projected out of each run."""
    r, k, c = values.shape
    rows = np.empty((r, 2 * k, c))
    rows[:, :k], rows[:, k:] = values.real, values.imag
    rows -= basis @ (basis.T @ rows)
    return rows.reshape(r * 2 * k, c)


def inner(left: ComplexArray, right: ComplexArray) -> Array:
    """Re Σ conj(left) right over the lines, the last axis: (…, p, k) and (…, q, k) give
    (…, p, q)."""
    rows = np.ascontiguousarray(left).view(float)
    return np.asarray(rows @ np.ascontiguousarray(right).view(float).swapaxes(-1, -2))


def real_products(left: ComplexArray, right: ComplexArray) -> Array:
    """Re(leftᴴ right) of tall matrices (rows, p) and (rows, q)."""
    both = left.view(float).T @ right.view(float)
    out: Array = both[0::2, 0::2] + both[1::2, 1::2]
    return out


@dataclass(frozen=True, eq=False)
class Weighted:
    """Runs of one length in g groups of r, each line of a group times the group's weight."""

    omega: Array  #: (k,) rad/s
    weight: Array  #: (g, k)
    inputs: ComplexArray  #: (g, k, r, m)
    outputs: ComplexArray  #: (g, k, r, n)
    noise: Array  #: (k,) what noise is expected to add to each input's Σ over runs of |input|²

    @cached_property
    def y_y(self) -> ComplexArray:
        """Σ over runs of conj(input i) input j, less the noise, (m, m, k)."""
        out = _over_runs(self.inputs, self.inputs)
        each = np.arange(len(out))
        out[each, each] -= self.noise
        return out

    @cached_property
    def y_x(self) -> ComplexArray:
        """Σ over runs of conj(input j) output i, (m, n, k)."""
        return _over_runs(self.inputs, self.outputs)

    @cached_property
    def x_x(self) -> Array:
        """Σ over runs of |output|², (n, k)."""
        return np.asarray(np.sum(np.abs(self.outputs) ** 2, axis=(0, 2)).T)

    @cached_property
    def by_run(self) -> tuple[ComplexArray, ComplexArray]:
        """Inputs (g, r, m, k) and outputs (g, r, n, k), the lines last."""
        y, x = (np.ascontiguousarray(v.transpose(0, 2, 3, 1)) for v in (self.inputs, self.outputs))
        return y, x


def _over_runs(left: ComplexArray, right: ComplexArray) -> ComplexArray:
    both = (left.conj().swapaxes(2, 3) @ right).sum(axis=0)
    return np.ascontiguousarray(both.transpose(1, 2, 0))


@dataclass(frozen=True, eq=False)
class Regressors:
    """Φ of one part at one trial: input j through fraction p, at j · order + p.

    `fractions` (p, k), and `scaled` (m, p, k), the fractions times what multiplies each input.
    `transients` (g, q, k) is the basis Q of the initial states; `phi` (g, r q, m p) and `x`
    (g, r q, n) are the shares of Φ and of the outputs in it; Q times `powers` (g, q, q) are
    fractions and powers of s.
    """

    fractions: ComplexArray
    scaled: ComplexArray
    transients: ComplexArray
    phi: Array
    x: Array
    powers: Array

    def initial_states(self, theta: Array) -> Array:
        """Coefficients (g, order, r, n) of the fractions that the initial states put into what
        `theta` (n, m p) leaves of each run."""
        (groups, q, _), n = self.transients.shape, len(theta)
        left = (self.x - self.phi @ theta.T).reshape(groups, -1, q, n).swapaxes(1, 2)
        u, size, v = np.linalg.svd(self.powers)
        size[size <= LOST * size[:, :1]] = np.inf
        inside = u.swapaxes(1, 2) @ left.reshape(groups, q, -1) / size[:, :, None]
        found = v.swapaxes(1, 2)[:, : len(self.fractions)] @ inside
        return np.asarray(found.reshape(groups, -1, *left.shape[2:]))


@dataclass(frozen=True, eq=False)
class Gram:
    """Sums over all rows: of regressors Φ with themselves and with each output, and of the outputs'
    squares; and what `phi_phi` would be of the inputs' noise alone, which is taken out of it."""

    phi_phi: Array  #: (m·order, m·order)
    phi_x: Array  #: (m·order, n)
    x_x: Array  #: (n,)
    noise: Array  #: (m·order, m·order)


class Stack:
    """The runs, weighted, and the matrices that hang on the poles.

    Parameters
    ----------
    runs : of one weight and length each.
    weights : for each of them, weights (k,) of its lines.
    at_rest : take the runs to begin and end at rest, without initial states.
    noise : for each of them, the expected square (k,) of the noise in a weighted line of an input,
        as far as initial states do not absorb it; None: the inputs are taken as they are.
    """

    def __init__(
        self,
        runs: Sequence[Spectra],
        weights: Sequence[Array],
        order: int,
        *,
        at_rest: bool = False,
        noise: Sequence[Array] | None = None,
    ) -> None:
        self.order, self.at_rest, self.noisy = order, at_rest, noise is not None
        each = noise or [np.zeros(len(p.omega)) for p in runs]
        alike: dict[tuple[bytes, int], list[_Piece]] = {}
        for part, weight, square in zip(runs, weights, each, strict=True):
            at_once = max(1, CHUNK // (2 * len(part.omega) * part.inputs.shape[2] * order))
            for first in range(0, len(part.runs), at_once):
                pick = slice(first, first + at_once)
                piece = (part.omega, weight, part.inputs[pick], part.outputs[pick], square)
                alike.setdefault((part.omega.tobytes(), len(piece[2])), []).append(piece)
        self.parts = [part for pieces in alike.values() for part in _side_by_side(pieces, order)]
        self.inputs = runs[0].inputs.shape[2]
        self.outputs = runs[0].outputs.shape[2]
        self.rows = sum(2 * len(p.omega) * len(p.runs) for p in runs)
        self.transients = sum(len(p.runs) * (order + EDGE_POWERS) for p in runs)

    def regressors(self, sections: Sections, factors: Sequence[ComplexArray]) -> list[Regressors]:
        """Those of each part; `factors` (k, m) multiply its inputs."""
        return [self._of(p, sections, f) for p, f in zip(self.parts, factors, strict=True)]

    def _of(self, part: Weighted, sections: Sections, factor: ComplexArray) -> Regressors:
        fractions = np.ascontiguousarray(sections.basis(1j * part.omega).T)
        scaled = factor.T[:, None] * fractions
        groups, k, order = len(part.weight), len(part.omega), sections.order
        if self.at_rest:
            nothing = (
                np.zeros((groups, 0, width)) for width in (self.inputs * order, self.outputs, 0)
            )
            return Regressors(fractions, scaled, np.zeros((groups, 0, k), complex), *nothing)
        basis, powers = _transients(part.omega, sections, part.weight)
        transients = np.ascontiguousarray((basis[:, :k] + 1j * basis[:, k:]).swapaxes(1, 2))
        q = transients.shape[1]
        y, x = part.by_run
        y = (y * factor.T).reshape(groups, -1, k)
        through = np.stack(
            [inner(fractions.conj() * transients[:, i, None], y) for i in range(q)], axis=1
        )
        phi = through.reshape(groups, q, order, -1, self.inputs).transpose(0, 3, 1, 4, 2)
        of_x = inner(transients, x.reshape(groups, -1, k)).reshape(groups, q, -1, self.outputs)
        return Regressors(
            fractions,
            scaled,
            transients,
            phi.reshape(groups, -1, self.inputs * order),
            of_x.swapaxes(1, 2).reshape(groups, -1, self.outputs),
            powers,
        )

    def gram(self, regressors: Sequence[Regressors]) -> Gram:
        """The sums that linear least squares needs."""
        width = self.inputs * regressors[0].fractions.shape[0]
        square = (width, width)
        total = Gram(
            *(np.zeros(square), np.zeros((width, self.outputs)), np.zeros(self.outputs)),
            np.zeros(square),
        )
        for part, at in zip(self.parts, regressors, strict=True):
            k = len(part.omega)
            rows = [
                inner(at.scaled[j], (part.y_y[j][:, None] * at.scaled).reshape(-1, k))
                for j in range(self.inputs)
            ]
            with_x = [inner(at.scaled[j], part.y_x[j]) for j in range(self.inputs)]
            phi, x = at.phi.reshape(-1, width), at.x.reshape(-1, self.outputs)
            total = Gram(
                total.phi_phi + np.concatenate(rows) - phi.T @ phi,
                total.phi_x + np.concatenate(with_x) - phi.T @ x,
                total.x_x + part.x_x.sum(axis=1) - np.sum(x**2, axis=0),
                total.noise + self._heard(part, at) if self.noisy else total.noise,
            )
        return total

    @staticmethod
    def _heard(part: Weighted, at: Regressors) -> Array:
        return np.asarray(linalg.block_diag(*(inner(f, part.noise * f) for f in at.scaled)))


_Piece = tuple[Array, Array, ComplexArray, ComplexArray, Array]


def _side_by_side(pieces: Sequence[_Piece], order: int) -> Iterator[Weighted]:
    """Pieces (ω, weight, inputs, outputs, noise) of as many lines and runs, as many of them in one
    as memory allows: each for itself would cost as much."""
    (runs, k, m), omega = pieces[0][2].shape, pieces[0][0]
    at_once = max(1, CHUNK // (2 * k * m * order * runs))
    for first in range(0, len(pieces), at_once):
        _, weights, inputs, outputs, noise = zip(*pieces[first : first + at_once], strict=True)
        weight = np.stack(weights)
        y, x = (
            np.ascontiguousarray(np.stack(values).swapaxes(1, 2)) * weight[:, :, None, None]
            for values in (inputs, outputs)
        )
        yield Weighted(omega, weight, y, x, runs * np.sum(noise, axis=0))


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
