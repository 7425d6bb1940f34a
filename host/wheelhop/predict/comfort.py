"""Ride comfort: vertical acceleration as a person feels it, after ISO 2631-1:1997."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

Array = NDArray[np.float64]

# ISO 2631-1:1997, table A.1, weighting Wk: corners in Hz, and resonant quality factors.
F1_HZ, F2_HZ = 0.4, 100.0
F3_HZ, F4_HZ, Q4 = 12.5, 12.5, 0.63
F5_HZ, Q5, F6_HZ, Q6 = 2.37, 0.91, 3.35, 0.91
BUTTERWORTH_Q = 1 / np.sqrt(2)


@dataclass(frozen=True)
class Comfort:
    """Weighted root mean square, m/s², and vibration dose value, m/s^1.75."""

    rms_m_s2: float
    vdv_m_s1_75: float


def wk(frequency_hz: ArrayLike) -> NDArray[np.complex128]:
    """The weighting Wk for vertical vibration of a seated person, exp(+iωt).

    ISO 2631-1:1997, annex A: high pass and low pass (equations A.1 and A.2), transition from
    acceleration to velocity (A.3), upward step (A.4). Frequencies must be above 0.
    """
    s = np.asarray(1j * np.asarray(frequency_hz, dtype=np.float64), dtype=np.complex128)
    high_pass = s**2 / _second_order(s, F1_HZ, BUTTERWORTH_Q) / F1_HZ**2
    low_pass = 1 / _second_order(s, F2_HZ, BUTTERWORTH_Q)
    transition = (1 + s / F3_HZ) / _second_order(s, F4_HZ, Q4)
    step = _second_order(s, F5_HZ, Q5) / _second_order(s, F6_HZ, Q6) * (F5_HZ / F6_HZ) ** 2
    return np.asarray(high_pass * low_pass * transition * step)


def weighted(acceleration: Array, rate_hz: float, below_hz: float = np.inf) -> Array:
    """Acceleration (n,), m/s², after Wk; what lies at or above `below_hz` is left out.

    Before and after the record there is silence for as long again, so that nothing of the end
    comes back at the beginning.
    """
    n = fft.next_fast_len(2 * len(acceleration), real=True)
    spectrum = fft.rfft(acceleration, n)
    return np.asarray(fft.irfft(_gain(n, rate_hz, below_hz) * spectrum, n)[: len(acceleration)])


@lru_cache(maxsize=32)
def _gain(n: int, rate_hz: float, below_hz: float) -> NDArray[np.complex128]:
    """Wk at the frequencies of a transform of n samples: many rides ask for the same."""
    frequency = fft.rfftfreq(n, 1.0 / rate_hz)
    gain = np.zeros(len(frequency), dtype=np.complex128)
    inside = (frequency > 0.0) & (frequency < below_hz)
    gain[inside] = wk(frequency[inside])
    return gain


def comfort(felt: Array, rate_hz: float) -> Comfort:
    """Figures of a weighted acceleration (n,): equations 1 and 5 of the standard."""
    square = felt * felt
    return Comfort(float(np.sqrt(np.mean(square))), float((square @ square / rate_hz) ** 0.25))


def _second_order(s: NDArray[np.complex128], corner_hz: float, q: float) -> NDArray[np.complex128]:
    """1 + s/(Q ω) + (s/ω)², frequencies in Hz."""
    return np.asarray(1 + s / (q * corner_hz) + (s / corner_hz) ** 2)
