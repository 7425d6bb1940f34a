"""The spectral density of unknown heights, from the records of many runs.

Whittle's likelihood (P. Whittle, Curve and periodogram smoothing, J. R. Stat. Soc. B 19 (1957)
38): in-band coefficients at different frequencies are taken as independent, so that at each
frequency the channels d (c,) are Gaussian with covariance σ² + H v Hᴴ, H (c, 2) the response to
left and right path, v the variance of their heights. Real and imaginary part count each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.effects import Parameter, RandomHeights
from wheelhop.fit.height_response import Ground

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Values = dict[str, float]

ITERATIONS = 40

LARGEST = 1.5
"""A step changes the logarithm of the density by no more than this."""

CONVERGED = 1e-3
"""The search ends when the logarithms of density and noise move by less."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """One run's record as Whittle's likelihood needs it, at the band's frequencies."""

    wave_number_rad_m: Array  #: (f,)
    per_density: float  #: variance of one coefficient per spectral density, 1/m
    square: ComplexArray  #: HᴴH (f, p, p), p paths
    cross: ComplexArray  #: Hᴴd (f, p)
    energy: Array  #: |d|² (f,)
    residual: float  #: Σ of what heights estimated before leave

    @staticmethod
    def of(ground: Ground, data: Array, residual: Array) -> Spectrum:
        """Of a run's in-band coefficients (size,), heights not taken out, and taken out.

        The record is tapered by a half sine (K. Riedel, A. Sidorenko, IEEE Trans. Signal Process.
        43 (1995) 188, eq. 1): at its ends the rear wheels meet heights the front ones did not.
        """
        band = ground.bench.band
        signal = band.from_coefficients(data.reshape(band.count, -1))
        taper = np.sqrt(2.0) * np.sin(np.pi * (np.arange(band.n) + 0.5) / band.n)
        data = band.coefficients(taper[:, None] * signal).ravel()
        wave = 2 * np.pi * band.frequency_hz / ground.speed_m_s
        response = ground.response(wave)
        adjoint = response.conj().transpose(0, 2, 1)
        record = ground.complex_of(data[:, None])
        return Spectrum(
            wave,
            ground.coefficient_variance,
            adjoint @ response,
            (adjoint @ record)[:, :, 0],
            (np.abs(record[:, :, 0]) ** 2).sum(axis=1),
            float(residual @ residual),
        )

    def at(self, kept: NDArray[np.bool_]) -> Spectrum:
        """The spectrum at some of the frequencies (f,), before heights have taken anything out."""
        energy = self.energy[kept]
        return replace(
            self,
            wave_number_rad_m=self.wave_number_rad_m[kept],
            square=self.square[kept],
            cross=self.cross[kept],
            energy=energy,
            residual=float(energy.sum()),
        )


@dataclass(frozen=True)
class Noise:
    """What a model leaves of the records: the sum of squares and its degrees of freedom, and the
    standard deviation of one coefficient that the sensors have at least."""

    rss: float
    freedom: float
    least: float

    @property
    def sigma(self) -> float:
        """Standard deviation of one in-band coefficient."""
        return max(self.least, float(np.sqrt(self.rss / max(self.freedom, 1.0))))


@dataclass(frozen=True)
class Explained:
    """What heights of some density explain of all runs: the sum of squares left, the heights'
    distance from what is believed and the logarithm of the volume they may fill (both as they
    enter the cost), and the degrees of freedom they spend. ``surprise`` (f,) is |d|² at every
    frequency of every run, in units of what is expected there."""

    rss: float
    penalty: float
    log_volume: float
    freedom: float
    surprise: Array

    def evidence(self, size: int, sigma: float) -> float:
        """Logarithm of the evidence, up to a constant of the data."""
        cost = self.rss / sigma**2 + self.penalty
        return -0.5 * cost - size * float(np.log(sigma)) + 0.5 * self.log_volume


def explained(
    effect: RandomHeights, theta: Values, spectra: Sequence[Spectrum], sigma: float
) -> Explained:
    """What heights of the effect's density explain."""
    parts = [_posterior(effect, theta, s, sigma) for s in spectra]
    rss, penalty, volume, freedom = np.sum([p.sums for p in parts], axis=0).tolist()
    surprise = np.concatenate([p.surprise for p in parts])
    return Explained(rss, penalty, volume, freedom, surprise)


