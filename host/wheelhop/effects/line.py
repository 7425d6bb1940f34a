"""Lines in a spectrum: where they stand, and how their phase wanders."""

from __future__ import annotations

import numpy as np
from scipy import fft, ndimage

from wheelhop.effects.base import Array

WINDOW_S = 0.8
"""The phase of a line is read in windows of this length, a quarter of it apart."""


def strength(time_s: Array, residual: Array, frequency_hz: Array) -> Array:
    """How far a line of each frequency (f,) would stand out of a residual (n, c): ln(1 + P), with P
    its power over the mean of noise, added up over the channels."""
    n = fft.next_fast_len(len(time_s) * 8)
    rate = (len(time_s) - 1) / (time_s[-1] - time_s[0])
    spectrum = fft.rfft(residual * np.hanning(len(time_s))[:, None], n, axis=0)
    power = (np.abs(spectrum) ** 2).sum(axis=1)
    # The median of a sum of c exponentials is close to c − 1/3 of their means.
    level = np.median(power) / (residual.shape[1] - 1.0 / 3.0)
    found = np.interp(frequency_hz, fft.rfftfreq(n, 1.0 / rate), power, right=0.0)
    return np.asarray(np.log1p(found / level))


def shared(strengths: Array, step: float, spread: float, reach: float) -> Array:
    """Strength of a line that all runs share, each at a frequency of its own near it: the sum over
    the runs (r, f) of the best within reach, what it is away by charged as its prior says.

    Frequencies are equally spaced in their logarithm, by `step`; `spread` is one standard
    deviation of that, and `reach` how many of these are looked at.
    """
    most = int(reach * spread / step)
    away = np.arange(-most, most + 1) * step / spread
    charge = -0.5 * away**2
    shape = np.ones(len(away), dtype=bool)
    best = [ndimage.grey_dilation(s, footprint=shape, structure=charge) for s in strengths]
    return np.asarray(np.sum(best, axis=0))


def phase_along(time_s: Array, residual: Array, frequency_hz: float) -> tuple[Array, Array, Array]:
    """Times (w,), s, the phase (w,), rad, of a line near this frequency over one that keeps it,
    and the phase's standard deviation (w,) as the noise beside the line makes it.

    In every window the line is a vector over the channels; what it is along the strongest
    direction of all windows counts.
    """
    centres = np.arange(time_s[0] + WINDOW_S / 2, time_s[-1] - WINDOW_S / 2, WINDOW_S / 4)
    away = (time_s - centres[:, None]) / WINDOW_S
    weight = np.where(np.abs(away) < 0.5, np.cos(np.pi * away) ** 2, 0.0)
    turned = np.exp(-2j * np.pi * frequency_hz * time_s)[:, None] * residual
    lines = weight @ turned
    along = lines @ np.linalg.svd(lines, full_matrices=False)[2][0].conj()
    # Of white noise of this power per channel, the real part in a window has this deviation.
    noise = np.sqrt(0.5 * (weight**2).sum(axis=1) * np.mean(residual**2))
    return centres, np.unwrap(np.angle(along)), noise / np.maximum(np.abs(along), 1e-300)
