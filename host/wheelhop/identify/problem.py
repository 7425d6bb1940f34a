"""The least-squares problem: numerators by linear algebra, poles by Gauss-Newton steps.

For given poles (and given ratios of the suspensions) the numerators are a linear least-squares
problem with linear constraints, solved exactly; what remains is a function of the poles alone
(variable projection: G. Golub and V. Pereyra, Inverse Problems 19 (2003) R1). Its Gauss-Newton
step is the one of the full problem with the numerators eliminated, analytic throughout. The error
that is minimised is the output error, not the error times the denominator (thesis 5.6-5.10, which
weighs each frequency by |denominator|²).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.identify.gram import Gram, Regressors, Stack, Weighted, real_products
from wheelhop.identify.sections import ComplexArray, Sections, from_parameters
from wheelhop.identify.structure import RIGID, VERTICAL, Structure, Suspensions

Array = NDArray[np.float64]
RIDGE = 1e-13
"""Of the largest diagonal term, after scaling: keeps superfluous poles from dividing by zero."""
LEAST_ZETA = 1e-4
MOST_NOISE = 0.9
"""Of any combination of the inputs' power: a trial where noise is more has no minimum."""


@dataclass(frozen=True, eq=False)
class Point:
    """A trial: nonlinear numbers, the numerators that belong to them, and the cost."""

    numbers: Array  #: (P,) ln ω, ln ζ (or ζ), ln r, and the free numbers of the suspensions
    sections: Sections
    suspension: Array  #: (3,)
    free: Array  #: (elements · order,)
    theta: Array  #: (n, m, order)
    gram: Gram
    regressors: list[Regressors]
    cost: float


@dataclass(frozen=True, eq=False)
class Step:
    """The linearised problem at a point.

    `normal` and `gradient` are of the unknowns that constraints leave: first the numerators', then
    the nonlinear numbers. `basis` takes them to (free, numbers).
    """

    normal: Array
    gradient: Array
    basis: Array
    nonlinear: int


