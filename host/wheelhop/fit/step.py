"""One step of a fit: to where the linearised model costs least.

What a channel leaves counts by its logarithm (`spread.py`), so its weight depends on where the step
ends. The step is solved for again and again, every channel weighed by what the last one would leave
of it, until the cost falls no more. Undamped, no pass raises the cost of the linearised model
(K. Lange, R. Little, J. Taylor, J. Am. Stat. Assoc. 84 (1989) 881); and none simulates anything:
JᵀJ, Jᵀr and rᵀr of every channel say what any step would leave.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.fit.belief import Belief
from wheelhop.fit.heights import Heights
from wheelhop.fit.result import RunFit

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Prior:
    """What is believed of p numbers, seen from where they are: precision (p, p) and pull (p,)
    towards the mean, per `Free.scale`."""

    precision: Array
    pull: Array

    def cost(self, step: Array) -> float:
        """By how much the squared distance from the mean grows."""
        return float(step @ self.precision @ step - 2.0 * step @ self.pull)


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations of one run, per `Free.scale`: JᵀRJ/σ² and JᵀRr/σ² in blocks of the shared
    and of the run's own numbers, the own numbers' priors included."""

    shared: Array  # (g, g)
    mixed: Array  # (g, r)
    own: Array  # (r, r)
    shared_gradient: Array  # (g,)
    own_gradient: Array  # (r,)

    def own_step(self, step: Array, damping: float) -> Array:
        """The step (r,) of the own numbers that is best with one (g,) of the shared."""
        gradient = self.own_gradient - self.mixed.T @ step
        return np.asarray(np.linalg.solve(damped(self.own, damping), gradient))


@dataclass(frozen=True, eq=False)
class Linear:
    """One linearised run, channel by channel, with respect to m numbers: the shared ones and its
    own. Where its ground has unknown heights they are eliminated, and all channels are one."""

    squares: Array  #: (c, m, m) JᵀJ/σ²
    slopes: Array  #: (c, m) Jᵀr/σ²
    powers: Array  #: (c,) rᵀr/σ²
    own: Prior
    weights: Array  #: (c,) at the residual
    counted: Callable[[Array], tuple[float, Array]] | None  #: `Bench.counted`; None: by squares
    heights: tuple[ComplexArray, ComplexArray] | None = None
    """Their step (2k,), and how much less (2k, m) they move per step of the numbers."""

    @classmethod
    def of(cls, run: RunFit, values: Mapping[str, float], sigma: float, *, even: bool) -> Linear:
        """A run about its own `values`; `even` where some run's ground has unknown heights."""
        weight, count = sigma**-2, run.bench.band.count
        residual = run.residual.reshape(count, -1).T
        columns = np.empty((len(residual), len(run.derivatives.columns), count))
        for k, column in enumerate(run.derivatives.columns):
            columns[:, k] = column.reshape(count, -1).T
        squares = columns @ columns.transpose(0, 2, 1) * weight
        slopes = (columns @ residual[:, :, np.newaxis])[:, :, 0] * weight
        belief = Belief.of(run.own)
        pull = belief.pull(values)
        # A shape means nothing while its amplitude vanishes: until then it stays where it began.
        pull[~np.diagonal(squares, 0, 1, 2)[:, run.derivatives.shared :].any(axis=0)] = 0.0
        found = cls(
            squares,
            slopes,
            (residual**2).sum(axis=1) * weight,
            Prior(belief.precision, pull),
            run.spread[: len(residual)] ** -2,
            None if even else run.bench.counted,
        )
        return found if run.heights is None else found.freed(run.heights, run)

    def freed(self, heights: Heights, run: RunFit) -> Linear:
        """The same with the unknown heights of the run's ground eliminated."""
        cross = heights.ground.project(run.jacobian)
        slope = heights.ground.project(run.residual[:, np.newaxis])[:, 0]
        ahead, less = heights.step(slope), heights.absorbed(cross)
        taken = (cross.conj().T @ np.column_stack([less, ahead])).real / heights.sigma**2
        return replace(
            self,
            squares=self.squares.sum(axis=0)[np.newaxis] - taken[:, :-1],
            slopes=self.slopes.sum(axis=0)[np.newaxis] - taken[:, -1],
            powers=self.powers.sum(keepdims=True),
            weights=np.ones(1),
            heights=(ahead, less),
        )

    def normal(self, weights: Array) -> Normal:
        """Normal equations with every channel weighed."""
        g = self.slopes.shape[1] - len(self.own.pull)
        square, slope = np.tensordot(weights, self.squares, axes=1), weights @ self.slopes
        return Normal(
            square[:g, :g],
            square[:g, g:],
            square[g:, g:] + self.own.precision,
            slope[:g],
            slope[g:] + self.own.pull,
        )

    def after(self, step: Array) -> tuple[float, Array]:
        """Cost (up to a constant) and weights (c,) after a step (m,)."""
        squared = np.einsum("i,cij,j->c", step, self.squares, step)
        powers = self.powers - 2.0 * self.slopes @ step + squared
        prior = self.own.cost(step[len(step) - len(self.own.pull) :])
        if self.counted is None:
            return float(powers.sum()) + prior, self.weights
        cost, weights = self.counted(np.maximum(powers, 0.0))  # below zero is rounding
        return cost + prior, weights


def least(
    prior: Prior, runs: Sequence[Linear], damping: float, enough: float
) -> tuple[Array, list[Array], float]:
    """The damped step (g,) of the shared numbers, and those (r,) of every run's own, to the least
    cost, and by how much it promises to lower that; sought until a pass lowers it by no more than
    `enough`. If that is infinite, the first pass is the last, and channels weigh as they do before
    the step."""
    weights, before = [run.weights for run in runs], np.inf
    start = sum(run.after(np.zeros(run.slopes.shape[1]))[0] for run in runs)
    while True:
        normals = [run.normal(w) for run, w in zip(runs, weights, strict=True)]
        matrix, gradient = prior.precision.copy(), prior.pull.copy()
        for normal in normals:
            back = np.linalg.solve(
                damped(normal.own, damping),
                np.column_stack([normal.mixed.T, normal.own_gradient]),
            )
            matrix += normal.shared - normal.mixed @ back[:, :-1]
            gradient += normal.shared_gradient - normal.mixed @ back[:, -1]
        step = np.asarray(np.linalg.solve(damped(matrix, damping), gradient))
        own = [normal.own_step(step, damping) for normal in normals]
        found = [run.after(np.concatenate([step, o])) for run, o in zip(runs, own, strict=True)]
        cost = prior.cost(step) + sum(part for part, _ in found)
        if not before - cost > enough:  # nor where a cost is no number
            return step, own, start - cost
        before, weights = cost, [w for _, w in found]


def damped(matrix: Array, damping: float) -> Array:
    """Marquardt's damping; the small constant keeps a parameter nothing depends on where it is, and
    a share as small as rounding tells two from each other that huge data do not.

    Both must stay far below the priors' weight, 1: they alone hold the common scale of all forces.
    """
    return matrix + np.diag((damping + 1e-14) * np.diag(matrix) + 1e-6)
