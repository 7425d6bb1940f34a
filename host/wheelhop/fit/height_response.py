"""What unknown heights of the ground do to a run's record, to first order.

The records' in-band coefficients are taken as complex numbers, one per frequency and channel, real
and imaginary part each with the noise σ. A height under a side's front wheel comes back under its
rear wheel a wheelbase later; to eight channels that leaves two unknowns per frequency.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from wheelhop.effects import Effect
from wheelhop.fit.bench import Bench
from wheelhop.simulate import HeightSeries, Model, frequency_response, slowness
from wheelhop.vehicle import System, wheels

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


class Ground:
    """A run's record as a linear function of heights, about a model.

    Parameters
    ----------
    bench
        The run; its simulator has a `HeightSeries`.
    model, system
        The model and its equations of motion for this run's drive.
    coherent
        Whether rear wheels meet what the front wheels met; else each wheel has heights of its own,
        which no ground has: a control.
    """

    def __init__(self, bench: Bench, model: Model, system: System, coherent: bool = True) -> None:
        assert bench.simulator.series is not None
        self.bench = bench
        self.series: HeightSeries = bench.simulator.series
        way = bench.simulator.way(model) - model.start_m(bench.run.id)
        time = bench.run.time_s
        self._front = way[:, :2]
        self._behind_m = float(np.mean(way[:, :2] - way[:, 2:]))
        self._coherent = coherent
        self.speed_m_s = float((way[-1] - way[0]).mean() / (time[-1] - time[0]))
        self._slowness = slowness(model, bench.run)
        self._model, self._system = model, system

    def anew(self) -> Ground:
        """This ground with empty caches."""
        return self.about(self._model, self._system)

    def about(self, model: Model, system: System) -> Ground:
        """The ground of this run under another model."""
        return Ground(self.bench, model, system, self._coherent)

    def response(self, wave_number_rad_m: Array) -> ComplexArray:
        """Record per height of the left and the right path (k, c, 2), or of every wheel
        (k, c, wheels), accelerations in 1/s², every channel per its noise scale, at the mean speed;
        phases are those under the front wheel."""
        scale = self.bench.noise_scale[self.bench.predicted][:, None]
        return np.asarray(self._response_to(wave_number_rad_m) / scale)

    def _response_to(self, wave_number_rad_m: Array) -> ComplexArray:
        frequency = wave_number_rad_m * self.speed_m_s / (2 * np.pi)
        campaign = self.bench.simulator.campaign
        wheel = frequency_response(self._system, frequency)[:, self.bench.predicted]
        wheel = wheel * campaign.recorded(frequency)[:, None, None]
        if not self._coherent:
            return self._sensed(wheel, frequency)
        later = np.exp(-1j * wave_number_rad_m * self._behind_m)[:, None]
        path = np.zeros((*wheel.shape[:2], 2), dtype=np.complex128)
        for j, i in enumerate(wheels(self._model.values)):
            path[:, :, i % 2] += wheel[:, :, j] * (later if i >= 2 else 1.0)
        return self._sensed(path, frequency)

    @property
    def coefficient_variance(self) -> float:
        """Variance of an in-band coefficient of the height per its spectral density, 1/m."""
        return float(np.pi * self.bench.band.rate_hz / self.speed_m_s)

    def _sensed(self, response: ComplexArray, frequency_hz: Array) -> ComplexArray:
        """The response as sensors with faults give it: what they make of an impulse tells."""
        faults: list[Effect] = [e for e in self._model.effects if e.place == "sensor"]
        if not faults:
            return response
        campaign, run_id = self.bench.simulator.campaign, self.bench.run.id
        n, rate = len(self.bench.run.time_s), campaign.sample_rate_hz
        channels = len(campaign.channels)
        sensed = np.empty((len(frequency_hz), channels, channels), dtype=np.complex128)
        turn = np.exp(-2j * np.pi * np.outer(frequency_hz, (np.arange(n) - n // 2) / rate))
        for i in range(channels):
            signal = np.zeros((n, channels))
            signal[n // 2, i] = IMPULSE_M_S2
            for effect in faults:
                theta = self._model.theta(effect, run_id)
                signal = effect.sense(theta, signal, campaign.channels, rate)
            sensed[:, :, i] = turn @ signal / IMPULSE_M_S2
        return np.asarray(sensed[:, self.bench.predicted][:, :, self.bench.predicted] @ response)

    @cached_property
    def in_band_rad_m(self) -> Array:
        """Wave numbers (f,) of the band's frequencies at the mean speed."""
        return np.asarray(2 * np.pi * self.bench.band.frequency_hz / self.speed_m_s)

    @cached_property
    def in_band(self) -> ComplexArray:
        """The response (f, c, paths) there."""
        return self.response(self.in_band_rad_m)

    def slope(self, other: Model, system: System, step: float) -> ComplexArray:
        """The change of `in_band` to another model, per `step`; kept like derivatives."""
        change = self.about(other, system).response(self.in_band_rad_m) - self.in_band
        return np.asarray(change / step, np.complex64)

    @cached_property
    def _response(self) -> ComplexArray:
        return self.response(self.wave_number_rad_m)

    @cached_property
    def _waves(self) -> list[ComplexArray]:
        """In-band coefficients (f, k) of exp(iκu)/2 along each side's way; one if both go alike."""
        sides = self._front.T
        if np.array_equal(sides[0], sides[1]):
            sides = sides[:1]
        return [
            self._coefficients(np.exp(1j * np.outer(way, self.wave_number_rad_m))) for way in sides
        ]

    @property
    def wave_number_rad_m(self) -> Array:
        """The wave numbers (k,) of the series, at the speed of the model."""
        return self.series.wave_number_rad_m * self._slowness

    @property
    def step_rad_m(self) -> float:
        """Their distance."""
        return self.series.step_rad_m * self._slowness

    def _coefficients(self, signal: ComplexArray) -> ComplexArray:
        """In-band coefficients (f, k) of half of complex signals (n, k)."""
        band = self.bench.band
        half = band.count // 2
        first = round(float(band.frequency_hz[0] * band.n / band.rate_hz))
        spectrum = fft.fft(signal, axis=0)[first : first + half]
        return np.asarray(spectrum * (0.5 * np.sqrt(2.0 / band.n)))

    def complex_of(self, coefficients: Array) -> ComplexArray:
        """Real coefficients (size, m) as complex ones (f, c, m)."""
        half, (size, m) = self.bench.band.count // 2, coefficients.shape
        parts = coefficients.reshape(2, half, size // (2 * half), m)
        return np.asarray(parts[0] + 1j * parts[1])

    def project(self, columns: Array) -> ComplexArray:
        """Gᴴ of coefficients (size, m), for the heights of left and then right paths: (2k, m)."""
        signal = self.complex_of(columns)
        f, c, m = signal.shape
        along = [
            (waves.conj().T @ signal.reshape(f, c * m)).reshape(-1, c, m) for waves in self._waves
        ]
        return np.concatenate(
            [
                np.einsum("kc,kcm->km", self._response[:, :, side].conj(), along[side % len(along)])
                for side in (0, 1)
            ]
        )

    def apply(self, heights: ComplexArray) -> Array:
        """G of heights (2k, m): coefficients (size, m)."""
        k, m = self.series.count, heights.shape[1]
        moved = [
            np.einsum("kc,km->kcm", self._response[:, :, side], heights[side * k : (side + 1) * k])
            for side in (0, 1)
        ]
        if len(self._waves) < len(moved):
            moved = [moved[0] + moved[1]]
        parts = [w @ each.reshape(k, -1) for w, each in zip(self._waves, moved, strict=True)]
        signal = np.sum(parts, axis=0).reshape(-1, m)
        return np.concatenate([signal.real, signal.imag])

    def square(self) -> ComplexArray:
        """GᴴG (2k, 2k), 20 MB and more: not kept."""
        response = self._paths
        return self._overlap() * (response.conj() @ response.T)

    @property
    def _paths(self) -> ComplexArray:
        """The response (2k, c), left path and then right."""
        return np.concatenate([*self._response.transpose(2, 0, 1)])

    def _overlap(self) -> ComplexArray:
        """Scalar products (2k, 2k) of the waves along left and right."""
        first, last = self._waves[0], self._waves[-1]
        cross = last.conj().T @ first
        if last is first:
            return np.tile(cross, (2, 2))
        left, right = first.conj().T @ first, last.conj().T @ last
        return np.block([[left, cross.conj().T], [cross, right]])


IMPULSE_M_S2 = 0.01
"""Far too small for a sensor to clip it."""
