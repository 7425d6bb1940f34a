"""How a vehicle moved in a run, as its linear model and the record together tell, and what forces
along that motion add to the record.

A force f(δ, δ̇) that a linear model lacks leaves y − H u = −G f(δ, δ̇) of a record, with δ as the
vehicle moved: exactly, however strong it is, whereas to first order it would be taken along the
motion of the model without it. So J.-P. Noël, J. Schoukens, Grey-box state-space identification of
nonlinear mechanical vibrations, Int. J. Control 91 (2018) 1118, eq. 4: a nonlinearity is an input
that is known where its motion is recorded.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.interpolate import CubicSpline
from scipy.ndimage import uniform_filter1d

from wheelhop.fit import Bench
from wheelhop.law.along import LawAt, follow_all
from wheelhop.simulate import Model, RunSimulator
from wheelhop.simulate.prescribed import twice_integrated
from wheelhop.vehicle import System

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

ROUNDS = 5
"""So often motion and the force of a given law along it are found from each other."""

TAPER_S = 0.1
"""Over this time at both its ends what the record tells of the motion takes hold."""


NEIGHBOURS_HZ = 1.0
"""Over so wide a part of the spectrum a record's power is told from the sensors' noise."""


class ForcedRun:
    """One run on its track of a model whose force laws are left out; ports of its `system` are the
    places that are asked about. `laws` that the model may lack, at ports, say how far they move it
    below the band, where no record tells; `noise` is the standard deviation of a sample, m/s².

    Attributes
    ----------
    extension, rate : (T, p) of the ports at every step, from the beginning of the run-up on, m and
        m/s: as the model says, and in the record as that does.
    samples : where among the steps the samples of the record are.
    step_s : time between steps.
    """

    def __init__(
        self,
        bench: Bench,
        model: Model,
        system: System,
        noise: float,
        laws: Sequence[LawAt] = (),
    ) -> None:
        simulator = bench.simulator
        assert isinstance(simulator, RunSimulator)
        moves, campaign, run = simulator.prescribed(model, system), simulator.campaign, bench.run
        self._bench, self._system, self._stride = bench, system, moves.stride
        self._noise = noise
        self._output = np.nan_to_num(system.output)
        self.step_s = 1.0 / (campaign.sample_rate_hz * moves.stride)
        last = moves.first + (len(run.time_s) - 1) * moves.stride
        self.samples = slice(moves.first, last + 1, moves.stride)
        memory = round(bench.memory_s / self.step_s)
        # The record's samples are steps, too, of the spectrum cut at half their rate.
        self._short = fft.next_fast_len(-(-(len(moves.height) + memory) // moves.stride), real=True)
        self._long = self._short * moves.stride
        omega = 2 * np.pi * fft.rfftfreq(self._long, self.step_s)
        self._omega = omega
        self._accelerated = -(omega**2)[:, None] * campaign.recorded(omega / (2 * np.pi))
        jw = 1j * omega[:, None, None]
        dynamic = system.stiffness + jw * (system.damping + jw * system.mass)
        self._inverse = np.linalg.inv(dynamic)
        push = (system.input_stiffness + jw * system.input_damping) @ self._spectrum(moves.height)
        push += system.force @ self._spectrum(moves.force)
        linear = (self._inverse @ push)[..., 0]
        self.extension: Array
        self.rate: Array
        for rounds in range(ROUNDS if laws else 1):
            motion = linear
            if rounds:
                force = follow_all(laws, self.extension, self.rate, self.step_s)
                pulled = self._spectrum(force)[..., 0] @ system.port[[port for port, *_ in laws]]
                pulled[omega > 2 * np.pi * campaign.band_hz[0]] = 0.0
                motion = motion - (self._inverse @ pulled[..., None])[..., 0]
            motion = motion + self._as_recorded(motion, dynamic, len(moves.height))
            self.extension, self.rate = (
                fft.irfft(part @ system.port.T, self._long, axis=0)[: len(given)]
                + given @ system.port_input.T
                for part, given in ((motion, moves.height), (jw[..., 0] * motion, moves.rate))
            )

    def answers(self, ports: Sequence[int], force: Array, columns: Sequence[int]) -> Array:
        """In-band coefficients (size, k) of what forces (T, j), N, add to the record, each at the
        port of its number: they oppose its extension. Forces of the same column of the k are added
        up. Single precision is enough for what is kept in it."""
        half, to = self._short // 2 + 1, self._to_record
        spectrum = fft.rfft(force.T.astype(np.float32), self._long, axis=1)[:, :half]
        # Frequency last: what stands side by side is read together.
        moved = np.zeros((max(columns) + 1, to.shape[1], half), np.complex64)
        for j, (port, column) in enumerate(zip(ports, columns, strict=True)):
            moved[column] += to[port] * spectrum[j]
        bench = self._bench
        changes = self._sampled(moved.T) / bench.noise_scale.astype(np.float32)[:, None]
        found = bench.band.coefficients(changes[:, bench.predicted])
        return np.asarray(found.reshape(-1, len(moved)))

    @cached_property
    def _to_record(self) -> NDArray[np.complex64]:
        """What outputs show (p, c, f) per force at each port and per −ω², at the frequencies that
        samples show."""
        system, inverse = self._system, self._inverse[: self._short // 2 + 1]
        found = -np.einsum("cn,fnm,pm->pcf", self._output, inverse, system.port)
        if system.reads:
            omega = self._omega[: len(inverse)]
            per = np.divide(-1.0, omega**2, out=np.zeros_like(omega), where=omega > 0.0)
            n, m = system.input_stiffness.shape
            x, v, _, law = np.split(system.reading, [n, 2 * n, 2 * n + 2 * m], axis=1)
            moved = -inverse @ system.port.T
            read = (x + 1j * omega[:, None, None] * v) @ moved + law
            read = read * per[:, None, None]
            found[:, list(system.reads)] = read.transpose(2, 1, 0)
        return np.asarray(found, np.complex64)

    def _spectrum(self, given: Array) -> ComplexArray:
        """Of histories (T, k), as columns (f, k, 1)."""
        return np.asarray(fft.rfft(given, self._long, axis=0)[..., None])

    def _sampled(self, motion: ComplexArray) -> Array:
        """Acceleration at the samples of the record, the mean over their window, of the outputs'
        motion (f, c, …)."""
        half = self._short // 2 + 1
        weight = self._accelerated[:half].reshape(half, -1, *[1] * (motion.ndim - 2))
        found = (
            fft.irfft(motion[:half] * weight.astype(motion.dtype), self._short, axis=0)
            / self._stride
        )
        first = self.samples.start // self._stride
        return np.asarray(found[first : first + len(self._bench.run.time_s)])

    def _as_recorded(self, motion: ComplexArray, dynamic: ComplexArray, steps: int) -> ComplexArray:
        """What of the motion (f, n) the record knows better: of coordinates that sensors see, and
        of the others as they follow these; nothing if the sensors cannot tell those apart."""
        bench, added = self._bench, np.zeros_like(motion)
        modelled = self._sampled(motion @ self._output.T)
        told = bench.predicted & self._output.any(axis=1)
        seen = self._output[told].any(axis=0)
        sensors = self._output[told][:, seen]
        if np.linalg.matrix_rank(sensors) < seen.sum():
            return added
        beyond = self._above_noise((bench.run.record - modelled)[:, told])
        time_s = bench.run.time_s - bench.run.time_s[0]
        at: Array = self.step_s * np.arange((len(time_s) - 1) * self._stride + 1, dtype=float)
        acceleration = CubicSpline(time_s, beyond @ np.linalg.pinv(sensors).T)
        way, _ = twice_integrated(acceleration, at, bench.simulator.campaign.band_hz[0])
        share = np.clip(np.minimum(at, at[-1] - at) / TAPER_S, 0.0, 1.0)[:, None]
        whole = np.zeros((steps, way.shape[1]))
        whole[self.samples.start : self.samples.start + len(at)] = way * share**2 * (3 - 2 * share)
        added[:, seen] = fft.rfft(whole, self._long, axis=0)
        pull = dynamic[:, ~seen][:, :, seen] @ added[:, seen, None]
        added[:, ~seen] = -np.linalg.solve(dynamic[:, ~seen][:, :, ~seen], pull)[..., 0]
        return added

    def _above_noise(self, beyond: Array) -> Array:
        """What of accelerations (T, c) is more than noise, in the band: N. Wiener's filter. Twice
        integrated, noise at low frequency would move the vehicle by millimetres."""
        spectrum = fft.rfft(beyond, axis=0)
        spacing_hz = 1.0 / (len(beyond) * self._stride * self.step_s)
        width = max(round(NEIGHBOURS_HZ / spacing_hz), 1)
        power = uniform_filter1d(np.abs(spectrum) ** 2, width, axis=0)
        noise = self._noise**2 * len(beyond)
        share = np.clip(1.0 - noise / np.maximum(power, 1e-300), 0.0, 1.0)
        share[spacing_hz * np.arange(len(share)) < self._bench.simulator.campaign.band_hz[0]] = 0.0
        return np.asarray(fft.irfft(spectrum * share, len(beyond), axis=0))
