"""Faults of the instrument."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .effect import Effect, channel_index
from .model import CHANNELS
from .tracks import Array


@dataclass
class SensorGain(Effect):
    """One channel reads (1 + gain_error) times what it should."""

    id = "sensor-gain"
    channel: str
    gain_error: float

    def sense(self, samples: Array) -> Array:
        samples = samples.copy()
        samples[:, channel_index(self.channel)] *= 1.0 + self.gain_error
        return samples


@dataclass
class SensorPolarity(Effect):
    """One channel is inverted, or exchanged with another."""

    id = "sensor-polarity"
    channel: str
    swapped_with: str = ""

    def sense(self, samples: Array) -> Array:
        samples = samples.copy()
        one = channel_index(self.channel)
        if self.swapped_with:
            other = channel_index(self.swapped_with)
            samples[:, [one, other]] = samples[:, [other, one]]
        else:
            samples[:, one] *= -1.0
        return samples


@dataclass
class SensorClipping(Effect):
    """One channel (or "all") saturates at +-limit."""

    id = "sensor-clipping"
    limit_m_s2: float
    channel: str = "all"

    def record(self, samples: Array) -> Array:
        samples = samples.copy()
        chosen = slice(None) if self.channel == "all" else channel_index(self.channel)
        samples[:, chosen] = np.clip(samples[:, chosen], -self.limit_m_s2, self.limit_m_s2)
        return samples


@dataclass
class SensorSkew(Effect):
    """Channels are sampled one after the other: column k, counted from 0, late by k skew_s."""

    id = "sensor-skew"
    skew_s: float

    def delay_s(self) -> Array:
        return self.skew_s * np.arange(len(CHANNELS))
