"""Faults of the instrument."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from scipy import signal

from .effect import Effect, channel_index
from .model import CHANNELS
from .tracks import Array

KNOCK_S = 0.05  # before the record begins: whoever starts the logger touches the car


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
class SensorMount(Effect):
    """One channel's sensor is a small mass on a spring and damper, and reads its own motion."""

    id = "sensor-mount"
    channel: str
    freq_hz: float
    zeta: float
    struck_m_s: float = 0.0  # so fast it moves off when knocked, KNOCK_S before

    def feel(self, time: Array, velocity: Array) -> Array:
        k, omega = channel_index(self.channel), 2.0 * pi * self.freq_hz
        # sensor z on point x: z'' = omega^2 (x - z) + 2 zeta omega (x' - z'); x' linear in a step
        damper, spring = 2.0 * self.zeta * omega, omega**2
        mount = signal.TransferFunction([damper, spring], [1.0, damper, spring]).to_ss()
        step = mount.to_discrete(time[1] - time[0], method="foh")
        velocity = velocity.copy()
        velocity[:, k] = signal.dlsim(step, velocity[:, k])[1][:, 0]
        # z'' + 2 zeta omega z' + omega^2 z = 0 from z = 0 with that velocity on
        since = np.maximum(time + KNOCK_S, 0.0)
        damped = omega * np.sqrt(1.0 - self.zeta**2)
        still = np.cos(damped * since) - self.zeta * omega / damped * np.sin(damped * since)
        free = np.exp(-self.zeta * omega * since) * still
        velocity[:, k] += self.struck_m_s * np.where(time < -KNOCK_S, 0.0, free)
        return velocity


@dataclass
class SensorSkew(Effect):
    """Channels are sampled one after the other: column k, counted from 0, late by k skew_s."""

    id = "sensor-skew"
    skew_s: float

    def delay_s(self) -> Array:
        return self.skew_s * np.arange(len(CHANNELS))
