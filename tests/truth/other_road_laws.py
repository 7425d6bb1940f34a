"""Roads, tyres, wheels and drivers that obey other laws than the textbook's: see other_laws.py."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import pi

import numpy as np

from .effect import Effect
from .model import Drive
from .road_effects import SmallScaleRoughness, TyreEnvelope, TyreLiftOff, WheelImbalance
from .tracks import Array, Track, Wheel
from .vehicle import tyre_static_load


@dataclass
class GearChanges(Effect):
    """The driver changes gear every `every_s`: within `fall_s` the speed falls by the fraction
    `dip`, and comes back over the rest."""

    id = "speed-fluctuation"
    dip: float
    every_s: float = 4.0
    fall_s: float = 0.3

    def steer(self, drive: Drive) -> None:
        since = (drive.time + drive.rng.uniform(0.0, self.every_s)) % self.every_s
        back = (self.every_s - since) / (self.every_s - self.fall_s)
        lost = self.dip * drive.speed_m_s * np.minimum(since / self.fall_s, back)
        behind = np.cumsum(lost) * drive.step_s
        drive.path -= (behind - np.interp(0.0, drive.time, behind))[:, None]


@dataclass
class PressedEnvelope(TyreEnvelope):
    """The middle of the contact presses hardest: the mean over it is weighted with a parabola."""

    pressed: bool = field(kw_only=True)

    def pressure(self, away: Array, length: float) -> Array:
        return np.maximum(1.0 - (2.0 * away / length) ** 2, 0.0)


@dataclass
class PatchyRoughness(SmallScaleRoughness):
    """Washed out here and smooth there: the height comes and goes with the way."""

    patch_m: float = field(kw_only=True)
    contrast: float = 0.7

    def pave(self, track: Track, drive: Drive) -> Track:
        paved, phase = super().pave(track, drive), drive.rng.uniform(0.0, 2.0 * pi)
        even = paved.unevenness
        assert even is not None

        def unevenness(x: Array, y: float) -> Array:
            return even(x, y) * (1.0 + self.contrast * np.sin(2.0 * pi * x / self.patch_m + phase))

        return replace(paved, unevenness=unevenness)


@dataclass
class SoftLanding(TyreLiftOff):
    """The contact opens and closes along its length: no corner at zero force, but a bend of
    `bend_N`."""

    bend_N: float

    def tyre(self, force: Array, deflection: Array, rate: Array) -> Array:
        def pushed(total: Array) -> Array:
            return 0.5 * (total + np.hypot(total, self.bend_N))

        return pushed(self._load + force) - pushed(self._load)


@dataclass
class OutOfRound(WheelImbalance):
    """A wheel that is unbalanced is out of round, too: its radius varies by `runout_m`."""

    runout_m: float = field(kw_only=True)

    def start(self, drive: Drive) -> None:
        super().start(drive)
        self._turned = drive.rng.uniform(0.0, 2.0 * pi)

    def roll(self, wheel: Wheel) -> Array | None:
        if wheel.corner != int(self.corner) - 1:
            return None
        angle = wheel.x / (self.rolling * wheel.radius) + self._turned
        return wheel.rigid() + self.runout_m * np.cos(angle)


@dataclass
class PowerTyre(Effect):
    """A tyre's whole load grows with a power of its whole deflection, as pressed air in a round
    casing has it; at the static load its stiffness is the vehicle's. Off the ground it has none."""

    id = "progressive-tyre"
    power: float

    def start(self, drive: Drive) -> None:
        self._load, self._stiffness = tyre_static_load(drive.vehicle), drive.tyre_stiffness

    def tyre(self, force: Array, deflection: Array, rate: Array) -> Array:
        at_rest = self.power * self._load / self._stiffness
        whole = self._load * np.maximum(1.0 + deflection / at_rest, 0.0) ** self.power
        return force + whole - self._load - self._stiffness * deflection


@dataclass
class SlippingWheels(Effect):
    """One side or the other slips now and then, whichever is lighter on the ground: within
    `slip_s` it falls behind by up to `slip_m`."""

    id = "left-right-drift"
    slip_m: float
    every_s: float = 1.0
    slip_s: float = 0.2

    def steer(self, drive: Drive) -> None:
        lead, at = np.zeros_like(drive.time), float(drive.time[0])
        while (at := at + self.every_s * drive.rng.uniform(0.5, 1.5)) < drive.time[-1]:
            size = self.slip_m * drive.rng.uniform(-0.3, 1.0)
            lead += size * (0.5 + 0.5 * np.tanh(2.0 * (drive.time - at) / self.slip_s))
        lead -= np.interp(0.0, drive.time, lead)
        drive.path[:, 0] -= 0.5 * lead
        drive.path[:, 1] += 0.5 * lead
