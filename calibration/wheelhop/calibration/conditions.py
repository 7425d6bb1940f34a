"""`Conditions`: what about a calibration no recording tells, and what it makes uncertain.

The limits are those of the ADXL326's data sheet and of careful work; a session may state its own.
"""

from dataclasses import dataclass
from datetime import date
from math import hypot, nan, radians, sin, sqrt

from wheelhop.files.units import STANDARD_GRAVITY_M_S2

RECTANGULAR = sqrt(3)  # limit / standard uncertainty, GUM 4.3.7
GAIN_DRIFT_PER_K = 1e-4  # ADXL326: ± 0.01 % / °C
OFFSET_DRIFT_M_S2_PER_K = 1e-3 * STANDARD_GRAVITY_M_S2  # ADXL326: ± 1 mg / °C


@dataclass(frozen=True)
class Conditions:
    """Reference, its certificate, and how the session was made.

    `reference_expanded` is the relative expanded uncertainty (k = 2) of the reference's chain,
    sensor and amplifier. The rest are limits, ±: `tilt_deg` between the axes of sensor and table,
    `transverse` motion of the table and `cross_axis` sensitivity of the sensor, both relative, and
    `temperature_range_K` by which a sensor in use may be warmer or colder than now. `axis` is
    "up", or "horizontal" where gravity does not act on the sensors during the calibration.
    """

    id: str
    day: date
    valid_until: date
    reference: str = ""
    certificate: str = ""
    reference_expanded: float = 0.0
    high_pass_hz: float = 0.0
    tilt_deg: float = 2.0
    transverse: float = 0.05
    cross_axis: float = 0.01
    temperature_C: float = nan
    temperature_range_K: float = 10.0
    supply_V: float = nan
    axis: str = "up"

    @property
    def reference_part(self) -> float:
        """Relative standard uncertainty of the gain from the reference's certificate."""
        return self.reference_expanded / 2

    @property
    def alignment_part(self) -> float:
        """From the axes: a cosine, and the part of the transverse motion that the sensor shows.

        The latter is a product of two quantities, each rectangular within its limits.
        """
        tilt = radians(self.tilt_deg)
        cosine = tilt**2 / 2 / RECTANGULAR
        return hypot(cosine, self.transverse * hypot(sin(tilt), self.cross_axis) / 3)

    @property
    def temperature_part(self) -> float:
        """From the sensor being warmer or colder in use."""
        return GAIN_DRIFT_PER_K * self.temperature_range_K / RECTANGULAR

    @property
    def offset_part_m_s2(self) -> float:
        """Uncertainty of the offset from the sensor being warmer or colder in use, m/s²."""
        return OFFSET_DRIFT_M_S2_PER_K * self.temperature_range_K / RECTANGULAR
