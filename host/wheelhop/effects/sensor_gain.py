"""One channel's gain is wrong."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, OwnValues, RunSetting, Values
from wheelhop.effects.parameters import Amplitude, Parameter, Shape

DRIFT = 0.01
"""One standard deviation of what a sensitivity does from run to run: it drifts with temperature by
one or two per cent in an afternoon."""


class SensorGain(Effect):
    """A channel reads (1 + error) times the acceleration; in each run a little more or less, as it
    warms up."""

    id = "sensor-gain"
    place = "sensor"
    title = "one channel's gain is wrong"
    equation = r"y = (1 + \epsilon)(1 + \delta)\, a,\quad \delta \text{ free in each run}"
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
        return (Amplitude("error", "1", "relative error of the gain", 0.1, lower=-0.95, upper=4.0),)

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """By how much the gain differs in this run from that of all. No amplitude: of a channel
        that is right on the whole, a per cent is what calibrations leave open anyway."""
        return (Shape("drift", "1", "gain over that of all runs, less one", DRIFT, starts=(0.0,)),)

    def summary(self, runs: Sequence[OwnValues]) -> dict[str, float]:
        """The drift's standard deviation from run to run."""
        drifts = [theta.get("drift", 0.0) for _, theta, _ in runs]
        return {"spread_fraction": float(np.std(drifts))} if drifts else {}

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
        gain = (1.0 + theta["error"]) * (1.0 + theta.get("drift", 0.0))
        return [gain if c.name == self.channel else 1.0 for c in channels]
