"""Lines of a run to which the body does not answer: what sampling folds into the axles' records.

A wheel on sharp edges moves above half the sample rate, too, and its record shows that at lines
below it, at which neither the wheel nor the body moves. On a periodic road folded motion stands in
single lines of hundreds of times the sensors' noise, and a fit bends H to them, or spends poles on
them. Which lines these are is told by what H leaves: what leaves more than noise would is weighed
by what it leaves (P. Huber, Robust Statistics, 1981, chapter 7, for lines instead of numbers).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from wheelhop.identify.gram import projected, transient_basis
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.sections import Sections
from wheelhop.identify.spectra import Spectra, through

Array = NDArray[np.float64]

RARE = 0.01
"""Share of campaigns in which noise alone has any such line."""


def narrow(sections: Sections, duration_s: float) -> NDArray[np.bool_]:
    """Which sections (m,) are narrower than a line of a run of this length: their free decay can
    stand for any motion at that line, whatever the axles do."""
    out: NDArray[np.bool_] = np.abs(sections.zeta) * sections.omega * duration_s < np.pi
    return out


def beyond_chance(
    h: TransferMatrix, runs: Sequence[Spectra], weights: Sequence[Array], output_weight: Array
) -> list[Array]:
    """How much more than noise may each line of each run leaves, as a ratio of powers: for each
    part (r, k), 1 where it is no more.

    `weights` (k,) for each part and `output_weight` (n,) make what noise leaves alike in all
    numbers. Its level is that of the median line; the outputs share the inputs' noise.
    """
    powers = []
    for part, weight in zip(runs, weights, strict=True):
        response = h(1j * part.omega)
        rest = (part.outputs - through(response, part.inputs)) * np.sqrt(output_weight)
        wide = ~narrow(h.sections, 2 * np.pi / float(part.omega[1] - part.omega[0]))
        decays = replace(h.sections, omega=h.sections.omega[wide], zeta=h.sections.zeta[wide])
        rows = projected(rest * weight[:, None], transient_basis(part.omega, decays, weight))
        rows = rows.reshape(len(part.runs), 2, len(part.omega), -1)
        white = np.linalg.inv(_correlation(response))
        left = rows[:, 0] + 1j * rows[:, 1]
        powers.append(np.einsum("rki,kij,rkj->rk", left.conj(), white, left, optimize=True).real)
    freedom = 2 * len(output_weight)
    every = np.concatenate([p.ravel() for p in powers])
    level = max(float(np.median(every)), 1e-300) / chdtri(freedom, 0.5)
    most = level * chdtri(freedom, RARE / len(every))
    return [np.maximum(1.0, power / most) for power in powers]


def _correlation(response: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """1 + H Hᴴ over its mean diagonal term (k, n, n)."""
    n = response.shape[1]
    both = np.eye(n) + response @ response.conj().swapaxes(1, 2)
    return np.asarray(both / (np.trace(both, axis1=1, axis2=2).real / n)[:, None, None])


def apart(runs: Sequence[Spectra], excess: Sequence[Array]) -> tuple[list[Spectra], list[Array]]:
    """Each run that has such lines as a part of its own, and the `excess` (k,) of every part."""
    parts, each = [], []
    for part, power in zip(runs, excess, strict=True):
        has = (power > 1.0).any(axis=1)
        if not has.all():
            parts.append(part.only(np.flatnonzero(~has)))
            each.append(np.ones(len(part.omega)))
        for i in np.flatnonzero(has):
            parts.append(part.only(np.array([i])))
            each.append(power[i])
    return parts, each
