"""A simulated calibration rig with known truth: a shaker, a reference, sensors, and the logger.

    rig = random_rig(rng)
    reference, log = rig.reference(rng), rig.log(rng)

Only numpy: the logger here is an ideal one that converts as firmware/SPEC.md says. `Rig.signals`
gives the same sensors to the real firmware on the simulated board.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.constants import NOMINAL_CODES_PER_G
from wheelhop.calibration.shaker.response import conversion_instants_s
from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.hil_sim.signals import CHANNELS, CODES, Signals, from_array
from wheelhop.logger.recording import CODE, Channel, Recording
from wheelhop.logger.settings import CONVERSION_S

Array = NDArray[np.float64]

SCAN_S = 64 * CONVERSION_S  # of 8 conversions of each input
NOMINAL_GAIN = STANDARD_GRAVITY_M_S2 / NOMINAL_CODES_PER_G


@dataclass(frozen=True)
class Sensor:
    """One accelerometer and how it differs from the ideal.

    `rest_code` is its code at rest as mounted, before the converter rounds down; `delay_s` a pure
    delay beyond its one-pole filter; `tilt_rad` the angle of its axis to the table's; `cross` the
    fraction of transverse motion that it shows even so;
    `noise_code` the rms noise of a conversion; `cubic` makes code += cubic · (code − rest)³;
    `gain_drift` (relative) and `rest_drift_code` are per kelvin.
    """

    name: str
    gain_m_s2_per_code: float = NOMINAL_GAIN
    rest_code: float = 531.0
    corner_hz: float = 50.0
    delay_s: float = 0.0
    tilt_rad: float = 0.0
    cross: float = 0.0
    noise_code: float = 0.1
    cubic: float = 0.0
    gain_drift: float = 0.0
    rest_drift_code: float = 0.0

    def gain_at(self, kelvin: float) -> float:
        """Gain, m/s² per code, so many kelvin above the temperature of the calibration."""
        return self.gain_m_s2_per_code * (1 + self.gain_drift * kelvin)


@dataclass(frozen=True)
class Shaking:
    """The table's motion: pieces of constant frequency, or one of growing frequency.

    Each step is frequency_hz, amplitude_m_s2, seconds; between steps the table rests `pause_s`, and
    amplitudes rise and fall within `ramp_s`. A `sweep_to_hz` makes every step's frequency go there,
    exponentially. `harmonics` are amplitudes relative to the fundamental, from the second on;
    `transverse` is the sideways motion.
    """

    steps: tuple[tuple[float, float, float], ...]
    pause_s: float = 1.0
    ramp_s: float = 0.3
    sweep_to_hz: float = 0.0
    harmonics: tuple[float, ...] = (0.02, 0.01)
    transverse: float = 0.0

    @property
    def duration_s(self) -> float:
        """From rest to rest."""
        return self.pause_s + sum(seconds + self.pause_s for _, _, seconds in self.steps)

    def acceleration(
        self, time_s: Array, corner_hz: float = np.inf, high_pass_hz: float = 0.0
    ) -> Array:
        """(n,) m/s² at any times, as it leaves a one-pole low-pass and high-pass.

        The filters act on each harmonic at its momentary frequency: their transients (a few
        milliseconds) are left out.
        """
        out = np.zeros_like(time_s)
        start = self.pause_s
        for first_hz, amplitude, seconds in self.steps:
            inside = (time_s > start) & (time_s < start + seconds)
            t = time_s[inside] - start
            rate = np.log(self.sweep_to_hz / first_hz) / seconds if self.sweep_to_hz else 0.0
            frequency = first_hz * np.exp(rate * t)
            phase = 2 * np.pi * ((frequency - first_hz) / rate if rate else first_hz * t)
            ramp = np.minimum(np.minimum(t, seconds - t) / self.ramp_s, 1.0)
            envelope = amplitude * np.sin(np.pi / 2 * ramp) ** 2
            for order, relative in enumerate((1.0, *self.harmonics), start=1):
                passed = 1 / (1 + 1j * order * frequency / corner_hz)
                passed /= 1 - 1j * high_pass_hz / (order * frequency)
                turn = order * phase + 0.7 * (order - 1)
                out[inside] += (envelope * relative * passed * np.exp(1j * turn)).imag
            start += seconds + self.pause_s
        return out


@dataclass(frozen=True)
class Rig:
    """Shaker, reference and logger. The reference's clock is the true one:

        t_reference = (1 + clock_ppm · 10⁻⁶) · t_logger + clock_offset_s

    `reference_error` is the relative error of what the reference says, within its certificate;
    `conversions` are 8, 4 or 2 in each sum, for 100, 200 or 400 scans a second.
    """

    sensors: tuple[Sensor, ...]
    shaking: Shaking
    clock_offset_s: float = 0.0
    clock_ppm: float = 0.0
    reference_rate_hz: float = 1000.0
    reference_error: float = 0.0
    reference_noise_m_s2: float = 0.01
    reference_high_pass_hz: float = 0.0
    warming_K: float = 0.0
    supply_mv: int = 3300
    conversions: int = 8

    def reference(self, rng: np.random.Generator) -> Recording:
        """What the reference's recorder has, in m/s²."""
        count = int(self.shaking.duration_s * self.reference_rate_hz)
        time_s = np.arange(count) / self.reference_rate_hz
        values = self.shaking.acceleration(time_s, high_pass_hz=self.reference_high_pass_hz)
        values = values * (1 + self.reference_error)
        values = values + self.reference_noise_m_s2 * rng.standard_normal(len(values))
        return Recording(values[:, None], self.reference_rate_hz, (Channel("reference", "m/s²"),))

    def log(self, rng: np.random.Generator) -> Recording:
        """What the logger has, in mean codes; its clock runs a second longer than the table."""
        scan_s = SCAN_S * self.conversions / 8
        count = int((self.shaking.duration_s + 1) / scan_s)
        first_s = (scan_s - CONVERSION_S) / 2  # mean sampling instant of scan 0
        centre_s = first_s + np.arange(count) * scan_s
        columns = []
        for number, sensor in enumerate(self.sensors):
            instants = centre_s[:, None] + conversion_instants_s(number, self.conversions)
            volts = self._code(sensor, self._true_time(instants).ravel())
            volts += sensor.noise_code * rng.standard_normal(volts.size)
            codes = np.clip(np.floor(volts), 0, CODES - 1)
            columns.append(codes.reshape(count, self.conversions).mean(1))
        names = [sensor.name for sensor in self.sensors]
        return Recording(
            np.column_stack(columns),
            1 / scan_s,
            tuple(Channel(name, CODE) for name in names),
            start_s=first_s,
            averaging_s=scan_s,
            history=("simulated rig",),
            notes={
                "channels": " ".join(names + ["-"] * (CHANNELS - len(names))),
                "rate_hz": f"{1 / scan_s:.0f}",
                "conversions": str(self.conversions),
                "supply_mv": str(self.supply_mv),
                "device": "3",
            },
        )

    def signals(self, rate_hz: float = 6400.0) -> Signals:
        """The sensors for the simulated board, without noise: codes over true time."""
        time_s = np.arange(int(self.shaking.duration_s * rate_hz)) / rate_hz
        codes = np.full((len(time_s), CHANNELS), 512.0)
        for number, sensor in enumerate(self.sensors):
            codes[:, number] = self._code(sensor, time_s)
        return from_array(codes, rate_hz)

    def as_recorded(self, rng: np.random.Generator, rate_hz: float) -> Signals:
        """The sensors for an emulated logger, with noise: codes over the logger's own clock, which
        runs for two seconds longer than the table does."""
        own_s = np.arange(int((self.shaking.duration_s + 2) * rate_hz)) / rate_hz
        codes = np.full((len(own_s), CHANNELS), 512.0)
        for number, sensor in enumerate(self.sensors):
            noise = sensor.noise_code * rng.standard_normal(len(own_s))
            codes[:, number] = self._code(sensor, self._true_time(own_s)) + noise
        return from_array(codes, rate_hz)

    def _true_time(self, logger_s: Array) -> Array:
        return np.asarray((1 + 1e-6 * self.clock_ppm) * logger_s + self.clock_offset_s)

    def _code(self, sensor: Sensor, true_s: Array) -> Array:
        """What a sensor puts out, in codes that nothing has rounded."""
        motion = self.shaking.acceleration(true_s - sensor.delay_s, sensor.corner_hz)
        sideways = sensor.cross + np.sin(sensor.tilt_rad)
        motion *= np.cos(sensor.tilt_rad) + sideways * self.shaking.transverse
        warm = self.warming_K * (true_s / self.shaking.duration_s - 0.5)
        code = motion / (sensor.gain_m_s2_per_code * (1 + sensor.gain_drift * warm))
        return sensor.rest_code + sensor.rest_drift_code * warm + code + sensor.cubic * code**3