def find_density(
    effect: RandomHeights,
    parameters: Sequence[Parameter],
    theta: Values,
    spectra: Sequence[Spectrum],
    noise: Noise,
) -> tuple[Values, Noise]:
    """The parameters of greatest evidence, by Fisher's scoring from `theta`, and the noise that
    heights of this density will leave of `noise`, once they are where they belong."""
    theta = dict(theta)
    beside = noise.rss - sum(spectrum.residual for spectrum in spectra)
    left = noise
    for _ in range(ITERATIONS):
        before = left.sigma
        found = explained(effect, theta, spectra, before)
        rss = min(noise.rss, beside + found.rss)
        left = replace(noise, rss=rss, freedom=noise.freedom - found.freedom)
        change = _score(effect, parameters, theta, spectra, left.sigma)
        if max(change, abs(np.log(left.sigma / before))) < CONVERGED:
            break
    return theta, left


def _score(
    effect: RandomHeights,
    parameters: Sequence[Parameter],
    theta: Values,
    spectra: Sequence[Spectrum],
    sigma: float,
) -> float:
    """Move `theta` by a step of Fisher's scoring; by how much the density's logarithm changed."""
    if not parameters:
        return 0.0
    matrix = np.diag([p.scale**-2 for p in parameters])
    slope = np.array([(p.start - theta[p.name]) / p.scale**2 for p in parameters])
    growths = []
    for spectrum in spectra:
        growth = _growth(effect, parameters, theta, spectrum.wave_number_rad_m)
        posterior = _posterior(effect, theta, spectrum, sigma)
        slope += posterior.score @ growth
        matrix += growth.T @ (posterior.information[:, None] * growth)
        growths.append(growth)
    step = np.linalg.solve(matrix, slope)
    change = float(np.abs(np.concatenate(growths) @ step).max())
    step *= LARGEST / max(change, LARGEST)
    for p, d in zip(parameters, step, strict=True):
        # A density stays positive: no more than half of what there is goes at a time.
        theta[p.name] = min(max(theta[p.name] + float(d), 0.5 * theta[p.name], p.lower), p.upper)
    return change


@dataclass(frozen=True, eq=False)
class _Posterior:
    sums: tuple[float, float, float, float]
    score: Array  # (f,) derivative of the evidence by the logarithm of the density
    information: Array  # (f,) its variance
    surprise: Array  # (f,)


def _posterior(
    effect: RandomHeights, theta: Values, spectrum: Spectrum, sigma: float
) -> _Posterior:
    density = effect.height_density(theta, spectrum.wave_number_rad_m)
    variance = spectrum.per_density * np.maximum(density, np.finfo(float).tiny)
    gain = spectrum.square * (variance / sigma**2)[:, None, None]
    paths = np.eye(gain.shape[1])
    matrix = gain + paths
    covariance = np.linalg.inv(matrix)  # of the heights, in units of what is believed
    heights = (covariance @ spectrum.cross[:, :, None])[:, :, 0] * (variance / sigma**2)[:, None]
    absorbed = paths - covariance
    distance = (np.abs(heights) ** 2).sum(axis=1) / variance
    freedom = np.trace(absorbed, axis1=1, axis2=2).real
    left = spectrum.energy - (spectrum.cross.conj() * heights).sum(axis=1).real  # dᵀR d
    penalty = float(distance.sum())
    rss = float(left.sum()) - penalty * sigma**2
    volume = -2.0 * float(np.linalg.slogdet(matrix)[1].sum())
    information = (np.abs(absorbed) ** 2).sum(axis=(1, 2))
    return _Posterior(
        (rss, penalty, volume, 2.0 * float(freedom.sum())),
        0.5 * distance - freedom,
        information,
        left,
    )


def _growth(
    effect: RandomHeights, parameters: Sequence[Parameter], theta: Values, wave_number: Array
) -> Array:
    """Derivatives (f, p) of the logarithm of the density."""
    base = effect.height_density(theta, wave_number)
    columns = []
    for p in parameters:
        step = 1e-4 * abs(theta[p.name])
        other = effect.height_density({**theta, p.name: theta[p.name] + step}, wave_number)
        columns.append(np.log(other / base) / step)
    return np.stack(columns, axis=1)
