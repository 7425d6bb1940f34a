"""What a sampled record cannot tell: motion above half the sample rate, folded into it.

A wheel that meets sharp edges moves above half the sample rate, too. The logger's means
damp that, and sampling folds the rest: what moved at f_s − f is recorded as moving at f.
Where the record is only compared with a model, the model's record is folded in the same way. Where
it drives a model, the model is driven by motion that never was, and twice integrated a line of the
hundredth harmonic that comes down to half a hertz is larger than the road.

Nobody knows the folded motion, but its size can be told: spectra of wheels fall, or stay, as they
do below half the sample rate.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PARTS = 4
"""The upper octave of the record's spectrum is averaged over so many parts before a power of the
frequency is laid through it: lines of a periodic road stand in some and not in others."""

STEEPEST = -4.0
"""An impact's spectrum is flat, that of a jump of the acceleration falls with the second power, in
power; what falls faster than the fourth is no wheel's, but the end of what was there."""

SURE = 1e-12
"""(m/s²)²: powers are not taken for less."""


def folded_power(
    record: Array,
    rate_hz: float,
    recorded: Callable[[Array], NDArray[np.number]],
    noise_rms: float | Array,
    frequency_hz: Array,
) -> Array:
    """How much of a record's power is motion from above half the sample rate (f, c), (m/s²)², as
    white noise of that variance would have it at `frequency_hz` (f,).

    ``record`` (n, c) is sampled at ``rate_hz``, with sensor noise of ``noise_rms``, of all or of
    each (c,), in its unit; ``recorded`` is what the recorder made of sines before, (f,) of all or
    (f, c) of each. The spectrum of the upper octave, freed of the noise and of what the
    recorder took, is continued as a power of the frequency up to one and a half times the rate. It
    holds what is folded near half the rate, too: where spectra fall the answer is too high, by less
    than two.
    """
    window = np.hanning(len(record))[:, None]
    spectrum = np.fft.rfft((record - record.mean(axis=0)) * window, axis=0)
    power = np.abs(spectrum) ** 2 / np.sum(window**2)
    frequency = np.fft.rfftfreq(len(record), 1.0 / rate_hz)
    edges = np.geomspace(rate_hz / 4.0, rate_hz / 2.0, PARTS + 1)
    levels = np.empty((PARTS, record.shape[1]))
    for i in range(PARTS):
        part = (frequency >= edges[i]) & (frequency < edges[i + 1])
        levels[i] = power[part].mean(axis=0) - noise_rms**2
    middle = np.sqrt(edges[:-1] * edges[1:])

    def kept(f: Array) -> Array:
        return np.asarray(np.abs(recorded(f)).reshape(len(f), -1) ** 2)

    levels = np.maximum(levels / kept(middle), SURE)
    slope = np.polyfit(np.log(middle), np.log(levels), 1)[0].clip(STEEPEST, 0.0)
    level = levels.mean(axis=0)

    def above(f: Array) -> Array:
        trend = level * (f[:, None] / middle.mean()) ** slope
        return np.asarray(trend * kept(f))

    return above(rate_hz - frequency_hz) + above(rate_hz + frequency_hz)


def sample_of(power: Array, n: int, seed: int) -> Array:
    """One record (n, c) such as noise of this power (n // 2 + 1, c) may give, white where it is
    constant; the same for the same seed."""
    rng = np.random.default_rng(seed)
    parts = rng.normal(size=(2, *power.shape))
    spectrum = (parts[0] + 1j * parts[1]) * np.sqrt(power * n / 2.0)
    spectrum[0] = 0.0
    return np.asarray(np.fft.irfft(spectrum, n, axis=0))
