"""Where the poles begin: relocated from anywhere in the band until they stay (vector fitting)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.identify.gram import Stack, projected
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
    """The best of some relocations from the better beginning, as a trial of `problem`.

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
    for part, weight, (basis, phi, _) in zip(
        stack.parts, stack.weights, point.regressors, strict=True
    ):
        sigma = np.hstack([sections.basis(1j * part.omega), np.ones((len(part.omega), 1))])
        x = (part.outputs * weight[:, None])[..., None] * sigma[:, None, :]
        rows = projected(x.reshape(*x.shape[:2], -1), basis)
        across += phi.T @ rows
        for i in range(outputs):
            of_one = rows[:, i * width : (i + 1) * width]
            own[i] += of_one.T @ of_one
        mean += sigma.real.sum(axis=0)
    taken = across.T @ _solve(phi_phi, across)
    schur = np.zeros((width, width))
    for i in range(outputs):
        at = slice(i * width, (i + 1) * width)
        schur += (own[i] - taken[at, at]) / max(own[i, -1, -1], 1e-300)
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
