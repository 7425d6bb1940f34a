"""One channel's gain is wrong."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Parameter, Values


class SensorGain(Effect):
    """A channel reads (1 + error) times the acceleration."""

    id = "sensor-gain"
    place = "sensor"
    title = "one channel's gain is wrong"
    equation = r"y = (1 + \epsilon)\, a"
    source = "calibration by comparison, ISO 16063-21: the sensitivity's relative error"

    def __init__(self, channel: str = "") -> None:
        self.channel = channel

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """Any channel."""
        return [c.name for c in channels]

    def with_choice(self, choice: str) -> SensorGain:
        """This fault in the channel `choice`."""
        return SensorGain(choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The relative error; an inverted channel is another effect."""
        return (Parameter("error", "1", "relative error of the gain", 0.1, lower=-0.95, upper=4.0),)

    def sense(
        self, theta: Values, acceleration: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """Scale the channel."""
        return acceleration * self._factors(theta, channels)

    def restore(
        self, theta: Values, measured: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """Scale it back."""
        return measured / self._factors(theta, channels)

    def _factors(self, theta: Values, channels: Sequence[Channel]) -> list[float]:
        return [1.0 + theta["error"] if c.name == self.channel else 1.0 for c in channels]
