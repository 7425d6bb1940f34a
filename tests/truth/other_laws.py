"""Machines that obey other laws than the textbook's, called by the same names.

A library is not told about these laws: what it calls by the same name must still win.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from .effect import Effect
from .model import STEP_S, Car, Drive
from .suspension_effects import per_corner
from .tracks import Array


@dataclass
class TanhFriction(Effect):
    """Friction that creeps before it slides: force tanh(x' / creep)."""

    id = "dry-friction"
    tanh_front_N: float
    tanh_rear_N: float
    creep_m_s: float

    def __post_init__(self) -> None:
        # its slope on a light axle of 10 kg: forces are extrapolated by half a step
        decay_s = 10.0 * self.creep_m_s / max(self.tanh_front_N, self.tanh_rear_N)
        self.step_s = min(STEP_S, 0.4 * decay_s)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        size = per_corner(self.tanh_front_N, self.tanh_rear_N)
        return force + size * np.tanh(rate / self.creep_m_s)


@dataclass
class BristleFriction(Effect):
    """LuGre: bristles z' = v - s0 |v| z / g(v), g = Fc + (Fs - Fc) exp(-(v / vs)^2),
    F = s0 z + s1 z' (C. Canudas de Wit et al., IEEE Trans. Automatic Control 40 (1995) 419)."""

    id = "dry-friction"
    step_s = 2e-4
    sliding_front_N: float
    sliding_rear_N: float
    sticking: float = 1.3  # Fs / Fc
    stribeck_m_s: float = 0.02
    bristle_N_m: float = 4e5
    bristle_N_s_m: float = 150.0

    def start(self, drive: Drive) -> None:
        self._bend, self._step = np.zeros(4), drive.step_s

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        more = (self.sticking - 1.0) * np.exp(-((rate / self.stribeck_m_s) ** 2))
        sliding = per_corner(self.sliding_front_N, self.sliding_rear_N)
        held = np.maximum(sliding * (1.0 + more), 1e-9)
        loss = self.bristle_N_m * np.abs(rate) / held
        before = self._bend
        self._bend = (before + self._step * rate) / (1.0 + self._step * loss)  # implicit in z
        bending = (self._bend - before) / self._step
        own = self.bristle_N_m * self._bend + self.bristle_N_s_m * bending
        return force + np.where(sliding > 0.0, own, 0.0)


@dataclass
class MeasuredDamper(Effect):
    """A curve as dynamometers give it: the slope falls smoothly from c to slope_ratio c about the
    knee, sooner in compression than in rebound by `lead`, and the oil's column gives: the force
    follows with a time constant."""

    id = "digressive-damper"
    knee_m_s: float
    slope_ratio: float
    lead: float
    lag_s: float = 4e-4

    def start(self, drive: Drive) -> None:
        self._damping, self._force = drive.suspension_damping, np.zeros(4)
        self._share = drive.step_s / (drive.step_s + self.lag_s)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        knee = self.knee_m_s * np.where(rate > 0.0, 1.0 - self.lead, 1.0 + self.lead)
        lost = 1.0 - self.slope_ratio
        curve = self._damping * (rate - lost * (rate - knee * np.tanh(rate / knee)))
        self._force = self._force + self._share * (curve - self._force)
        return force + self._force - self._damping * rate


@dataclass
class FoamStop(Effect):
    """A stop of foam: its rate grows from zero to `stiffness_N_m` over `onset_m` and stays there;
    a tenth of its force is lost where it comes back."""

    id = "bump-stop"
    clearance_m: float
    stiffness_N_m: float
    onset_m: float

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        beyond = np.maximum(compression - self.clearance_m, 0.0)
        within = np.minimum(beyond, self.onset_m)
        pushed = self.stiffness_N_m * (within**2 / (2.0 * self.onset_m) + beyond - within)
        return force + pushed * (1.0 + 0.05 * np.tanh(rate / 0.02))


@dataclass
class WanderingEngine(Effect):
    """An engine that idles: its frequency differs from run to run by `run_spread_hz` (one standard
    deviation), wanders within one by `wander_hz` (root mean square, three sines of 3 to 9 s), and
    the force turns with it; `second` is a harmonic of twice the order, over the first."""

    id = "engine-vibration"
    force_N: float
    freq_hz: float
    run_spread_hz: float
    wander_hz: float
    x_m: float
    y_m: float = 0.0
    second: float = 0.0

    def build(self, car: Car) -> None:
        car.add_body_point("engine", self.x_m, self.y_m)

    def frequency_hz(self, drive: Drive) -> Array:
        """On the integration grid (m + 1,)."""
        own = self.freq_hz + self.run_spread_hz * drive.rng.normal()
        period = drive.rng.uniform(3.0, 9.0, 3)
        sines = np.sin(2.0 * pi * drive.time[:, None] / period + drive.rng.uniform(0, 2 * pi, 3))
        return own + self.wander_hz * np.sqrt(2.0 / 3.0) * sines.sum(axis=1)

    def start(self, drive: Drive) -> None:
        frequency = self.frequency_hz(drive)
        turns = np.cumsum(frequency) * drive.step_s
        angle = 2.0 * pi * turns + drive.rng.uniform(0.0, 2.0 * pi)
        # Unbalance grows with the square of the speed.
        size = self.force_N * (frequency / self.freq_hz) ** 2
        drive.push("engine", size * (np.sin(angle) + self.second * np.sin(2.0 * angle)))