class Problem:
    """Weighted runs, a structure and an order.

    Parameters
    ----------
    stack : the weighted runs.
    structure : what physics fixes.
    inputs, outputs : corners of the columns and rows.
    suspensions : belief about D, needed by the structure "reciprocal".
    output_weight : (n,) one over the variance of a real coordinate of each output.
    order : number of poles.
    """

    def __init__(
        self,
        stack: Stack,
        structure: Structure,
        inputs: tuple[int, ...],
        outputs: tuple[int, ...],
        suspensions: Suspensions | None,
        output_weight: Array,
        order: int,
    ) -> None:
        self.stack, self.structure = stack, structure
        self.inputs, self.outputs = inputs, outputs
        self.output_weight, self.order = output_weight, order
        self.elements = structure.elements(outputs, inputs)
        self.index = (self.elements[:, :, None] * order + np.arange(order)).reshape(
            len(outputs), -1
        )
        # No number stands twice in a row of H, whatever the structure: rows may simply be added.
        self.unknowns = (int(self.elements.max()) + 1) * order
        self.belief = suspensions or Suspensions(np.array([1.0, 0.0, 0.0]), np.zeros(3))
        uses = structure.symmetry == "reciprocal"
        self.moving = np.flatnonzero(self.belief.sd > 0) if uses else np.zeros(0, int)
        self.uses_suspensions = uses
        self._latest: tuple[Point, Step] | None = None

    @cached_property
    def fixed(self) -> int:
        """How many of the unknowns the constraints leave no choice."""
        anywhere = from_parameters(np.zeros(self.order))
        a = self._constraints(anywhere, self.belief.value)[0]
        return int(np.linalg.matrix_rank(a)) if len(a) else 0

    def start(self, sections: Sections) -> Array:
        """The vector of nonlinear numbers at these sections and at the believed suspensions."""
        numbers = sections.parameters()
        m = len(sections.omega)
        if self.structure.stable:
            numbers[m : 2 * m] = np.log(np.maximum(sections.zeta, LEAST_ZETA))
        return np.concatenate([numbers, self.belief.value[self.moving]])

    def at(self, numbers: Array) -> Point:
        """Solve for the numerators."""
        sections, suspension = self._unpack(numbers)
        regressors = self.stack.regressors(sections, self._factors(suspension))
        sums = self.stack.gram(regressors)
        free, sound = self._numerators(sums, sections, suspension)
        theta = free[self.index]
        cost = self._prior(suspension) if sound else np.inf
        for i, weight in enumerate(self.output_weight):
            t = theta[i]
            rest = sums.x_x[i] - 2 * t @ sums.phi_x[:, i] + t @ sums.phi_phi @ t
            cost += weight * max(float(rest), 0.0)
        shape = (len(self.outputs), len(self.inputs), self.order)
        return Point(
            numbers, sections, suspension, free, theta.reshape(shape), sums, regressors, cost
        )

    def heard(self, point: Point) -> float:
        """What the inputs' noise is expected to add to the weighted sum of squares by way of H; the
        cost of `point` is without it."""
        return float(
            sum(
                weight * row.ravel() @ point.gram.noise @ row.ravel()
                for weight, row in zip(self.output_weight, point.theta, strict=True)
            )
        )

    def linearised(self, point: Point) -> Step:
        """Normal equations of numerators and nonlinear numbers together; those of the latest point
        are kept."""
        if self._latest is None or self._latest[0] is not point:
            self._latest = (point, self._linearise(point))
        return self._latest[1]

    def _linearise(self, point: Point) -> Step:
        count = len(point.numbers)
        normal = np.zeros((self.unknowns + count, self.unknowns + count))
        gradient = np.zeros(self.unknowns + count)
        below = slice(self.unknowns, None)
        theta = point.theta.reshape(len(self.outputs), -1)
        across, normal[below, below], gradient[below] = self._products(point)
        for i, weight in enumerate(self.output_weight):
            at = self.index[i]
            normal[at[:, None], at] += weight * point.gram.phi_phi
            normal[at, below] += across[:, i]
            rest = point.gram.phi_x[:, i] - point.gram.phi_phi @ theta[i]
            gradient[at] += weight * rest
            gradient[below] -= across[:, i].T @ theta[i]
        normal[below, : self.unknowns] = normal[: self.unknowns, below].T
        if len(self.moving):
            inverse = 1.0 / self.belief.sd[self.moving] ** 2
            tail = np.arange(self.unknowns + count - len(self.moving), self.unknowns + count)
            normal[tail, tail] += inverse
            gradient[tail] -= inverse * (point.suspension - self.belief.value)[self.moving]
        basis = self._allowed(point)
        return Step(basis.T @ normal @ basis, basis.T @ gradient, basis, count)

    def _unpack(self, numbers: Array) -> tuple[Sections, Array]:
        poles = np.array(numbers[: self.order])
        m = self.order // 2
        if self.structure.stable:
            poles[m : 2 * m] = np.exp(poles[m : 2 * m])
        suspension = self.belief.value.copy()
        suspension[self.moving] = numbers[self.order :]
        suspension[0] = max(suspension[0], 0.1 * self.belief.value[0])
        suspension[1:] = np.maximum(suspension[1:], 0.0)
        return from_parameters(poles), suspension

    def _factors(self, suspension: Array) -> list[ComplexArray]:
        if not self.uses_suspensions:
            return [np.ones((len(p.omega), len(self.inputs)), complex) for p in self.stack.parts]
        return [self.belief.factor(suspension, 1j * p.omega, self.inputs) for p in self.stack.parts]

    def _prior(self, suspension: Array) -> float:
        off = (suspension - self.belief.value)[self.moving] / self.belief.sd[self.moving]
        return float(off @ off)

    def _constraints(self, sections: Sections, suspension: Array) -> tuple[Array, Array, Array]:
        """A (k, unknowns) and b (k,) of A free = b, and the derivative of A by K_rear / K_front."""
        vertical = [corner for corner in self.inputs if corner < VERTICAL]
        if not (self.structure.rigid and len(vertical) == VERTICAL):
            return np.zeros((0, self.unknowns)), np.zeros(0), np.zeros((0, self.unknowns))
        rear = np.array([2 <= corner < VERTICAL for corner in self.inputs])
        scale = np.where(rear & self.uses_suspensions, suspension[0], 1.0)
        at_zero = sections.at_zero()[0]
        # Moved forward alike, the axles raise the body by nothing.
        count = 4 if len(self.inputs) == 2 * VERTICAL else 3
        rigid = np.zeros((len(self.inputs), count))
        rigid[:VERTICAL, :3], rigid[VERTICAL:, 3:] = RIGID[vertical], 1.0
        lifted = np.zeros((len(self.outputs), count))
        lifted[:, :3] = RIGID[list(self.outputs)]
        a = np.zeros((len(self.outputs) * count, self.unknowns))
        by_ratio = np.zeros_like(a)
        held, moved = (np.kron((by[:, None] * rigid).T, at_zero) for by in (scale, rear))
        for i, at in enumerate(self.index):
            rows = slice(count * i, count * (i + 1))
            a[rows, at], by_ratio[rows, at] = held, moved
        return a, lifted.ravel(), by_ratio

    def _numerators(self, sums: Gram, sections: Sections, suspension: Array) -> tuple[Array, bool]:
        """The free numbers, and whether their least squares have a minimum (noise leaves it)."""
        normal = np.zeros((self.unknowns, self.unknowns))
        right = np.zeros(self.unknowns)
        for i, weight in enumerate(self.output_weight):
            normal[self.index[i][:, None], self.index[i]] += weight * sums.phi_phi
            right[self.index[i]] += weight * sums.phi_x[:, i]
        less = normal
        if self.stack.noisy:
            less = MOST_NOISE * normal
            for i, weight in enumerate(self.output_weight):
                at = self.index[i]
                less[at[:, None], at] -= (1 - MOST_NOISE) * weight * sums.noise
        a, b, _ = self._constraints(sections, suspension)
        fixed = np.zeros(self.unknowns)
        if len(a):
            fixed, null = linalg.lstsq(a, b)[0], linalg.null_space(a)
            right = null.T @ (right - normal @ fixed)
            normal, less = null.T @ normal @ null, null.T @ less @ null
        if self.stack.noisy and not _positive(less):
            return fixed, False
        inside = _solve(normal, right)
        return (fixed + null @ inside if len(a) else inside), True

    def _products(self, point: Point) -> tuple[Array, Array, Array]:
        """Weighted products of the derivatives d of the modelled outputs by the nonlinear numbers,
        the numerators and the initial states held: with Φ, output by output (m·order, n, P); with
        themselves (P, P) and with the outputs (P,), summed over the outputs."""
        n, count, scale = len(self.outputs), len(point.numbers), np.sqrt(self.output_weight)
        across = np.zeros((len(self.inputs) * self.order, n * count))
        d_d, d_x = np.zeros((count, count)), np.zeros(count)
        factors = self._factors(point.suspension)
        for part, factor, at in zip(self.stack.parts, factors, point.regressors, strict=True):
            d, by_input = self._derivatives(point, part, factor, at)
            groups, k, r = d.shape[:3]
            by_line, flat = d.reshape(groups, k, r, -1), d.reshape(-1, count)
            driven = (part.inputs.conj().swapaxes(2, 3) @ by_line).sum(axis=0)
            if self.stack.noisy:
                heard = part.noise[:, None, None] * by_input
                driven -= heard
                d_d -= real_products(heard.reshape(-1, count), by_input.reshape(-1, count))
            across += np.concatenate(
                [(at.scaled[j].conj() @ driven[:, j]).real for j in range(len(self.inputs))]
            )
            d_d += real_products(flat, flat)
            d_x += real_products(flat, (part.outputs * scale).reshape(-1, 1))[:, 0]
            # What of d lies in the basis of the initial states takes no part.
            inside = (at.transients.conj() @ by_line.reshape(groups, k, -1)).real
            inside = inside.reshape(groups, -1, r, n * count).swapaxes(1, 2).reshape(-1, n * count)
            across -= at.phi.reshape(-1, len(across)).T @ inside
            inside = inside.reshape(-1, count)
            d_d -= inside.T @ inside
            d_x -= inside.T @ (at.x * scale).ravel()
        return across.reshape(-1, n, count) * scale[:, None], d_d, d_x

    def _derivatives(
        self, point: Point, part: Weighted, factor: ComplexArray, at: Regressors
    ) -> tuple[ComplexArray, ComplexArray]:
        """d (g, k, r, n, P) of one part, each output times the root of its weight, and the same for
        each input alone being 1 (k, m, n P)."""
        s, m, scale = 1j * part.omega, self.order // 2, np.sqrt(self.output_weight)
        theta = point.theta * scale[:, None, None]
        slopes = point.sections.basis_slopes(s)
        if self.structure.stable:
            slopes[m : 2 * m] *= point.sections.zeta[:, None, None]
        by = np.einsum("pkl,ijl->kjip", slopes, theta, optimize=True)
        by *= factor[:, :, None, None]
        if len(self.moving):
            bends = self.belief.slopes(point.suspension, s, self.inputs)[self.moving]
            value = np.tensordot(at.fractions, theta, axes=(0, 2)).swapaxes(1, 2)
            more = bends.transpose(1, 2, 0)[:, :, None, :] * value[:, :, :, None]
            by = np.concatenate([by, more], axis=3)
        by_input = np.ascontiguousarray(by).reshape(*by.shape[:2], -1)
        moved = part.inputs @ by_input
        d: ComplexArray = moved.reshape(*moved.shape[:3], len(scale), -1)
        if not self.stack.at_rest:
            states = at.initial_states(point.theta.reshape(len(scale), -1)) * scale
            along = states.reshape(len(states), 1, self.order, -1).swapaxes(2, 3)
            decays = along @ (slopes.transpose(1, 2, 0) * part.weight[:, :, None, None])
            d[..., : self.order] += decays.reshape(*d.shape[:4], -1)
        return d, by_input

    def _allowed(self, point: Point) -> Array:
        """Directions (unknowns + P, …) along which the constraints stay true to first order."""
        count = len(point.numbers)
        a, _, by_ratio = self._constraints(point.sections, point.suspension)
        null = linalg.null_space(a) if len(a) else np.eye(self.unknowns)
        out = np.zeros((self.unknowns + count, null.shape[1] + count))
        out[: self.unknowns, : null.shape[1]] = null
        out[self.unknowns :, null.shape[1] :] = np.eye(count)
        if len(a) and 0 in self.moving:
            follows = linalg.lstsq(a, -by_ratio @ point.free)[0]
            out[: self.unknowns, null.shape[1] + self.order] = follows
        return out


