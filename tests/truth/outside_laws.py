"""Laws of worn and special parts that no library is told about, each at a place it names."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .body_effects import DriverSeat
from .effect import Effect
from .model import SMALL, STEP_S, Car, Drive
from .suspension_effects import per_corner
from .tracks import Array
from .vehicle import suspension_static_load


@dataclass
class OneSidedPlay(Effect):
    """A spring that is not held in its seat: beyond `free_m` of rebound it comes off, and pulls
    again once a strap has taken up `gap_m`."""

    id = "one-sided-play"
    free_m: float
    gap_m: float

    def start(self, drive: Drive) -> None:
        self._stiffness = drive.suspension_stiffness

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        lost = np.clip(-compression - self.free_m, 0.0, self.gap_m)
        return force + self._stiffness * lost


@dataclass
class BumpRubber(Effect):
    """A rubber beyond a clearance in compression whose force is D sin(C atan(B d)), H. B. Pacejka's
    magic formula: stiff at once, then giving way."""

    id = "bump-rubber"
    clearance_m: float
    peak_N: float
    shape: float = 1.3
    stiffness_1_m: float = 150.0

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        deep = np.maximum(compression - self.clearance_m, 0.0)
        return force + self.peak_N * np.sin(self.shape * np.arctan(self.stiffness_1_m * deep))


@dataclass
class CrackedWeld(Effect):
    """The mount of one corner's spring opens under tension: softer by `lost` in rebound."""

    id = "cracked-weld"
    corner: float  # 1..4
    lost: float

    def start(self, drive: Drive) -> None:
        self._lost = np.zeros(4)
        i = int(self.corner) - 1
        self._lost[i] = self.lost * drive.suspension_stiffness[i]

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        return force - self._lost * np.minimum(compression, 0.0)


@dataclass
class BlowOffValve(Effect):
    """A valve that opens at the force of `open_m_s` and shuts at that of `shut_m_s`; while it is
    open the damping's slope is `slope_ratio` of what it was, behind `lag_s` of a moving poppet."""

    id = "blow-off-valve"
    open_m_s: float
    shut_m_s: float
    slope_ratio: float
    lag_s: float = 2e-3

    def start(self, drive: Drive) -> None:
        self._damping = drive.suspension_damping
        self._open, self._lift = np.zeros(4, dtype=bool), np.zeros(4)
        self._share = drive.step_s / (drive.step_s + self.lag_s)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        speed = np.abs(rate)
        self._open = np.where(self._open, speed > self.shut_m_s, speed > self.open_m_s)
        self._lift += self._share * (self._open - self._lift)
        beyond = np.sign(rate) * np.maximum(speed - self.shut_m_s, 0.0)
        return force - self._lift * (1.0 - self.slope_ratio) * self._damping * beyond


@dataclass
class LoadFriction(Effect):
    """A guide that rubs as hard as the strut is loaded: friction `coefficient` times the load it
    carries, static and dynamic, behind a stiff joint."""

    id = "load-friction"
    coefficient_front: float
    coefficient_rear: float
    joint_N_m: float = 3e5

    def start(self, drive: Drive) -> None:
        self._load = np.asarray(suspension_static_load(drive.vehicle))
        self._stiffness = drive.suspension_stiffness
        self._share = per_corner(self.coefficient_front, self.coefficient_rear)
        self._held, self._last = np.zeros(4), np.zeros(4)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        carried = np.maximum(self._load + self._stiffness * compression, 0.0)
        limit = self._share * carried
        trial = self._held + self.joint_N_m * (compression - self._last)
        self._held, self._last = np.clip(trial, -limit, limit), compression
        return force + self._held


@dataclass
class StickSlipSeat(DriverSeat):
    """A driver whose seat slides on dry guides beside its cushion: MuJoCo holds the joint until
    `friction_N` is overcome."""

    id = "stick-slip-seat"
    friction_N: float = 0.0

    def build(self, car: Car) -> None:
        super().build(car)
        seat = car.spec.joint("seat")
        seat.frictionloss = self.friction_N * SMALL
        seat.solref_friction = [4.0 * STEP_S, 1.0]
        car.has_friction = True
