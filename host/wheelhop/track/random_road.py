"""A random road: the spectrum of ISO 8608, wheel paths coherent as on an isotropic surface."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from wheelhop.track.track import Array, Track

_PERIOD_M = 1024.0  # the road repeats after this; its spectral lines are 1/1024 cycles/m apart
_WAVES_PER_M = (0.01, 10.0)  # the band that carries unevenness: waves from 100 m to 0.1 m
_POINTS = 1 << 17  # of the table: 12.8 on the shortest wave


@dataclass(frozen=True)
class RandomRoad(Track):
    """A realisation of the one-sided power spectral density S(Ω) = C (Ω/Ω₀)^-w, Ω₀ = 1 rad/m.

    S is per unit of *angular* spatial frequency (ISO 8608:2016, Gd(Ω)): the variance of z is the
    integral of S dΩ over Ω > 0, here from 2π·0.01 to 2π·10 rad/m. C = 1e-6, 4e-6, 16e-6 m³ and
    w = 2 are the geometric means of the standard's classes A, B, C.

    The standard describes a single path. Between paths the surface is taken as homogeneous and
    isotropic (Dodds & Robson, J. Sound Vib. 31, 1973): its two-dimensional spectrum is that of
    which S is the marginal, ∝ (Ω² + κ²)^-(w+1)/2 with κ the wave number across, so that paths d
    apart have the cross spectrum S(Ω) g(Ωd), g(u) = 2^(1-w/2)/Γ(w/2) u^(w/2) K_{w/2}(u), and the
    coherence g². Real roads are somewhat less alike left and right at long waves.

    Each spectral line is one plane wave: amplitude √(2 S ΔΩ), random phase, and a random wave
    number across drawn from that spectrum at its Ω, which is Student's t with w degrees of
    freedom in √w κ/Ω. The same seed gives the same road, everywhere and for every C.
    """

    unevenness_m3: float
    waviness: float
    seed: float  # a whole number

    @property
    def period_m(self) -> float:
        """Far longer than a run."""
        return _PERIOD_M

    def _elevation(self, x: Array, y: Array) -> Array:
        x, y = np.broadcast_arrays(x, y)
        z = np.empty(x.shape)
        for path in np.unique(y):
            on_path = y == path
            z[on_path] = _interpolate(*_table(self, float(path)), x[on_path])
        return z


@lru_cache(maxsize=16)
def _table(road: RandomRoad, y: float) -> tuple[Array, Array]:
    """z and (dz/dx)·Δx on the path y, at x = 0, Δx, … over one period."""
    first, last = (math.ceil(waves * _PERIOD_M) for waves in _WAVES_PER_M)
    step = 2 * np.pi / _PERIOD_M
    along = step * np.arange(first, last + 1)
    rng = np.random.default_rng(int(road.seed))
    phase = rng.uniform(0.0, 2 * np.pi, len(along))
    across = along * rng.standard_t(road.waviness, len(along)) / np.sqrt(road.waviness)
    amplitude = np.sqrt(2 * road.unevenness_m3 * along**-road.waviness * step)
    lines = np.zeros(_POINTS // 2 + 1, dtype=np.complex128)
    lines[first : last + 1] = amplitude / 2 * _POINTS * np.exp(1j * (phase + across * y))
    turn = 2j * np.pi * np.arange(len(lines)) / _POINTS
    return np.fft.irfft(lines, _POINTS), np.fft.irfft(turn * lines, _POINTS)


def _interpolate(z: Array, rise: Array, x: Array) -> Array:
    """Cubic Hermite interpolation, within 2e-4 of the amplitude of the shortest wave."""
    place = x * (_POINTS / _PERIOD_M)
    cell = np.floor(place)
    t = place - cell
    here = cell.astype(np.int64) % _POINTS
    there = (here + 1) % _POINTS
    z0, z1, d0, d1 = z[here], z[there], rise[here], rise[there]
    step = z1 - z0
    return z0 + t * (d0 + t * (3 * step - 2 * d0 - d1 + t * (d0 + d1 - 2 * step)))
