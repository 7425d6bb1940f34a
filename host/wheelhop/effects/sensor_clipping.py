"""A channel cannot read more than its range."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Probe, Values
from wheelhop.effects.parameters import Parameter, Shape, Switch

ALL = "all"
"""The form in which every channel has the same range."""


class SensorClipping(Effect):
    """Where the acceleration exceeds the range, the channel reads the range."""

    id = "sensor-clipping"
    place = "sensor"
    title = "a channel saturates, symmetrically about zero"
    equation = r"y = \min(\max(a, -L), L)"
    source = (
        "overload of an accelerometer or its amplifier: P. Walter, Shock and vibration"
        " measurement (PCB Piezotronics); limits of equal size assumed"
    )

    def __init__(self, channel: str = "") -> None:
        self.channel = channel

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """Any accelerometer, or all with the same range."""
        felt = [c.name for c in channels if c.is_acceleration]
        return [*felt, ALL] if felt else []

    def with_choice(self, choice: str) -> SensorClipping:
        """This fault in the channel `choice`."""
        return SensorClipping(choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """On or off, and the range; it begins at what the channel has read: see `shape_starts`."""
        return (
            Switch("clips", "1", "1: the channel saturates"),
            Shape(
                "limit_m_s2",
                "m/s²",
                "largest acceleration the channel reads",
                5.0,
                lower=0.01,
                starts=(10.0,),
            ),
        )

    def shape_starts(self, probe: Probe) -> Sequence[Values]:
        """The largest reading: where a channel saturates, many samples equal it."""
        largest = 0.0
        for setting in probe.settings:
            record = probe.recorded(setting.run_id)
            largest = max(largest, float(np.abs(record[:, self._affected(probe.channels)]).max()))
        return [{"limit_m_s2": largest}] if largest > 0.0 else []

    def sense(
        self, theta: Values, acceleration: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """Cut off what lies beyond the range, by the share `clips`."""
        limit, reading = theta["limit_m_s2"], np.array(acceleration)
        affected = self._affected(channels)
        excess = reading[:, affected] - np.clip(reading[:, affected], -limit, limit)
        reading[:, affected] -= theta["clips"] * excess
        return reading

    def _affected(self, channels: Sequence[Channel]) -> NDArray[np.bool_]:
        return np.array([c.is_acceleration and self.channel in (c.name, ALL) for c in channels])
