"""Sine fits by least squares: frequency known (three parameters) or not (four).

IEEE Std 1057, annex on sine-wave fitting algorithms. The model here is

    y(t) = offset + Re Σₖ phasorₖ · exp(i 2π k f (t − t₀)),   k = 1 … harmonics

with t₀ the middle of the record, so that phase and frequency are not correlated. Harmonics beyond
the first are there for shakers, whose distortion would leak into the first.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ITERATIONS = 8  # of the four-parameter fit; it converges quadratically
CONVERGED = 1e-5  # cycles over the record; the next change would be far smaller


@dataclass(frozen=True)
class Sine:
    """What a fit found: (harmonics,) complex `phasors` at `middle_s`, in the unit of the values.

    `residual_rms` counts degrees of freedom. `count` is the number of samples.
    """

    frequency_hz: float
    middle_s: float
    offset: float
    phasors: NDArray[np.complex128]
    residual_rms: float
    count: int

    @property
    def amplitude(self) -> float:
        """Zero-to-peak amplitude of the fundamental."""
        return float(abs(self.phasors[0]))

    def phasor_at(self, time_s: float) -> complex:
        """The fundamental's phasor with its phase as it is at `time_s`."""
        turn = np.exp(2j * np.pi * self.frequency_hz * (time_s - self.middle_s))
        return complex(self.phasors[0] * turn)


def fit_known(time_s: Array, values: Array, frequency_hz: float, harmonics: int = 1) -> Sine:
    """Fit offset and phasors at a known frequency to (n,) `values`, NaN left out."""
    there = ~np.isnan(values)
    time_s, values = time_s[there], values[there]
    middle = float(time_s[0] + time_s[-1]) / 2
    columns = _columns(time_s - middle, frequency_hz, harmonics)
    found = _solve(columns, values)
    rest = values - columns @ found
    freedom = max(1, len(values) - columns.shape[1])
    return Sine(
        frequency_hz,
        middle,
        float(found[0]),
        found[1::2] - 1j * found[2::2],
        float(np.sqrt(rest @ rest / freedom)),
        len(values),
    )


def fit_unknown(time_s: Array, values: Array, start_hz: float, harmonics: int = 1) -> Sine:
    """Fit the frequency, too, from a start within about half a cycle over the record.

    Each iteration solves for a small change of frequency beside the other parameters, linearised
    at the phasor of the iteration before (IEEE Std 1057, four-parameter fit).
    """
    there = ~np.isnan(values)
    time_s, values = time_s[there], values[there]
    shifted = time_s - (time_s[0] + time_s[-1]) / 2
    limit = 1 / (shifted[-1] - shifted[0])
    frequency = start_hz
    phasor = fit_known(time_s, values, frequency, harmonics).phasors[0]
    for _ in range(ITERATIONS):
        columns = _columns(shifted, frequency, harmonics)
        slope = -2 * np.pi * shifted * (phasor.real * columns[:, 2] + phasor.imag * columns[:, 1])
        found = _solve(np.column_stack([columns, slope]), values)
        phasor = found[1] - 1j * found[2]
        change = float(np.clip(found[-1], -limit, limit))
        frequency = max(frequency + change, limit / 10)
        if abs(change) < CONVERGED * limit:
            break
    return fit_known(time_s, values, frequency, harmonics)


def strongest_frequency_hz(values: Array, rate_hz: float) -> float:
    """The frequency of the largest peak of a Hann-windowed spectrum, to a small part of a line."""
    values = np.nan_to_num(values - np.nanmean(values)) * np.hanning(len(values))
    size = 8 * len(values)
    power = np.abs(np.fft.rfft(values, size))
    return float(np.argmax(power[1:]) + 1) * rate_hz / size


def _columns(time_s: Array, frequency_hz: float, harmonics: int) -> Array:
    """(n, 1 + 2 harmonics): 1, cos, sin, cos 2, sin 2, …"""
    columns = np.empty((len(time_s), 1 + 2 * harmonics))
    columns[:, 0] = 1
    turn = np.exp(2j * np.pi * frequency_hz * time_s)
    power = turn
    for order in range(harmonics):
        columns[:, 1 + 2 * order], columns[:, 2 + 2 * order] = power.real, power.imag
        power = power * turn
    return columns


def _solve(columns: Array, values: Array) -> Array:
    """Least squares by normal equations; the columns are nearly orthogonal but for their scale."""
    scale = np.maximum(np.sqrt((columns**2).sum(axis=0)), 1e-30)
    scaled = columns / scale
    normal = scaled.T @ scaled
    normal.flat[:: len(normal) + 1] += 1e-13  # a column that is all zero must not stop it
    solution = np.linalg.solve(normal, scaled.T @ values)
    return np.asarray(solution / scale)
