"""A simulated synchronicity check: driven cantilever, analog sensors, the logger's sampling."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.sync.beam_file import BeamSession
from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.hil_sim.signals import Signals
from wheelhop.logger.recording import CODE, Channel, Recording

STEP_S = 156.25e-6  # one conversion
CONVERSIONS = 64  # of a scan at 100 Hz
CODES_PER_M_S2 = 57e-3 / 3.0 * 1024 / STANDARD_GRAVITY_M_S2  # ADXL326
INPUTS = 8
REST = 531.0  # code of a sensor at rest, its axis up


@dataclass(frozen=True)
class BeamRig:
    """A beam with analog accelerometers; sensors are given by their channel's name.

    `session` is the truth (its `loss_factor` too), `forces_N` the drive at each frequency. `gain`
    multiplies a channel (−1: inverted, 0: dead), `late_s` is a delay of its own, `corner_hz` its
    RC filter. `swapped` channels have their wires exchanged. `noise_codes` is that of one
    conversion; `clock_ppm` makes the recorder's seconds too long.
    """

    session: BeamSession
    forces_N: tuple[float, ...]
    gain: dict[str, float] = field(default_factory=dict)
    late_s: dict[str, float] = field(default_factory=dict)
    corner_hz: dict[str, float] = field(default_factory=dict)
    swapped: tuple[str, ...] = ()
    noise_codes: float = 0.5
    clock_ppm: float = 0.0

    def record(self, seconds: float, order: str = "palindrome", seed: int = 0) -> Recording:
        """What the logger records, in codes; `order` "plain" samples 0 … 7 again and again."""
        draw = np.random.default_rng(seed)
        rows, channels = round(seconds / (STEP_S * CONVERSIONS)), self.session.channels
        turn = np.arange(INPUTS)
        turns = np.concatenate([turn, turn[::-1]] if order == "palindrome" else [turn, turn])
        which = np.tile(turns, CONVERSIONS // len(turns))
        instants = np.arange(rows * CONVERSIONS).reshape(rows, CONVERSIONS) * STEP_S
        values = np.empty((rows, len(channels)))
        for column, name in enumerate(channels):
            time = np.asarray(instants[:, which == column] * (1 + self.clock_ppm * 1e-6))
            codes = draw.normal(0.0, 8.0) + self._codes(name, time)
            codes += draw.normal(0.0, self.noise_codes, time.shape)
            values[:, column] = np.clip(np.floor(codes), 0, 1023).mean(axis=1)
        return Recording(
            values,
            1 / (CONVERSIONS * STEP_S),
            tuple(Channel(name, CODE) for name in channels),
            start_s=(CONVERSIONS - 1) / 2 * STEP_S,
            averaging_s=CONVERSIONS * STEP_S,
        )

    def signals(self, seconds: float) -> Signals:
        """The beam's motion for the board with the real firmware: noiseless codes at its eight
        inputs."""
        time = np.arange(round(seconds / STEP_S), dtype=np.float64) * STEP_S
        codes = np.full((len(time), INPUTS), REST)
        for column, name in enumerate(self.session.channels):
            codes[:, column] = self._codes(name, time)
        return Signals(codes, 1 / STEP_S)

    def _codes(self, name: str, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """What the input `name` is given, not yet rounded."""
        return REST + CODES_PER_M_S2 * self._motion(self._wired(name), name, time_s)

    def _wired(self, name: str) -> str:
        """The sensor that this input reads."""
        if name in self.swapped:
            return self.swapped[1 - self.swapped.index(name)]
        return name

    def _motion(self, sensor: str, name: str, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        frequencies = np.array(self.session.frequencies_hz)
        at = self.session.channels.index(sensor)
        motion = self.session.shape(frequencies, self.session.loss_factor)[:, at]
        motion = motion * np.array(self.forces_N) * self.gain.get(name, 1.0)
        if sensor in self.corner_hz:
            motion = motion / (1 + 1j * frequencies / self.corner_hz[sensor])
        late = time_s - self.late_s.get(name, 0.0)
        total = np.zeros(time_s.shape, dtype=np.float64)
        for frequency, amplitude in zip(frequencies, motion, strict=True):
            total += (amplitude * np.exp(2j * np.pi * frequency * late)).real
        return total
