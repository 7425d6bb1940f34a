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
    products: Products
    at_noise: Array  # the matrix as it would be if nothing but noise were left

    def left(self, x: Array) -> Array:
        """Σ residual² (c,) of every channel after a step of shared parameters and amplitudes."""
        own = self.back[:, -1] - self.back[:, :-1] @ x
        a = self.signatures.shape[1]
        own, own_of_effect = np.split(own, [len(own) - self.freedom])
        shared, amplitudes = np.split(x, [len(x) - a])
        known = np.concatenate([-own, -shared, [1.0]])
        return self.products.squares(known, np.concatenate([-own_of_effect, -amplitudes]))


@dataclass(frozen=True, eq=False)
class Products:
    """Products of columns, channel by channel: of those known, which all variants of a run have in
    common, and of a variant's own."""

    known: Array  # (c, k, k)
    across: Array  # (c, k, m)
    among: Array  # (c, m, m)

    def squares(self, known: Array, added: Array) -> Array:
        """Sum of squares (c,) of the columns, so many times each, taken together."""
        found = self.known @ known @ known
        found = found + (2.0 * self.across.transpose(0, 2, 1) @ known + self.among @ added) @ added
        return np.asarray(np.maximum(found, 0.0))

    def weighed(self, weights: Array) -> Array:
        """The matrix (k + m, k + m) with every channel weighed."""
        known, across, among = (
            np.tensordot(weights, part, axes=1) for part in (self.known, self.across, self.among)
        )
        return np.block([[known, across], [across.T, among]])

    def summed(self, chosen: Array) -> Products:
        """Those of sums of the added columns, `chosen` (m, s) of them."""
        across, among = self.across @ chosen, chosen.T @ self.among @ chosen
        return Products(self.known, np.asarray(across), np.asarray(among))


@dataclass(frozen=True, eq=False)
class Known:
    """A run's columns free of heights (c, n, k): own, shared and residual; their products
    (c, k, k), channel by channel; and the own ones (size, r) per spread."""

    free: Array
    products: Array
    own: Array

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
        return cls(free, products, own / run.spread[:, None])

    def with_columns(self, run: RunFit, more: Columns) -> Products:
        """Products with an effect's own columns and its amplitudes' added."""
        added = np.hstack([more.own, more.amplitudes])
        freed, added = _by_channel(run, run.freed(added)), _by_channel(run, added)
        across = self.free.transpose(0, 2, 1) @ added
        among = added.transpose(0, 2, 1) @ freed
        return Products(self.products, np.asarray(across), np.asarray(among))


def _by_channel(run: RunFit, columns: Array) -> Array:
    """Columns (size, k) as (c, n, k)."""
    count, channels = run.bench.band.count, int(run.bench.predicted.sum())
    return np.asarray(columns.reshape(count, channels, columns.shape[1]).transpose(1, 0, 2))


def run_table(run: RunFit, base: Fit, signatures: Columns, known: Known) -> Table:
    """The table of a variant from its signatures and what is known of the run."""
    products = known.with_columns(run, signatures)
    spread = run.spread[:, None]
    columns, own_columns = signatures.amplitudes / spread, signatures.own / spread
    r, q, g = len(run.own), own_columns.shape[1], len(base.shared)
    n, k = r + q, r + g + 1
    # The order from here on: own, effect's own, shared, amplitudes, residual.
    order = [*range(r), *range(k, k + q), *range(r, k - 1), *range(k + q, k + q + columns.shape[1])]
    order.append(k - 1)
    channels = len(products.known)
    whole = products.weighed(run.spread[:channels] ** -2)[np.ix_(order, order)]
    even = products.weighed(np.ones(channels))[np.ix_(order, order)]
    prior = np.array([(f.scale / f.sigma) ** 2 for f in run.own] + [1.0] * q) * base.sigma**2
    firm = np.diag(prior + 1e-9 * (base.sigma**2 + prior))
    inner = whole[:n, :n] + firm
    back, rest = _eliminated(whole, firm)
    nuisance = np.hstack([known.own, own_columns])
    return Table(
        rest[:-1, :-1],
        rest[:-1, -1],
        float(whole[-1, :n] @ back[:, -1]),
        q,
        _log_det(inner) - _log_det(inner[:r, :r]) - q * float(np.log(base.sigma**2)),
        (columns - nuisance @ back[:, g:-1]).astype(np.float32),
        back,
        products,
        _eliminated(even, firm)[1][:-1, :-1],
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
