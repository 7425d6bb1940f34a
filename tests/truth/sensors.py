"""What a car may carry besides accelerometers on its eight points: potentiometers along the struts,
gyros, strain gauges; each with noise and an offset of its own.

A *plan* of sensors takes the place of the eight points in a campaign: see `SENSORS`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from .effect import Effect
from .model import CHANNELS, Motion, Run, integrate
from .tracks import Array
from .vehicle import Vehicle


@dataclass(frozen=True)
class Sensor:
    """One sensor: `quantity` is "acceleration" at the point `where` ("B1", or "cg": the centre of
    mass), "travel" or "force" of
    the strut `where` ("1" to "4"), positive in extension, or "rate" of "pitch" or "roll". It shows
    `scale` times that; `noise_rms` is its white noise in band, SI, `offset` a constant."""

    name: str
    quantity: str
    where: str
    noise_rms: float
    scale: float = 1.0
    offset: float = 0.0

    @property
    def in_campaign(self) -> str:
        """Its line below [channels]."""
        if self.quantity == "acceleration":
            return f"{self.name} = " + ("[0.0, 0.0]" if self.where == "cg" else f'"{self.where}"')
        place = (
            f'axis = "{self.where}"'
            if self.quantity == "rate"
            else f"corner = {self.where}, per_wheel = {self.scale}"
        )
        return f'{self.name} = {{ quantity = "{self.quantity}", {place} }}'

    def of(self, motion: Motion) -> tuple[Array, Array]:
        """Instants and what it shows there, without noise; of an acceleration, its integral."""
        if self.quantity == "rate":
            return motion.time, self.scale * motion.joints[self.where][1]
        if self.quantity == "acceleration" and self.where == "cg":
            return motion.time, self.scale * motion.joints["heave"][1]
        if self.quantity == "acceleration":
            return motion.time, self.scale * motion.velocity[:, CHANNELS.index(self.where)]
        corner = int(self.where) - 1
        if self.quantity == "travel":
            travel = motion.position[:, corner] - motion.position[:, 4 + corner]
            return motion.time, self.scale * travel
        middle = 0.5 * (motion.time[1:] + motion.time[:-1])
        return middle, -self.scale * motion.suspension_force[:, corner]


KEYS = {"travel": "noise_rms_m", "rate": "noise_rms_rad_s", "force": "noise_rms_N"}
SENSORS = (
    *(Sensor(f"pot{i}", "travel", str(i), 2e-4, 0.65, 0.031) for i in (1, 2, 3, 4)),
    *(Sensor(f"B{i}", "acceleration", f"B{i}", 0.1, 1.0, 0.05) for i in (1, 2, 3, 4)),
    Sensor("pitch_rate", "rate", "pitch", 0.004, 1.0, 0.01),
    Sensor("roll_rate", "rate", "roll", 0.004, 1.0, -0.02),
)
"""Four potentiometers on the dampers, four accelerometers on the body, two gyros."""


def sense(
    vehicle: Vehicle,
    run: Run,
    sensors: Sequence[Sensor],
    effects: Sequence[Effect] = (),
    *,
    step_s: float | None = None,
) -> Array:
    """What sensors show (n, sensors) in a run before noise and offset join: means over
    run.averaging_s centred on its times."""
    motion = integrate(vehicle, run, effects, step_s=step_s)
    return np.column_stack([_sampled(sensor, motion, run) for sensor in sensors])


def _sampled(sensor: Sensor, motion: Motion, run: Run) -> Array:
    time, shown = sensor.of(motion)
    signal = CubicSpline(time, shown)
    if sensor.quantity != "acceleration":
        signal = signal.antiderivative()
    half = run.averaging_s / 2.0
    if half == 0.0:
        return np.asarray(signal(run.time_s, 1))
    return np.asarray(signal(run.time_s + half) - signal(run.time_s - half)) / (2.0 * half)


def with_noise(
    samples: Array, sensors: Sequence[Sensor], share: float, rng: np.random.Generator
) -> Array:
    """Samples (n, sensors) with offsets, and white noise of which a `share` of the power is in
    band."""
    deviation = np.array([sensor.noise_rms for sensor in sensors]) / np.sqrt(share)
    offset = np.array([sensor.offset for sensor in sensors])
    return np.asarray(samples + offset + deviation * rng.normal(size=samples.shape))
