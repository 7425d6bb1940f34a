"""A potentiometer behind a linkage shows a curve over the wheel's travel, not a line."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from wheelhop.campaign.curves import LENGTH, read_curve
from wheelhop.campaign.paths import file_inside
from wheelhop.campaign.types import CampaignError
from wheelhop.files import Table

Array = NDArray[np.float64]

BEYOND = 0.1
"""So far, per its length, travel may leave a curve, which goes on straight there."""


@dataclass(frozen=True)
class Rocker:
    """What a sensor shows, m, at some travels of the wheel, m, positive in rebound and 0 at ride
    height; the former rises with the latter, or falls."""

    file: Path
    wheel_m: tuple[float, ...]
    sensor_m: tuple[float, ...]

    @property
    def per_wheel(self) -> float:
        """The ratio at ride height."""
        return float(1.0 / self._wheel(self._at_rest_m, 1))

    def rest_m(self, shown: Array) -> float:
        """What a sensor that showed this (n,) shows at ride height, if the wheel is there in the
        mean."""
        rest = float(shown.mean())
        for _ in range(8):  # each leaves a small part of what the last one left
            rest += float(self._travel(shown - rest + self._at_rest_m).mean()) * self.per_wheel
        return rest

    def straightened(self, shown: Array, rest_m: float) -> Array:
        """What a sensor would have shown (n,) behind a linkage of `per_wheel`, of what it showed
        while it rested at `rest_m`: travel about ride height, in its unit.

        Raises CampaignError for what lies beyond the curve.
        """
        reading = shown - rest_m + self._at_rest_m
        low, high = self._ends
        beyond = float(np.abs(reading - np.clip(reading, low, high)).max())
        if beyond > BEYOND * (high - low):
            raise CampaignError(
                f"{self.file}: the sensor goes {1e3 * beyond:.3g} mm beyond the curve, which has"
                f" {1e3 * (high - low):.3g} mm: measure all of the wheel's travel, or look at the"
                " column's unit"
            )
        return self.per_wheel * self._travel(reading)

    def _travel(self, reading: Array) -> Array:
        """Of the wheel; beyond its ends the curve goes on straight."""
        inside = np.clip(reading, *self._ends)
        return np.asarray(self._wheel(inside) + (reading - inside) * self._wheel(inside, 1))

    @property
    def _ends(self) -> tuple[float, float]:
        return min(self.sensor_m), max(self.sensor_m)

    @cached_property
    def _wheel(self) -> PchipInterpolator:
        """Travel of the wheel over what the sensor shows."""
        sensor, wheel = np.array(self.sensor_m), np.array(self.wheel_m)
        order = np.argsort(sensor)
        return PchipInterpolator(sensor[order], wheel[order])

    @cached_property
    def _at_rest_m(self) -> float:
        """What it shows at ride height."""
        return float(PchipInterpolator(self.wheel_m, self.sensor_m)(0.0))


def read_rocker(table: Table, key: str) -> Rocker:
    """The curve in the CSV file that `key` names, with columns wheel_mm and sensor_mm, or in m.

    Raises CampaignError for a file that is not there or not such a table, and a curve that turns
    round or does not hold ride height.
    """
    file = file_inside(table.file.parent, table, key)
    columns = read_curve(file, {"wheel": LENGTH, "sensor": LENGTH}, fewest=3)
    order = np.argsort(columns["wheel"])
    wheel, sensor = columns["wheel"][order], columns["sensor"][order]
    steps = np.diff(sensor)
    if not (np.diff(wheel) > 0.0).all() or not ((steps > 0.0).all() or (steps < 0.0).all()):
        raise CampaignError(
            f"{file}: the sensor turns round, or a travel of the wheel stands there twice: it must"
            " rise with the wheel's travel all along, or fall"
        )
    if not wheel[0] <= 0.0 <= wheel[-1]:
        raise CampaignError(
            f"{file}: the wheel's travel must hold 0, ride height, positive in rebound"
        )
    return Rocker(file, tuple(wheel.tolist()), tuple(sensor.tolist()))
