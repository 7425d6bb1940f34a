"""How rough a road is: unevenness and waviness after ISO 8608, from its profile."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wheelhop.track.track import Array

SEGMENTS = 8
"""A profile is divided into so many, half of each shared with the next."""
LOST_LINES = 3
"""Of a segment's spectrum, at its lower end: window and trend spoil them."""
HIGHEST = 0.8
"""Of the Nyquist wave number: above, sampling spoils the spectrum."""
SHORTEST_M = 0.1
"""Shorter waves are texture, which a tyre swallows; ISO 8608 ends here, too."""
PER_OCTAVE = 3
CLASSES = "ABCDEFGH"
CLASS_A_M3, CLASS_RATIO = 1e-6, 4.0
"""Geometric mean of class A at 1 rad/m, and the step from class to class (ISO 8608:2016)."""


@dataclass(frozen=True)
class Roughness:
    """S(Ω) = C (Ω/Ω₀)^-w with Ω₀ = 1 rad/m, one-sided (thesis equation 4.7).

    `unevenness_m3` is C, m³ per rad, `waviness` w; both are fitted between the wave numbers of
    `band_rad_m`. `rms_m` is that of the heights about a straight line.
    """

    unevenness_m3: float
    waviness: float
    band_rad_m: tuple[float, float]
    rms_m: float

    @property
    def road_class(self) -> str:
        """A to H after ISO 8608, by the unevenness at 1 rad/m."""
        steps = np.log(self.unevenness_m3 / CLASS_A_M3) / np.log(CLASS_RATIO)
        return CLASSES[int(np.clip(round(float(steps)), 0, len(CLASSES) - 1))]


def density(height: Array, step_m: float) -> tuple[Array, Array]:
    """Wave numbers Ω (f,), rad/m, and the one-sided power spectral density S (f,), m³ per rad, of
    heights (n, k), m: the mean over k paths, by Welch's method with Hann windows."""
    from scipy.signal import welch  # takes long to import

    size = max(2 * len(height) // (SEGMENTS + 1), 16)
    cycles_m, power = welch(
        height, 1.0 / step_m, nperseg=size, detrend="linear", axis=0, return_onesided=True
    )
    return 2 * np.pi * cycles_m, np.asarray(power.mean(axis=1) / (2 * np.pi))


def roughness(height: Array, step_m: float) -> Roughness:
    """Fit a straight line to log S over log Ω of heights (n, k), m, at equal steps.

    The spectrum is first averaged over third-octaves, so that each octave counts alike (ISO 8608,
    annex B, smooths it for the same reason). Raises ValueError for fewer than 64 stations, for a
    piece that has too few waves, and for ground without unevenness.
    """
    if len(height) < 64:
        raise ValueError(f"{len(height)} stations; a spectrum takes 64 or more")
    wave, power = density(height, step_m)
    low, high = wave[LOST_LINES], min(HIGHEST * np.pi / step_m, 2 * np.pi / SHORTEST_M)
    inside = (wave >= low) & (wave <= high)
    octave = np.floor(PER_OCTAVE * np.log2(wave[inside] / low)).astype(int)
    count = np.maximum(np.bincount(octave), 1)
    there = np.bincount(octave) > 0
    # A power law's mean over a band is a power law's value where the mean of the logarithms is.
    x = (np.bincount(octave, np.log(wave[inside])) / count)[there]
    mean = (np.bincount(octave, power[inside] * wave[inside]) / count)[there]
    if len(mean) < 2:
        raise ValueError(f"{len(height)} stations {step_m:g} m apart: too short for a spectrum")
    if not (mean > 0.0).all():
        raise ValueError("has no unevenness of which there is a spectrum")
    y = np.log(mean) - x
    slope, level = np.polyfit(x, y, 1)
    station = np.arange(len(height))
    flat = height - np.polynomial.polynomial.polyval(
        station, np.polynomial.polynomial.polyfit(station, height, 1)
    ).T.reshape(height.shape)
    rms = float(np.sqrt(np.mean(flat**2)))
    return Roughness(float(np.exp(level)), float(-slope), (float(low), float(high)), rms)