def _positive(symmetric: Array) -> bool:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(symmetric), 1e-300))
    scaled = symmetric * scale[:, None] * scale
    scaled.flat[:: len(scaled) + 1] += RIDGE
    try:
        linalg.cholesky(scaled, check_finite=False)
    except linalg.LinAlgError:
        return False
    return True


def reduced(step: Step) -> tuple[Array, Array]:
    """Normal matrix and gradient of the nonlinear numbers, the numerators eliminated."""
    k = step.nonlinear
    inner = step.normal[:-k, :-k]
    across = step.normal[:-k, -k:]
    eliminated = _solve(inner, np.column_stack([across, step.gradient[:-k]]))
    normal = step.normal[-k:, -k:] - across.T @ eliminated[:, :-1]
    # Numerators that are hardly told apart may take more out of a column than is in it.
    np.fill_diagonal(normal, np.maximum(np.diag(normal), 0.0))
    return normal, step.gradient[-k:] - across.T @ eliminated[:, -1]


def descend(problem: Problem, start: Array, *, tolerance: float, steps: int = 40) -> Point:
    """Levenberg-Marquardt steps from `start` until a step promises less than `tolerance` of the
    cost; none where it has no minimum."""
    point = problem.at(start)
    if not np.isfinite(point.cost):
        return point
    damping = 1e-3
    for _ in range(steps):
        normal, gradient = reduced(problem.linearised(point))
        scale = np.abs(np.diag(normal))
        scale = np.maximum(scale, 1e-12 * scale.max())
        while damping < 1e8:
            move = _solve(normal + damping * np.diag(scale), gradient)
            move *= min(1.0, 0.7 / max(float(np.abs(move[: problem.order]).max()), 1e-300))
            promised = float(2 * move @ gradient - move @ normal @ move)
            if promised < tolerance * point.cost:
                return point
            trial = problem.at(point.numbers + move)
            if trial.cost < point.cost:
                point, damping = trial, max(damping / 5, 1e-9)
                break
            damping *= 8
        else:
            return point
    return point


def _solve(normal: Array, right: Array) -> Array:
    """Solve symmetric positive equations scaled to a unit diagonal."""
    scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(normal)), 1e-300))
    scaled = normal * scale[:, None] * scale
    scaled.flat[:: len(scaled) + 1] += RIDGE
    columns = right * (scale if right.ndim == 1 else scale[:, None])
    try:
        out = linalg.cho_solve(linalg.cho_factor(scaled, check_finite=False), columns)
    except linalg.LinAlgError:
        out = linalg.lstsq(scaled, columns, cond=1e-12)[0]
    return np.asarray(out * (scale if right.ndim == 1 else scale[:, None]))
