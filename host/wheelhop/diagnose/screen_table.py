"""Normal equations of one run with an effect's signatures among its columns.

What the run leaves free is eliminated; products are kept channel by channel, as every channel has a
noise of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.fit import Fit, RunFit
from wheelhop.fit.spread import cost_of

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Columns:
    """Signatures of a variant's amplitudes (size, a), and of its effect's own parameters of the run
    (size, q) per prior standard deviation."""

    amplitudes: Array
    own: Array


@dataclass(frozen=True, eq=False)
class Table:
    """One run's normal equations with the run's own parameters eliminated: shared parameters
    first, then the variant's amplitudes."""

    matrix: Array  # (g + a, g + a)
    gradient: Array  # (g + a,)
    gain: float  # what the run's own parameters gain by themselves
    freedom: int  # how many of them the effect brought
    price: float  # of these: the logarithm of prior over posterior volume, twice
    signatures: NDArray[np.float32]  # (size, a), per spread
    back: Array  # (n, g + a + 1): own parameters per step of the others, and by themselves
    products: Array  # (c, n + g + a + 1, …): of all columns and the residual, channel by channel
    at_noise: Array  # the matrix as it would be if nothing but noise were left

    def left(self, x: Array) -> Array:
        """Σ residual² (c,) of every channel after a step of shared parameters and amplitudes."""
        own = self.back[:, -1] - self.back[:, :-1] @ x
        step = np.concatenate([-own, -x, [1.0]])
        return np.asarray(np.maximum(self.products @ step @ step, 0.0))


@dataclass(frozen=True, eq=False)
class Known:
    """A run's columns free of heights (c, n, k): own, shared and residual; and their products
    (c, k, k), channel by channel."""

    free: Array
    products: Array

    @classmethod
    def of(cls, run: RunFit) -> Known:
        """Of a run as it is fitted."""
        shared, own = np.split(run.jacobian, [run.derivatives.shared], axis=1)
        columns = np.hstack([own, shared, run.residual[:, None]])
        # The residual is free of heights already.
        free = np.hstack([run.freed(columns[:, :-1]), columns[:, -1:]])
        free = _by_channel(run, free)
        products = _by_channel(run, columns).transpose(0, 2, 1) @ free
        products[:, -1] = products[:, :, -1]
        return cls(free, products)

    def with_columns(self, run: RunFit, more: Columns) -> Array:
        """Products of all columns in the order: own, effect's own, shared, amplitudes, residual."""
        added = np.hstack([more.own, more.amplitudes])
        freed, added = _by_channel(run, run.freed(added)), _by_channel(run, added)
        across = self.free.transpose(0, 2, 1) @ added
        among = added.transpose(0, 2, 1) @ freed
        r, q, known = len(run.own), more.own.shape[1], self.products.shape[1]
        order = [*range(r), *range(known, known + q), *range(r, known - 1)]
        order += [*range(known + q, known + added.shape[2]), known - 1]
        whole = np.block([[self.products, across], [across.transpose(0, 2, 1), among]])
        return np.asarray(whole[:, order][:, :, order])


def _by_channel(run: RunFit, columns: Array) -> Array:
    """Columns (size, k) as (c, n, k)."""
    count, channels = run.bench.band.count, int(run.bench.predicted.sum())
    return np.asarray(columns.reshape(count, channels, columns.shape[1]).transpose(1, 0, 2))


def run_table(run: RunFit, base: Fit, signatures: Columns, products: Array) -> Table:
    """The table of a variant from its signatures and the products of all columns."""
    channels, spread = len(products), run.spread[:, None]
    whole = np.tensordot(run.spread[:channels] ** -2, products, axes=1)
    columns, own_columns = signatures.amplitudes / spread, signatures.own / spread
    r, q, g = len(run.own), own_columns.shape[1], len(base.shared)
    n = r + q
    prior = np.array([(f.scale / f.sigma) ** 2 for f in run.own] + [1.0] * q) * base.sigma**2
    firm = np.diag(prior + 1e-9 * (base.sigma**2 + prior))
    inner = whole[:n, :n] + firm
    back, rest = _eliminated(whole, firm)
    nuisance = np.hstack([run.weighed[:, g:], own_columns])
    return Table(
        rest[:-1, :-1],
        rest[:-1, -1],
        float(whole[-1, :n] @ back[:, -1]),
        q,
        _log_det(inner) - _log_det(inner[:r, :r]) - q * float(np.log(base.sigma**2)),
        (columns - nuisance @ back[:, g:-1]).astype(np.float32),
        back,
        products,
        _eliminated(products.sum(axis=0), firm)[1][:-1, :-1],
    )


def _eliminated(whole: Array, firm: Array) -> tuple[Array, Array]:
    """A run's own numbers, the first of the columns, per step of the others; and what is left of
    the products of these."""
    n = len(firm)
    back = np.linalg.solve(whole[:n, :n] + firm, whole[:n, n:])
    return np.asarray(back), np.asarray(whole[n:, n:] - whole[n:, :n] @ back)


def _log_det(matrix: Array) -> float:
    """Not a number where a simulation ran away."""
    return float(np.linalg.slogdet(matrix)[1]) if np.isfinite(matrix).all() else float("nan")


def beyond(run: RunFit, sigma: float, left: Array) -> float:
    """How much more the cost drops, times σ², than the squares weighed by the spread as it was:
    where a model comes nearer to the record, every datum weighs more."""
    if run.heights is not None:
        return 0.0
    count, channels = run.bench.band.count, len(left)
    before = np.sum(run.residual.reshape(count, -1) ** 2, axis=0)
    drop = cost_of(before / sigma**2, count) - cost_of(left / sigma**2, count)
    weighed = float(((before - left) / run.spread[:channels] ** 2).sum())
    return drop * sigma**2 - weighed
