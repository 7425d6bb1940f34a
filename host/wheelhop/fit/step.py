"""One step of a fit: to where the linearised model costs least.

What a channel leaves counts by its logarithm (`spread.py`), so its weight depends on where the step
ends. The step is solved for again and again, every channel weighed by what the last one would leave
of it, until the cost falls no more. Undamped, no pass raises the cost of the linearised model
(K. Lange, R. Little, J. Taylor, J. Am. Stat. Assoc. 84 (1989) 881); and none simulates anything:
JᵀJ, Jᵀr and rᵀr of every channel say what any step would leave.

Numbers have bounds. A step that is cut off where it leaves them no longer leads down: the others
were to make up for what is cut off. So the least is sought among the steps within the bounds, by an
active set (J. Nocedal, S. Wright, Numerical Optimization, 2nd ed., section 16.5).
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
    """What is believed of p numbers, seen from where they are: precision (p, p), pull (p,) towards
    the mean, and the room (2, p) below and above within their bounds, per `Free.scale`."""

    precision: Array
    pull: Array
    room: Array

    @classmethod
    def of(cls, belief: Belief, values: Mapping[str, float], pull: Array) -> Prior:
        """What a belief says there, in its `coordinates`; with what else pulls (p,)."""
        along = belief.coordinates(values)
        precision = along.T @ belief.precision_at(values) @ along
        return cls(precision, along.T @ (belief.pull(values) + pull), belief.room(values))

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

    def held(self, at: Array) -> Normal:
        """The equations with the own numbers' steps fixed `at` (r,); NaN leaves one free."""
        own, mixed, held = self.own.copy(), self.mixed.copy(), np.isfinite(at)
        mixed[:, held] = 0.0
        return Normal(
            self.shared,
            mixed,
            own,
            self.shared_gradient - self.mixed[:, held] @ at[held],
            _held(own, self.own_gradient, at),
        )


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
            Prior(belief.precision, pull, belief.room(values)),
            run.spread[: len(residual)] ** -2,
            None if even else run.bench.counted,
        )
        return found if run.heights is None else found.freed(run.heights, run)

    def along(self, coordinates: Array) -> Linear:
        """This run with the g shared numbers in other coordinates (g, g)."""
        g, m = len(coordinates), self.slopes.shape[1]
        turn = np.eye(m)
        turn[:g, :g] = coordinates
        ahead, less = self.heights or (None, None)
        return replace(
            self,
            squares=turn.T @ self.squares @ turn,
            slopes=self.slopes @ turn,
            heights=None if ahead is None or less is None else (ahead, less @ turn),
        )

    def freed(self, heights: Heights, run: RunFit) -> Linear:
        """This run with the unknown heights of its ground eliminated."""
        projected = heights.ground.project(np.column_stack([run.jacobian, run.residual]))
        cross, slope = projected[:, :-1], projected[:, -1]
        ahead, less = heights.step(slope, cross)
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
    room = np.concatenate([prior.room, *(run.own.room for run in runs)], axis=1)
    while True:
        normals = [run.normal(w) for run, w in zip(runs, weights, strict=True)]
        step, *own = _within(Quadratic.of(prior, normals, damping), room)
        found = [run.after(np.concatenate([step, o])) for run, o in zip(runs, own, strict=True)]
        cost = prior.cost(step) + sum(part for part, _ in found)
        if not before - cost > enough:  # nor where a cost is no number
            return step, own, start - cost
        before, weights = cost, [w for _, w in found]