STEPPED = tuple(
    (frequency, min(amplitude, 0.012 * (2 * np.pi * frequency) ** 2), seconds)
    for frequency, amplitude, seconds in (
        *((9.7, 12.0, 6.0), (1.3, 12.0, 8.0), (2.1, 12.0, 8.0), (3.7, 12.0, 7.0)),
        *((5.9, 12.0, 6.0), (15.3, 12.0, 6.0), (21.7, 12.0, 6.0), (31.1, 12.0, 6.0)),
        *((43.3, 12.0, 6.0), (9.7, 12.0, 6.0), (9.7, 24.0, 6.0), (9.7, 6.0, 6.0)),
    )
)
"""A session as docs/calibration.md advises: 12 mm of stroke, frequencies that do not divide the
scan rate, the first one repeated at the end, and at several amplitudes."""

SWEPT = Shaking(((1.5, 8.0, 120.0),), sweep_to_hz=45.0)


def random_rig(
    rng: np.random.Generator, sensors: int = 2, shaking: Shaking = Shaking(STEPPED)
) -> Rig:
    """A rig as one would find it: ADXL326 within the data sheet's limits, a reference that is right
    within ± 0.3 % (k = 2), clocks apart by seconds and up to half a per cent."""
    return Rig(
        tuple(random_sensor(rng, name) for name in _names(sensors)),
        replace(shaking, transverse=rng.uniform(-0.05, 0.05)),
        clock_offset_s=rng.uniform(-2.0, 0.5),
        clock_ppm=rng.uniform(-5000, 5000),
        reference_error=rng.normal(0, 0.0015),
        reference_noise_m_s2=rng.uniform(0.002, 0.02),
        warming_K=rng.uniform(-2, 2),
    )


def random_sensor(rng: np.random.Generator, name: str) -> Sensor:
    """An ADXL326 with 0.1 µF, somewhat tilted, and a converter's noise."""
    return Sensor(
        name,
        gain_m_s2_per_code=NOMINAL_GAIN / rng.uniform(0.9, 1.1),
        rest_code=531 + rng.uniform(-60, 60),
        corner_hz=50 * rng.uniform(0.8, 1.25),
        tilt_rad=np.radians(rng.uniform(-2, 2)),
        cross=rng.uniform(-0.01, 0.01),
        noise_code=rng.uniform(0.05, 0.4),
        gain_drift=rng.uniform(-1e-4, 1e-4),
        rest_drift_code=rng.uniform(-0.02, 0.02),
    )


def _names(count: int) -> Sequence[str]:
    return ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")[:count]
