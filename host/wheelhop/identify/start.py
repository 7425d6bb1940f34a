"""Where the poles begin: relocated from anywhere in the band until they stay (vector fitting)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.identify.gram import Stack, gram, projected
from wheelhop.identify.sections import ComplexArray, Sections, from_poles

Array = NDArray[np.float64]
RELOCATIONS = 8
FIRST_ZETA = 0.3


def spread(order: int, band: tuple[float, float]) -> Sections:
    """Sections evenly spread over the logarithm of the band, rad/s."""
    low, high = band
    m = order // 2
    omega = np.geomspace(1.5 * low, 0.9 * high, m) if m > 1 else np.array([np.sqrt(low * high)])
    rate = float(np.sqrt(low * high)) if order % 2 else None
    return Sections(omega[:m], np.full(m, FIRST_ZETA), rate)


def relocated(stack: Stack, sections: Sections, factors: Sequence[ComplexArray]) -> list[Sections]:
    """Sections after each of some relocations.

    With σ(s) a scalar that has the present poles, σ X = (σ H) Y has σ H over the same poles too, a
    linear problem in its residues and σ's; the zeros of σ are the next poles. σ is kept off zero by
    its mean over the band being 1 (B. Gustavsen, IEEE Trans. Power Delivery 21 (2006) 1587, eq. 8).
    The rows for σ alone are kept, those of σ H are eliminated output by output (D. Deschrijver et
    al., IEEE Microw. Wireless Compon. Lett. 18 (2008) 383).
    """
    out = []
    for _ in range(RELOCATIONS):
        sections = _relocate(stack, sections, factors)
        out.append(sections)
    return out


def _relocate(stack: Stack, sections: Sections, factors: Sequence[ComplexArray]) -> Sections:
    order = sections.order
    schur = np.zeros((order + 1, order + 1))
    mean = np.zeros(order + 1)
    regressors = stack.regressors(sections, factors)
    phi_phi = gram(regressors).phi_phi
    parts = list(zip(stack.parts, stack.weights, regressors, strict=True))
    for i in range(stack.outputs):
        own = np.zeros((order + 1, order + 1))
        across = np.zeros((len(phi_phi), order + 1))
        for part, weight, (basis, phi, _) in parts:
            sigma = np.hstack([sections.basis(1j * part.omega), np.ones((len(part.omega), 1))])
            x = part.outputs[:, :, i, None] * weight[:, None] * sigma
            rows = projected(x, basis)
            own += rows.T @ rows
            across += phi.T @ rows
            if i == 0:
                mean += sigma.real.sum(axis=0)
        schur += (own - across.T @ _solve(phi_phi, across)) / max(own[-1, -1], 1e-300)
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