@dataclass(frozen=True, eq=False)
class Quadratic:
    """The damped cost of a step with every channel's weight given: that of the shared numbers by
    themselves, and every run's."""

    matrix: Array  # (g, g)
    gradient: Array  # (g,)
    runs: Sequence[Normal]

    @classmethod
    def of(cls, prior: Prior, normals: Sequence[Normal], damping: float) -> Quadratic:
        """That of a prior of the shared numbers and the runs' normal equations, damped."""
        runs = [replace(normal, own=damped(normal.own, damping)) for normal in normals]
        found = cls(prior.precision, prior.pull, runs)
        matrix, _, _ = found._eliminated(runs)
        return replace(found, matrix=prior.precision + damped(matrix, damping) - matrix)

    def least(self, at: Sequence[Array]) -> list[Array]:
        """The step of the shared numbers and those of every run's own to the least cost, numbers
        held where `at` is a number."""
        held, *own_held = at
        normals = [run.held(own) for run, own in zip(self.runs, own_held, strict=True)]
        matrix, gradient, backs = self._eliminated(normals)
        gradient = _held(matrix, gradient, held)
        step = np.asarray(np.linalg.solve(matrix, gradient))
        return [step, *(back[:, -1] - back[:, :-1] @ step for back in backs)]

    def slope(self, step: Sequence[Array]) -> list[Array]:
        """Half of how the cost grows along each number at a step."""
        shared, *own = step
        slope = self.matrix @ shared - self.gradient
        for run, o in zip(self.runs, own, strict=True):
            slope = slope + run.shared @ shared + run.mixed @ o - run.shared_gradient
        pairs = zip(self.runs, own, strict=True)
        return [slope, *(r.mixed.T @ shared + r.own @ o - r.own_gradient for r, o in pairs)]

    def _eliminated(self, normals: Sequence[Normal]) -> tuple[Array, Array, list[Array]]:
        """Matrix and gradient of the shared numbers where the runs' own follow at their best; and
        how these do (r, g + 1)."""
        matrix, gradient = self.matrix.copy(), self.gradient.copy()
        backs = list[Array]()
        for run in normals:
            back = np.linalg.solve(run.own, np.column_stack([run.mixed.T, run.own_gradient]))
            matrix += run.shared - run.mixed @ back[:, :-1]
            gradient += run.shared_gradient - run.mixed @ back[:, -1]
            backs.append(np.asarray(back))
        return matrix, gradient, backs


def _within(quadratic: Quadratic, room: Array) -> list[Array]:
    """The step within the `room` (2, p) of all numbers, the shared and every run's own, to the
    least cost.

    From where the numbers are, the way leads to the least cost of those that are not held; where it
    meets bounds it ends, and they are held there. One that would better leave its bound is let go
    of, but none twice: rounding must not make that go on for ever.
    """
    cuts = np.cumsum([len(quadratic.gradient), *(len(run.own) for run in quadratic.runs)])[:-1]
    at = np.clip(np.zeros(room.shape[1]), *room)
    held, kept = np.zeros(len(at), dtype=bool), np.zeros(len(at), dtype=bool)
    while True:
        aim = np.concatenate(quadratic.least(np.split(np.where(held, at, np.nan), cuts)))
        bound = np.clip(aim, *room)
        beyond = ~held & (abs(aim - bound) > 0.0)
        if beyond.any():
            share = np.where(beyond, bound - at, np.inf) / np.where(beyond, aim - at, 1.0)
            first = beyond & (share <= share.min())
            at = np.where(first, bound, np.where(held, at, at + share.min() * (aim - at)))
            held |= first
            continue
        slope = np.concatenate(quadratic.slope(np.split(aim, cuts)))
        better = held & ~kept & np.where(slope < 0.0, aim < room[1], aim > room[0])
        if not better.any():
            return np.split(aim, cuts)
        free = np.argmax(np.where(better, abs(slope), 0.0))
        at, held[free], kept[free] = aim, False, True


def _held(matrix: Array, gradient: Array, at: Array) -> Array:
    """Makes of a symmetric `matrix` one with which a step is `at` (p,), as far as that is a number;
    its gradient (p,)."""
    held = np.isfinite(at)
    gradient = np.where(held, at, gradient - matrix[:, held] @ at[held])
    matrix[held] = 0.0
    matrix[:, held] = 0.0
    matrix[held, held] = 1.0
    return gradient


def damped(matrix: Array, damping: float) -> Array:
    """Marquardt's damping; the small constant keeps a parameter nothing depends on where it is, and
    a share as small as rounding tells two from each other that huge data do not.

    Both must stay far below the priors' weight, 1: they alone hold the common scale of all forces.
    """
    return matrix + np.diag((damping + 1e-14) * np.diag(matrix) + 1e-6)
