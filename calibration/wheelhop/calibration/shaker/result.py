"""What a comparison with a reference found."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.conditions import Conditions
from wheelhop.calibration.constants import Constants, SensorConstants, Value
from wheelhop.calibration.error import CalibrationError
from wheelhop.calibration.shaker.points import Points
from wheelhop.logger.recording import CODE

Array = NDArray[np.float64]

REFERENCE_HZ = 10.0  # where budget and delay are stated
LEAST_COHERENCE = 0.9
ALIKE = 0.02  # relative difference of steps that count as one frequency
METHOD = {
    True: "comparison with a reference, stepped sine (ISO 16063-21)",
    False: "comparison with a reference, swept sine (ISO 16063-21)",
}


@dataclass(frozen=True, eq=False)
class ChannelCalibration:
    """What was found of one channel, `unit` its own (codes, as a rule).

    `gain` is static; `sensitivity` is the reciprocal of the response's magnitude at 10 Hz, sensor's
    filter included and the logger's averaging taken out; both in m/s² per unit. `budget` names the
    relative standard uncertainties that make up that of `sensitivity`. `points` have known filters
    taken out, `deviation` (n,) is how far each that
    is usable is from the fitted model, relative, and `expanded`
    (n,) what may be expected of that (k = 2). `nonlinearity` is the largest change of gain with
    amplitude, relative; `noise` rms of a row; `usable_hz` where the coherence is good.
    """

    name: str
    unit: str
    serial: str
    points: Points
    gain: Value
    sensitivity: Value
    corner_hz: Value | None
    delay_s: Value
    offset: Value
    noise: float
    nonlinearity: Value | None
    deviation: Array
    expanded: Array
    phase_rad: Array
    budget: tuple[tuple[str, float], ...]
    usable_hz: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Channels and clocks: t_reference = (1 + drift) · t_logger + offset."""

    conditions: Conditions
    device: int
    stepped: bool
    offset_s: Value
    drift_ppm: Value
    channels: tuple[ChannelCalibration, ...]
    findings: tuple[str, ...]

    def constants(self) -> Constants:
        """What calibration.toml holds. Raises CalibrationError if the channels are not in codes."""
        other = [channel for channel in self.channels if channel.unit != CODE]
        if other:
            raise CalibrationError(
                f"channel {other[0].name} is in {other[0].unit}, not in codes: its gain is shown,"
                " but there are no constants to write"
            )
        conditions = self.conditions
        return Constants(
            conditions.id,
            self.device,
            tuple(
                SensorConstants(
                    channel=channel.name,
                    serial=channel.serial,
                    gain=channel.gain,
                    offset=channel.offset,
                    date=conditions.day,
                    valid_until=conditions.valid_until,
                    method=METHOD[self.stepped],
                    temperature_C=conditions.temperature_C,
                    supply_V=conditions.supply_V,
                    reference=conditions.reference,
                    certificate=conditions.certificate,
                    corner_hz=channel.corner_hz,
                    delay_s=channel.delay_s,
                )
                for channel in self.channels
            ),
        )
