"""What one piece of physics may do to a simulated run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .model import CHANNELS, STEP_S, Car, Drive
from .tracks import Array, Track, Wheel


@dataclass
class Effect:
    """Base of all effects; a subclass is a dataclass of its parameters and overrides some hooks.

    The same object serves one run after another: whatever `suspension` and `tyre` remember is
    set anew in `start`.
    """

    id: ClassVar[str]
    step_s = STEP_S  # the longest integration step that resolves it

    def build(self, car: Car) -> None:
        """Change the car before it is compiled: bodies, joints, springs."""

    def steer(self, drive: Drive) -> None:
        """Change the paths of the wheels along the track."""

    def pave(self, track: Track, drive: Drive) -> Track:
        """Change the ground."""
        return track

    def roll(self, wheel: Wheel) -> Array | None:
        """Replace the height of a rigid wheel's centre at wheel.x."""
        return None

    def start(self, drive: Drive) -> None:
        """Look at the run that is about to begin: push forces, reset memories."""

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        """Replace the force (4,) of the suspensions on the body (upward, about static), newtons.

        Called once per step in time order, with the compression (m) and its rate (m/s).
        """
        return force

    def tyre(self, force: Array, deflection: Array, rate: Array) -> Array:
        """Replace the tyres' force (4,) on the wheels, like `suspension`."""
        return force

    def feel(self, time: Array, velocity: Array) -> Array:
        """Velocities (m + 1, 8) of the sensors, given those of CHANNELS on the integration grid."""
        return velocity

    def delay_s(self) -> Array:
        """How late each of CHANNELS is sampled (8,)."""
        return np.zeros(len(CHANNELS))

    def sense(self, samples: Array) -> Array:
        """Change the samples (n, 8) before noise and offset are added."""
        return samples

    def record(self, samples: Array) -> Array:
        """Change the samples (n, 8) with their noise and offset, as they are stored."""
        return samples

    def has_law(self, hook: str) -> bool:
        """Whether this effect replaces the force of that hook."""
        return getattr(type(self), hook) is not getattr(Effect, hook)


def channel_index(name: str) -> int:
    """Column of a channel; ValueError names the ones there are."""
    if name not in CHANNELS:
        raise ValueError(f"no channel {name!r}; channels are {', '.join(CHANNELS)}")
    return CHANNELS.index(name)
