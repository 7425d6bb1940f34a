"""Where the poles begin: relocated from anywhere in the band until they stay (vector fitting)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.identify.gram import Stack, inner
from wheelhop.identify.problem import Point, Problem
from wheelhop.identify.sections import Sections, from_poles

Array = NDArray[np.float64]
RELOCATIONS = 8
SETTLED = 0.99
"""Two relocations in a row that leave more than this of the least cost are the last."""
WELL_DAMPED, LIGHTLY_DAMPED = 0.3, 0.03


def starts(order: int, band: tuple[float, float]) -> list[Sections]:
    """Where poles may begin: well damped over the logarithm of the band, rad/s, as those of a body
    on its suspensions; lightly damped and evenly spaced, as those of a frame."""
    low, high = band
    m = order // 2
    ends = (1.5 * low, 0.9 * high)
    rate = float(np.sqrt(low * high)) if order % 2 else None
    middle = np.array([np.sqrt(low * high)])
    return [
        Sections(omega[:m], np.full(m, zeta), rate)
        for omega, zeta in (
            (np.geomspace(*ends, m) if m > 1 else middle, WELL_DAMPED),
            (np.linspace(*ends, m) if m > 1 else middle, LIGHTLY_DAMPED),
        )
    ]


def relocated(problem: Problem, begin: Sequence[Sections]) -> Point:
    """The best of some relocations from the better beginning, as a trial of `problem`, whose runs
    are at rest.

    With σ(s) a scalar that has the present poles, σ X = (σ H) Y has σ H over the same poles too, a
    linear problem in its residues and σ's; the zeros of σ are the next poles. σ is kept off zero by
    its mean over the band being 1 (B. Gustavsen, IEEE Trans. Power Delivery 21 (2006) 1587, eq. 8).
    The rows for σ alone are kept, those of σ H are eliminated output by output (D. Deschrijver et
    al., IEEE Microw. Wireless Compon. Lett. 18 (2008) 383).
    """
    tried = [problem.at(problem.start(sections)) for sections in begin]
    point = best = min(tried, key=lambda p: p.cost)
    stalled = 0
    for _ in range(RELOCATIONS):
        point = problem.at(problem.start(_relocate(problem.stack, point)))
        stalled = 0 if point.cost < SETTLED * best.cost else stalled + 1
        best = min(best, point, key=lambda p: p.cost)
        if stalled == 2:
            break
    return best


def _relocate(stack: Stack, point: Point) -> Sections:
    sections, phi_phi = point.sections, point.gram.phi_phi
    width, outputs = sections.order + 1, stack.outputs
    own = np.zeros((outputs, width, width))
    across = np.zeros((len(phi_phi), outputs * width))
    mean = np.zeros(width)
    for part, at in zip(stack.parts, point.regressors, strict=True):
        k = len(part.omega)
        sigma = np.vstack([at.fractions, np.ones((1, k))])
        across += np.concatenate(
            [
                inner(at.scaled[j], (part.y_x[j][:, None] * sigma).reshape(-1, k))
                for j in range(stack.inputs)
            ]
        )
        for i in range(outputs):
            own[i] += inner(sigma, sigma * part.x_x[i])
        mean += sigma.real.sum(axis=1)
    taken = across.T @ _solve(phi_phi, across)
    schur = np.zeros((width, width))
    for i in range(outputs):
        of_one = slice(i * width, (i + 1) * width)
        schur += (own[i] - taken[of_one, of_one]) / max(own[i, -1, -1], 1e-300)
    z = _solve(schur, mean)
    residues, constant = z[:-1], z[-1]
    if constant == 0.0:
        return sections
    a, b, _ = sections.state_matrix()
    return from_poles(np.linalg.eigvals(a - np.outer(b, residues) / constant))


def _solve(normal: Array, right: Array) -> Array:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    scaled = normal * scale[:, None] * scale + 1e-12 * np.eye(len(normal))
    back = scale if right.ndim == 1 else scale[:, None]
    return np.asarray(back * linalg.lstsq(scaled, back * right, cond=1e-13)[0])
