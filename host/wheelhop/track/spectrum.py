"""A road known by its spectrum alone: what its wheels meet, as cross spectra.

Left and right are paths of one isotropic surface (see :class:`RandomRoad`); a rear wheel meets what
the front one of its side met a wheelbase earlier. A wheel rounds off crests and bridges troughs,
which is not linear: what that leaves of each octave's third is found from roads that are drawn.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from wheelhop.track.random_road import RandomRoad
from wheelhop.track.track import Array
from wheelhop.track.wheel import Wheel

ROADS, ROAD_M, STEP_M, PIECE = 4, 400.0, 0.02, 1024
"""Of what is drawn: roads, their length, their stations, and the stations of a piece of Welch's."""
PER_OCTAVE = 3
FIRST_LINE = 3
"""Of a piece's lines: below, windows spoil them, and such long waves pass below every wheel."""


@dataclass(frozen=True)
class RoadSpectrum:
    """S(Ω) = C (Ω/Ω₀)^-w, Ω₀ = 1 rad/m, one-sided, per rad/m (thesis 4.7)."""

    unevenness_m3: float
    waviness: float

    def density(self, wave_rad_m: Array) -> Array:
        """S (f,), m³ per rad, at wave numbers Ω (f,), rad/m."""
        return np.asarray(self.unevenness_m3 * wave_rad_m**-self.waviness)

    def alike(self, wave_rad_m: Array, apart_m: float) -> Array:
        """g (f,): the cross spectrum of two paths over S; its square is their coherence."""
        from scipy.special import gamma, kv  # takes long to import

        u, order = wave_rad_m * abs(apart_m), self.waviness / 2
        with np.errstate(invalid="ignore", over="ignore"):
            g = 2.0 ** (1.0 - order) / gamma(order) * u**order * kv(order, u)
        return np.where(u > 0.0, np.nan_to_num(g), 1.0)

    def under_wheels(
        self, wave_rad_m: Array, apart_m: float, radius_m: float
    ) -> tuple[Array, Array]:
        """S (f,) of the path of the centre of a rigid wheel, and the cross spectrum (f,) of the
        left and the right one's over it."""
        line, ground, rolled = _drawn(self, apart_m, radius_m)
        third = np.floor(PER_OCTAVE * np.log2(line / line[0])).astype(int)
        count = np.bincount(third)
        there = count > 0
        middle = (np.bincount(third, np.log(line))[there]) / count[there]

        def mean(values: Array) -> Array:
            return np.asarray(np.bincount(third, values)[there])

        # Both are of the same roads, so that how these scatter falls out.
        gain = mean(rolled[0]) / mean(ground[0])
        more = mean(rolled[1]) / mean(rolled[0]) - mean(ground[1]) / mean(ground[0])
        at = np.log(wave_rad_m)
        left_right = self.alike(wave_rad_m, apart_m) + np.interp(at, middle, more, left=0.0)
        return (
            self.density(wave_rad_m) * np.interp(at, middle, gain, left=1.0),
            np.clip(left_right, -1.0, 1.0),
        )


@lru_cache(maxsize=16)
def _drawn(
    spectrum: RoadSpectrum, apart_m: float, radius_m: float
) -> tuple[Array, tuple[Array, Array], tuple[Array, Array]]:
    """Wave numbers, and of ground and wheels the mean density of both sides and across."""
    from scipy.signal import csd, welch

    x = np.arange(0.0, ROAD_M, STEP_M)
    line: Array = np.empty(0)
    sums = np.zeros((2, 2, PIECE // 2 + 1))
    for seed in range(ROADS):
        road = RandomRoad(spectrum.unevenness_m3, spectrum.waviness, seed)
        sides = (apart_m / 2, -apart_m / 2)
        ground = [road.elevation(x, y) for y in sides]
        wheels = [Wheel(road, y, radius_m, 0.0, ROAD_M).rigid() for y in sides]
        rolled = [wheel.height_and_slope(x)[0] for wheel in wheels]
        for number, (left, right) in enumerate((ground, rolled)):
            line, one = welch(left, 1.0 / STEP_M, nperseg=PIECE)
            other = welch(right, 1.0 / STEP_M, nperseg=PIECE)[1]
            across = csd(left, right, 1.0 / STEP_M, nperseg=PIECE)[1].real
            sums[number] += [(one + other) / 2, across]
    (ground_s, ground_x), (wheel_s, wheel_x) = sums[:, :, FIRST_LINE:]
    return 2 * np.pi * line[FIRST_LINE:], (ground_s, ground_x), (wheel_s, wheel_x)
