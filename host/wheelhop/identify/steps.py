"""Step responses to a transfer matrix: damped sinusoids that all responses share (thesis 2.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize

from wheelhop.campaign import CampaignError
from wheelhop.identify.sections import Sections
from wheelhop.identify.statespace import StateSpace, of_fractions

Array = NDArray[np.float64]

EXACT = 1e-8
"""An error below which no other start is tried."""


@dataclass(frozen=True, eq=False)
class DampedSinusoids:
    """x(t) = R₀ + Σ e^{-σt} (R_{2k-1} sin ωt + R_{2k} cos ωt) for every response (thesis 2.1).

    `sigma` and `omega` (j,), 1/s and rad/s; `residues` (responses, 2j + 1) in that order;
    `error` is √(Σ residual² / Σ x²).
    """

    sigma: Array
    omega: Array
    residues: Array
    error: float

    def transfer(self, outputs: int, inputs: int) -> StateSpace:
        """H(s) = s X(s) of responses to unit steps (thesis 2.6), stacked input by input: the first
        `outputs` responses are those to the first input."""
        j = len(self.sigma)
        own = np.hypot(self.sigma, self.omega)
        sine, cosine = self.residues[:, 1::2], self.residues[:, 2::2]
        # s · L{e^{-σt} sin ωt} = (ω/ω₀) f₁ and s · L{e^{-σt} cos ωt} = 1 - f₀ - (σ/ω₀) f₁.
        theta = np.hstack([-cosine, (sine * self.omega - cosine * self.sigma) / own])
        direct = self.residues[:, 0] + cosine.sum(axis=1)
        shape = (inputs, outputs)
        return of_fractions(
            Sections(own, self.sigma / own),
            theta.reshape(*shape, 2 * j).transpose(1, 0, 2),
            direct.reshape(shape).T,
        )


def incremental_model(time_s: Array, responses: Array, count: int) -> tuple[Array, Array]:
    """First guesses of σ and ω (count,) from increments over `count` steps (thesis A.1-A.9).

    `responses` (experiments, points, n). The increments of all points at `count` successive steps
    are one state z, and z_{k+1} = D z_k is fitted to all experiments. Of the eigenvalues of D the
    complex pairs with most of the motion are kept. (The thesis does not say which it kept.)
    """
    step = float(time_s[1] - time_s[0])
    increments = np.diff(responses, axis=2)
    _, points, n = increments.shape
    length = n - count + 1
    if length < 2 * points * count:
        raise CampaignError(
            f"{n + 1} samples are too few for {count} damped sinusoids at {points} points:"
            f" {2 * points * count + count} are needed"
        )
    delayed = np.concatenate([increments[:, :, k : k + length] for k in range(count)], axis=1)
    before = np.hstack(list(delayed[:, :, :-1]))
    after = np.hstack(list(delayed[:, :, 1:]))
    forward = linalg.lstsq(before.T, after.T, cond=1e-10)[0].T
    values, vectors = np.linalg.eig(forward)
    moved = np.linalg.lstsq(vectors, before, rcond=None)[0]
    size = np.linalg.norm(moved, axis=1) * np.linalg.norm(vectors, axis=0)
    oscillates = (values.imag > 1e-9) & (np.abs(values) > 1e-6)
    strongest = sorted(np.flatnonzero(oscillates), key=lambda i: -size[i])[:count]
    rates = np.log(values[strongest]) / step
    return -rates.real, rates.imag


def fit_damped_sinusoids(
    time_s: Array, responses: Array, count: int, *, starts_at_rest: bool = True
) -> DampedSinusoids:
    """Fit `count` damped sinusoids, shared by all responses: the best of several descents.

    Parameters
    ----------
    time_s : (n,) uniform, from the step on.
    responses : (experiments, points, n).
    starts_at_rest : x(0) = 0 exactly, which makes H strictly proper; the thesis leaves R₀ free.

    Raises
    ------
    CampaignError : too few samples, or responses that are all zero.
    """
    if not responses.any():
        raise CampaignError("the step responses are all zero: there is nothing to fit")
    best = None
    for sigma, omega in _starts(time_s, responses, count):
        found = refine(time_s, responses, sigma, omega, starts_at_rest=starts_at_rest)
        if best is None or found.error < best.error:
            best = found
        if best.error < EXACT:
            break
    assert best is not None
    return best


def refine(
    time_s: Array, responses: Array, sigma: Array, omega: Array, *, starts_at_rest: bool = True
) -> DampedSinusoids:
    """The least squares nearest to a start (count,) each, by variable projection."""
    flat = responses.reshape(-1, len(time_s))
    scale = float(np.sqrt(np.mean(flat**2)))
    count = len(sigma)

    def solve(numbers: Array) -> tuple[Array, Array, Array]:
        basis = _basis(time_s, numbers, starts_at_rest)
        q, r = np.linalg.qr(basis)
        residues = linalg.lstsq(r, q.T @ flat.T, cond=1e-12)[0].T
        return q, residues, flat - residues @ basis.T

    def residual(numbers: Array) -> Array:
        return np.ravel(solve(numbers)[2]) / scale

    def jacobian(numbers: Array) -> Array:
        q, residues, _ = solve(numbers)
        columns = []
        for slope in _slopes(time_s, numbers, starts_at_rest):
            moved = residues @ slope.T
            columns.append(np.ravel(-(moved - (moved @ q) @ q.T)) / scale)
        return np.column_stack(columns)

    found = optimize.least_squares(
        residual, np.concatenate([sigma, omega]), jacobian, method="trf", x_scale="jac",
        bounds=(np.concatenate([np.zeros(count), np.full(count, 1e-3)]), np.inf),
    )  # fmt: skip
    order = np.argsort(found.x[:count])
    sigma, omega = found.x[:count][order], found.x[count:][order]
    _, residues, rest = solve(np.concatenate([sigma, omega]))
    full = np.empty((len(flat), 2 * count + 1))
    if starts_at_rest:  # Σ b (1 - e^{-σt} cos ωt): the constant is the sum of what is taken off
        full[:, 1::2], full[:, 2::2] = residues[:, :count], -residues[:, count:]
        full[:, 0] = residues[:, count:].sum(axis=1)
    else:
        full[:, 0] = residues[:, -1]
        full[:, 1::2], full[:, 2::2] = residues[:, :count], residues[:, count : 2 * count]
    error = float(np.sqrt(np.sum(rest**2) / np.sum(flat**2)))
    return DampedSinusoids(sigma, omega, full, error)


def _starts(time_s: Array, responses: Array, count: int) -> list[tuple[Array, Array]]:
    """Where descents begin: the incremental model's pairs, filled up with neighbours if it has
    fewer, and the same with one pair at the side of another."""
    sigma, omega = incremental_model(time_s, responses, count)
    if not len(sigma):
        sigma, omega = np.array([1.0 / time_s[-1]]), np.array([2 * np.pi / time_s[-1]])
    while len(sigma) < count:
        sigma, omega = np.append(sigma, 2 * sigma[-1]), np.append(omega, 1.1 * omega[-1])
    sigma = np.maximum(sigma, 0.05)
    spread = np.geomspace(0.6, 1.7, count) if count > 1 else np.ones(1)
    middle = (np.full(count, sigma.mean()) * spread, np.full(count, omega.mean()))
    return [(sigma, omega), (middle[0], middle[1] * spread[::-1] ** 0.3)]


def _basis(time_s: Array, numbers: Array, at_rest: bool) -> Array:
    """Columns: all sines, all cosines (taken off 1 when at rest), and a constant unless at rest."""
    sine, cosine = _waves(time_s, numbers)
    if at_rest:
        return np.hstack([sine, 1.0 - cosine])
    return np.hstack([sine, cosine, np.ones((len(time_s), 1))])


def _slopes(time_s: Array, numbers: Array, at_rest: bool) -> list[Array]:
    """Derivatives of `_basis` by each σ, then by each ω."""
    sine, cosine = _waves(time_s, numbers)
    j, sign = sine.shape[1], -1.0 if at_rest else 1.0
    width = 2 * j + (not at_rest)
    out = []
    for by_sine, by_cosine in ((-sine, -cosine), (cosine, -sine)):
        for k in range(j):
            slope = np.zeros((len(time_s), width))
            slope[:, k] = time_s * by_sine[:, k]
            slope[:, j + k] = sign * time_s * by_cosine[:, k]
            out.append(slope)
    return out


def _waves(time_s: Array, numbers: Array) -> tuple[Array, Array]:
    j = len(numbers) // 2
    decay = np.exp(-np.outer(time_s, numbers[:j]))
    angle = np.outer(time_s, numbers[j:])
    return decay * np.sin(angle), decay * np.cos(angle)
