"""Heights nobody knows, on top of the track: a Fourier series along the way of each side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Run
from wheelhop.simulate.model import Model
from wheelhop.track.table import periodic_cubic

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

POINTS_PER_WAVE = 16
"""Of the table on the shortest wave: cubic interpolation is then good to 1e-4 of it."""


def slowness(model: Model, run: Run) -> float:
    """The nominal speed of a run over its speed in a model."""
    speed = model.speed_m_s(run.id, run.speed_m_s)
    return float(np.divide(run.speed_m_s, speed))  # infinite where a fit runs away


@dataclass(frozen=True)
class HeightSeries:
    """h(u) = Re Σ a_k exp(i κ_k u), κ_k = 2π k / length, k = 1 … count.

    u is the way since the start of the run times its `slowness`: the way at the nominal speed. So
    a fit that corrects start or speed takes the heights along with the record that showed them,
    and only the known track moves below the wheels. Front and rear wheels of a side meet the same
    heights. ``coefficients`` are (2, count), m: left and right. With E|a_k|² = 2 S(κ_k) Δκ the
    heights have the spectral density S, at the nominal speed.
    """

    length_m: float
    count: int

    @property
    def step_rad_m(self) -> float:
        """Distance Δκ of the wave numbers."""
        return 2 * np.pi / self.length_m

    @property
    def wave_number_rad_m(self) -> Array:
        """The wave numbers κ (count,)."""
        return np.asarray(self.step_rad_m * np.arange(1, self.count + 1))

    def drawn(self, density_m3: Array, rng: np.random.Generator) -> ComplexArray:
        """Coefficients of heights that have this spectral density at the wave numbers."""
        parts = rng.normal(size=(2, self.count, 2)) @ np.array([1.0, 1.0j])
        return np.asarray(parts * np.sqrt(density_m3 * self.step_rad_m))

    def at(self, coefficients: ComplexArray, way_m: Array) -> tuple[Array, Array]:
        """Heights (T, 4), m, under the four wheels at their ways (T, 4), m, and their slopes."""
        points = POINTS_PER_WAVE * self.count
        lines = np.zeros((2, points // 2 + 1), dtype=np.complex128)
        lines[:, 1 : self.count + 1] = coefficients * (points / 2)
        step = self.length_m / points
        slopes = lines * (1j * self.step_rad_m * step * np.arange(lines.shape[1]))
        table, rise = np.fft.irfft(lines, points), np.fft.irfft(slopes, points)
        height, slope = np.empty_like(way_m), np.empty_like(way_m)
        for side in (0, 1):
            place = (way_m[:, side::2] / step).ravel()
            found = periodic_cubic(table[side], rise[side], place)
            height[:, side::2], slope[:, side::2] = (part.reshape(-1, 2) for part in found)
        return height, slope / step
