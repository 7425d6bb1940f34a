"""Machines that obey other laws than the textbook's, called by the same names.

A library is not told about these laws: what it calls by the same name must still win.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi

import mujoco
import numpy as np

from .body_effects import DriverSeat, FrameTwist
from .effect import Effect, channel_index
from .model import STEP_S, Car, Drive
from .sensor_effects import SensorClipping, SensorGain
from .suspension_effects import AirSpring, AntiRollBar, CornerAsymmetry, MountBushing, per_corner
from .tracks import Array
from .vehicle import suspension_static_load


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


@dataclass
class WarmingGas(AirSpring):
    """Gas that is compressed warms up and cools again: of the force beyond an isothermal one the
    share 1/e is left after `cooling_s`."""

    cooling_s: float

    def start(self, drive: Drive) -> None:
        super().start(drive)
        self._heat, self._warm = np.zeros(4), np.zeros(4)
        self._kept = np.exp(-drive.step_s / self.cooling_s)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        fast = super().suspension(force, compression, rate)
        column = np.maximum(1.0 - compression / self._height, 0.05)
        slow = force + self._load * (1.0 / column - 1.0) - self._stiffness * compression
        self._heat = self._kept * (self._heat + fast - slow - self._warm)
        self._warm = fast - slow
        return slow + self._heat


@dataclass
class RoundedAsymmetry(Effect):
    """An asymmetric damper without a corner at rest: |x'| is rounded over `round_m_s`, and the
    force follows with a time constant."""

    id = "asymmetric-damper"
    asymmetry: float
    round_m_s: float
    lag_s: float = 4e-4

    def start(self, drive: Drive) -> None:
        self._damping, self._force = drive.suspension_damping, np.zeros(4)
        self._share = drive.step_s / (drive.step_s + self.lag_s)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        size = np.hypot(rate, self.round_m_s) - self.round_m_s
        curve = self._damping * (rate - self.asymmetry * size)
        self._force = self._force + self._share * (curve - self._force)
        return force + self._force - self._damping * rate


@dataclass
class RubberMount(MountBushing):
    """Rubber is stiffer the less it moves (Payne): by the share `payne` at rest, half of that at a
    give of `payne_m`."""

    payne: float
    payne_m: float = 3e-4

    def stiffness(self, give: Array) -> Array:
        return self.stiffness_N_m * (1.0 + self.payne / (1.0 + np.abs(give) / self.payne_m))


@dataclass
class StickyBar(AntiRollBar):
    """The bar's bearings and links rub: so much force more until they give, over 0.2 mm."""

    rubbing_N: float = field(kw_only=True)

    def start(self, drive: Drive) -> None:
        self._bend, self._before = np.zeros(2), np.zeros(2)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        apart = compression[::2] - compression[1::2]
        self._bend = np.clip(self._bend + apart - self._before, -2e-4, 2e-4)
        self._before = apart
        held = self.rubbing_N * self._bend / 2e-4
        return force + np.array([held[0], -held[0], held[1], -held[1]])


@dataclass
class WornCorner(CornerAsymmetry):
    """What is worn rubs, too: force tanh(x' / 10 mm/s) in this corner alone."""

    rubbing_N: float = field(kw_only=True)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        here = np.arange(4) == int(self.corner) - 1
        return force + here * self.rubbing_N * np.tanh(rate / 0.01)


@dataclass
class TwoMassDriver(DriverSeat):
    """A human on a seat: trunk and head, the share `upper` of the mass, ride on the rest and have a
    resonance of their own."""

    upper: float = field(kw_only=True)
    upper_hz: float = 9.0
    upper_zeta: float = 0.25

    def build(self, car: Car) -> None:
        super().build(car)
        omega, mass = 2.0 * pi * self.upper_hz, self.upper * self.mass_kg
        pelvis = car.spec.body("driver")
        pelvis.mass = self.mass_kg - mass
        trunk = pelvis.add_body(
            name="trunk",
            ipos=[0.0, 0.0, 0.0],
            mass=mass,
            inertia=[1e-9, 1e-9, 1e-9],
            explicitinertial=True,
        )
        spine = trunk.add_joint(name="spine", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
        spine.stiffness = [mass * omega**2, 0.0, 0.0]
        spine.damping = [2.0 * self.upper_zeta * mass * omega, 0.0, 0.0]


@dataclass
class BendingFrame(FrameTwist):
    """A frame that twists bends as well: all four corners rise while the middle falls."""

    bending_hz: float = field(kw_only=True)
    bending_zeta: float = 0.03

    def build(self, car: Car) -> None:
        super().build(car)
        mass, omega = car.vehicle["body.mass_kg"] / 2.0, 2.0 * pi * self.bending_hz
        mode = car.spec.worldbody.add_body(
            name="bending",
            ipos=[0.0, 0.0, 0.0],
            mass=mass,
            inertia=[1.0, 1.0, 1.0],
            explicitinertial=True,
        )
        bend = mode.add_joint(name="bending", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
        bend.stiffness = [mass * omega**2, 0.0, 0.0]
        bend.damping = [2.0 * self.bending_zeta * mass * omega, 0.0, 0.0]
        for i in range(1, 5):
            car.lengths[f"B{i}"]["bending"] = 1.0
            car.lengths[f"S{i}"]["bending"] = -1.0


@dataclass
class WarmingSensor(SensorGain):
    """The gain drifts in the course of a day: it differs from run to run, by `drift` (one standard
    deviation)."""

    drift: float

    def start(self, drive: Drive) -> None:
        self._more = 1.0 + self.drift * drive.rng.normal()

    def sense(self, samples: Array) -> Array:
        samples = super().sense(samples)
        samples[:, channel_index(self.channel)] *= self._more
        return samples


@dataclass
class OffsetClipping(SensorClipping):
    """An amplifier saturates before its signal is averaged, and about its own offset."""

    offset_m_s2: float = field(kw_only=True)

    def feel(self, time: Array, velocity: Array) -> Array:
        k, velocity = channel_index(self.channel), velocity.copy()
        true = np.diff(velocity[:, k]) / (time[1] - time[0]) + self.offset_m_s2
        lost = true - np.clip(true, -self.limit_m_s2, self.limit_m_s2)
        velocity[1:, k] -= np.cumsum(lost) * (time[1] - time[0])
        return velocity

    def record(self, samples: Array) -> Array:
        return samples


@dataclass
class RubberedPlay(Effect):
    """Free play with rubber on either side of the gap, so that it closes softly. With s the strut's
    own compression F0 + k s + c s' = J(x - s + F0 / rubber), where J(w) is rubber w for w > 0, none
    in the gap and rubber (w + gap) beyond it."""

    id = "backlash"
    step_s = 1e-4
    gap_m: float
    rubber_N_m: float

    def start(self, drive: Drive) -> None:
        self._load = suspension_static_load(drive.vehicle)
        self._k, self._c = drive.suspension_stiffness, drive.suspension_damping
        self._step_s, self._strut = drive.step_s, np.zeros(4)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        rubber, lag = self.rubber_N_m, self._c / self._step_s
        way = compression + self._load / rubber
        left_alone = (lag * self._strut - self._load) / (self._k + lag)
        side = np.where(way > left_alone, 0.0, self.gap_m)
        touches = (way > left_alone) | (way + self.gap_m < left_alone)
        held = (rubber * (way + side) + lag * self._strut - self._load) / (self._k + lag + rubber)
        self._strut = np.where(touches, held, left_alone)
        carried = np.where(touches, rubber * (way + side - self._strut), 0.0) - self._load
        return force + carried - self._k * compression - self._c * rate
