"""`Constants`: what turns a logger's codes into m/s², whose they are, and how sure they are.

    acceleration = gain · (code − offset)

`offset` is the code at rest with the sensor mounted as in use, so gravity is taken out with it:
the result is the kinematic acceleration that a campaign holds. `gain` is the static one: what
averaging and the sensor's filter take away at higher frequencies is undone apart from it.
"""

import datetime as dt
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from wheelhop.calibration.error import CalibrationError
from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.logger.recording import ACCELERATION, CODE, Channel, Recording
from wheelhop.logger.supply import supply_change

# ADXL326, Analog Devices, data sheet rev. 0, table 1, at 3 V; code 1024 is the supply.
NOMINAL_CODES_PER_G = 57e-3 / 3.0 * 1024
NOMINAL_GAIN_LIMIT = 0.10  # 51 … 63 mV/g
NOMINAL_ZERO_G_CODE = 511.5  # half the supply; the converter rounds down
NOMINAL_ZERO_G_LIMIT_CODE = 0.3 / 3.0 * 1024  # 1.2 … 1.8 V on the z axis
NOMINAL_CORNER_HZ = 50.0  # 32 kΩ ± 15 % with 0.1 µF ± 10 %
NOMINAL_CORNER_LIMITS = (0.15, 0.10)


@dataclass(frozen=True)
class Value:
    """A number with its expanded uncertainty: ± `expanded`, coverage factor 2, about 95 %."""

    value: float
    expanded: float

    @property
    def relative(self) -> float:
        """Expanded uncertainty as a fraction of the value."""
        return abs(self.expanded / self.value)

    def __str__(self) -> str:
        """Two digits of the uncertainty, and the value to the same place (GUM 7.2.6)."""
        if not 0 < self.expanded < np.inf:
            return f"{self.value:.6g}"
        digits = max(0, 1 - int(np.floor(np.log10(self.expanded))))
        return f"{self.value:.{digits}f} ± {self.expanded:.{digits}f}"


@dataclass(frozen=True)
class SensorConstants:
    """The constants of one sensor in its place: `channel` of the logger, `serial` number, or empty.

    `gain` in m/s² per code and `offset` in codes as defined above; `corner_hz` is that of the
    sensor's one-pole filter and `delay_s` the phase delay at 10 Hz against the mean of the
    logger's channels, None where the method cannot tell. `supply_V` is NaN if unknown.
    """

    channel: str
    serial: str
    gain: Value
    offset: Value
    date: dt.date
    valid_until: dt.date
    method: str
    temperature_C: float = float("nan")
    supply_V: float = float("nan")
    reference: str = ""
    certificate: str = ""
    corner_hz: Value | None = None
    delay_s: Value | None = None


@dataclass(frozen=True)
class Constants:
    """Constants of one logger's sensors. `device` is its number, 0 if it has none; `source` is the
    file they come from."""

    id: str
    device: int
    sensors: tuple[SensorConstants, ...]
    source: str = field(default="calibration", compare=False)

    def of(self, channel: str) -> SensorConstants:
        """The constants of a channel. Raises CalibrationError if there are none."""
        for sensor in self.sensors:
            if sensor.channel == channel:
                return sensor
        known = ", ".join(sensor.channel for sensor in self.sensors)
        raise CalibrationError(
            f"{self.source}: no constants for channel {channel}, only for {known}:"
            " calibrate it, or leave it out"
        )

    def apply(self, recording: Recording) -> Recording:
        """Return a recording of codes in m/s², with history; what `warnings` says is in it, too.

        Raises CalibrationError if it is not in codes, or if the constants belong to another
        logger, another sensor or other channels.
        """
        self._check_device(recording)
        sensors = [self._matching(channel) for channel in recording.channels]
        gain = np.array([sensor.gain.value for sensor in sensors])
        offset = np.array([sensor.offset.value for sensor in sensors])
        channels = tuple(
            replace(channel, unit=ACCELERATION, sensor=sensor.serial, calibration=self.id)
            for channel, sensor in zip(recording.channels, sensors, strict=True)
        )
        warnings = "".join(f"; {warning}" for warning in self.warnings(recording))
        return recording.after(
            f"codes to m/s² with calibration {self.id}{warnings}",
            values=(recording.values - offset) * gain,
            channels=channels,
        )

    def warnings(self, recording: Recording) -> tuple[str, ...]:
        """What does not forbid these constants, but should be known; no two lines alike."""
        start = recording.start_unix_s
        day = (
            dt.datetime.fromtimestamp(start, dt.UTC).date()
            if start
            else dt.datetime.now(dt.UTC).date()
        )
        found = []
        for sensor in self.sensors:
            if day > sensor.valid_until and sensor.channel in {c.name for c in recording.channels}:
                found.append(f"{sensor.channel}: out of date since {sensor.valid_until}")
        wanted = recording.notes.get("calibration", "")
        if wanted and wanted != self.id:
            found.append(f"the log asks for calibration {wanted}, this is {self.id}")
        if change := supply_change(recording.notes):
            found.append(change.text)
        return tuple(found)

    def _check_device(self, recording: Recording) -> None:
        device = device_of(recording)
        if self.device and device not in (0, self.device):
            raise CalibrationError(
                f"{self.source}: constants of logger {self.device}, but logger {device} made the"
                " recording: give that logger's constants"
            )
        wanted = recording.notes.get("calibration", "")
        if wanted and wanted != self.id and not (self.device and device == self.device):
            raise CalibrationError(
                f"{self.source}: calibration {self.id}, but the log asks for {wanted}, and no"
                " device number says that they belong together: give that file"
            )

    def _matching(self, channel: Channel) -> SensorConstants:
        if channel.unit != CODE:
            raise CalibrationError(
                f"{self.source}: channel {channel.name} is in {channel.unit}, not in codes:"
                " it has been calibrated before"
            )
        sensor = self.of(channel.name)
        if channel.sensor and sensor.serial and channel.sensor != sensor.serial:
            raise CalibrationError(
                f"{self.source}: channel {channel.name} was recorded with sensor {channel.sensor},"
                f" the constants are those of {sensor.serial}"
            )
        return sensor


def device_of(recording: Recording) -> int:
    """The number of the logger that made a recording, 0 if it has none."""
    number = recording.notes.get("device", "")
    return int(number) if number.isdecimal() else 0


def nominal_constants(channels: Iterable[str]) -> Constants:
    """What the data sheet says of ADXL326 sensors with their axis up, AREF at the sensors' supply.

    Limits of the data sheet are taken as rectangular (GUM 4.3.7): expanded = 2 · limit / √3.
    """
    gain = STANDARD_GRAVITY_M_S2 / NOMINAL_CODES_PER_G
    k = 2 / 3**0.5
    today = dt.datetime.now(dt.UTC).date()
    return Constants(
        "nominal",
        0,
        tuple(
            SensorConstants(
                channel=channel,
                serial="",
                gain=Value(gain, k * NOMINAL_GAIN_LIMIT * gain),
                offset=Value(
                    NOMINAL_ZERO_G_CODE + NOMINAL_CODES_PER_G, k * NOMINAL_ZERO_G_LIMIT_CODE
                ),
                date=today,
                valid_until=dt.date.max,
                method="data sheet of the ADXL326, not calibrated",
                corner_hz=Value(NOMINAL_CORNER_HZ, k * 0.15 * NOMINAL_CORNER_HZ),
            )
            for channel in channels
        ),
        source="nominal constants",
    )
