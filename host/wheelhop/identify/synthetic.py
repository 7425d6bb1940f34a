"""Runs made from the transfer matrix printed in the thesis: a known truth of that kind."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wheelhop.identify import published
from wheelhop.identify.sections import Sections
from wheelhop.identify.spectra import Spectra, spectra, through
from wheelhop.identify.statespace import StateSpace, of_fractions
from wheelhop.identify.structure import Structure

Array = NDArray[np.float64]

RATE_HZ = 100.0
BAND_HZ = (0.5, 30.0)


def over_fractions(numerators: Array, sections: Sections) -> Array:
    """Coefficients (…, order) of numerators (…, order), highest power first, in the fractions of
    these sections."""
    n = sections.order
    m = n // 2
    denominator = sections.denominator()
    columns = np.zeros((n, n))
    for k in range(m):
        rest = np.polydiv(
            denominator, [1.0, 2 * sections.zeta[k] * sections.omega[k], sections.omega[k] ** 2]
        )[0]
        padded = np.concatenate([np.zeros(n - len(rest)), rest])
        columns[:, k] = sections.omega[k] ** 2 * padded
        columns[:, m + k] = sections.omega[k] * np.roll(padded, -1)
    scale = np.abs(columns).max(axis=1)
    out = np.linalg.solve(columns / scale[:, None], (numerators / scale).reshape(-1, n).T)
    return np.asarray(out.T.reshape(numerators.shape))


def thesis_matrix() -> StateSpace:
    """H(s) of appendix D.2: the printed numerators over the poles of Table 5.2."""
    place = Structure("symmetric").elements((0, 1, 2, 3), (0, 1, 2, 3))
    theta = over_fractions(published.D2_NUMERATORS, published.TABLE_5_2)[place]
    return of_fractions(published.TABLE_5_2, theta)


def thesis_runs(
    noise: float = 0.0, *, runs: int = 18, samples: int = 1024, seed: int = 1
) -> Spectra:
    """Spectra of `records` of `thesis_matrix`."""
    made = records(thesis_matrix(), noise, runs=runs, samples=samples, seed=seed)
    return spectra(*made, RATE_HZ, BAND_HZ)


def records(
    matrix: StateSpace,
    noise: float = 0.0,
    *,
    runs: int = 18,
    samples: int = 1024,
    rate_hz: float = RATE_HZ,
    seed: int = 1,
) -> tuple[Array, Array]:
    """Random motion (runs, samples, m) through `matrix`, in motion before a run begins, and the
    answer (runs, samples, n).

    `noise` is the rms of white noise on every output over the rms of the outputs.
    """
    rng = np.random.default_rng(seed)
    inputs = rng.standard_normal((runs, 3 * samples, matrix.b.shape[1]))
    # Periodic in three times the run: the answer is the spectrum times H, and the run cut from the
    # middle has a past and a future that do not repeat in it.
    s = 2j * np.pi * np.fft.rfftfreq(3 * samples, 1 / rate_hz)
    moved = through(matrix(s), np.asarray(np.fft.rfft(inputs, axis=1)))
    outputs = np.fft.irfft(moved, 3 * samples, axis=1)[:, samples : 2 * samples]
    inputs = inputs[:, samples : 2 * samples]
    return inputs, outputs + noise * outputs.std() * rng.standard_normal(outputs.shape)
