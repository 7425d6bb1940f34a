"""Effects in the suspension. Forces act on the body, compression positive, about static load."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from .effect import Effect
from .model import Car, Drive
from .tracks import Array
from .vehicle import suspension_static_load


def per_corner(front: float, rear: float) -> Array:
    """A value of the front and one of the rear axle as an array over the corners (4,)."""
    return np.array([front, front, rear, rear])


@dataclass
class DryFriction(Effect):
    """Coulomb friction behind a presliding spring (an elastic, perfectly plastic element).

    F = k u; du = dx while |F| < coulomb, and F stays at the coulomb force while sliding.
    """

    id = "dry-friction"
    coulomb_front_N: float
    coulomb_rear_N: float
    presliding_N_m: float = 1.5e6

    def start(self, drive: Drive) -> None:
        self._limit = per_corner(self.coulomb_front_N, self.coulomb_rear_N) / self.presliding_N_m
        self._stretch = np.zeros(4)
        self._last = np.zeros(4)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        trial = self._stretch + compression - self._last
        self._stretch = np.minimum(np.maximum(trial, -self._limit), self._limit)
        self._last = compression
        return force + self.presliding_N_m * self._stretch


@dataclass
class AirSpring(Effect):
    """The spring is all air: F0 (1 - x/h)^-n, polytropic about its static load F0.

    Its stiffness at rest, n F0 / h, is the vehicle's, which fixes the air column's height h;
    the exponent n is what there is to choose.
    """

    id = "progressive-spring"
    polytropic_exponent: float

    def start(self, drive: Drive) -> None:
        self._load = suspension_static_load(drive.vehicle)
        self._stiffness = drive.suspension_stiffness
        self._height = self.polytropic_exponent * self._load / self._stiffness

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        column = np.maximum(1.0 - compression / self._height, 0.05)
        air = self._load * (column**-self.polytropic_exponent - 1.0)
        return force + air - self._stiffness * compression


@dataclass
class CubicSpring(Effect):
    """A spring k x + k3 x^3."""

    id = "progressive-spring"
    cubic_front_N_m3: float
    cubic_rear_N_m3: float

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        return force + per_corner(self.cubic_front_N_m3, self.cubic_rear_N_m3) * compression**3


@dataclass
class AsymmetricDamper(Effect):
    """Damping c (1 - asymmetry) in compression and c (1 + asymmetry) in rebound."""

    id = "asymmetric-damper"
    asymmetry: float

    def start(self, drive: Drive) -> None:
        self._damping = drive.suspension_damping

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        return force - self.asymmetry * self._damping * np.abs(rate)


@dataclass
class DigressiveDamper(Effect):
    """Damping c up to the knee velocity; beyond it the slope is slope_ratio * c."""

    id = "digressive-damper"
    knee_m_s: float
    slope_ratio: float

    def start(self, drive: Drive) -> None:
        self._lost_damping = (1.0 - self.slope_ratio) * drive.suspension_damping

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        beyond = rate - np.clip(rate, -self.knee_m_s, self.knee_m_s)
        return force - self._lost_damping * beyond


@dataclass
class BumpStop(Effect):
    """An elastic stop beyond a clearance in compression and, if one is given, in rebound."""

    id = "bump-stop"
    clearance_m: float
    stiffness_N_m: float
    rebound_clearance_m: float = inf

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        beyond = compression - np.clip(compression, -self.rebound_clearance_m, self.clearance_m)
        return force + self.stiffness_N_m * beyond


@dataclass
class Backlash(Effect):
    """Free play of gap_m in series with the strut, closed while the strut is in compression.

    When the strut's total force (static load F0 included) falls to zero the joint opens: the strut
    relaxes by itself, F0 + k s + c s' = 0 with s its own compression, until x catches up with s
    or the gap is used up and the strut is pulled: x <= s <= x + gap.
    """

    id = "backlash"
    step_s = 1e-4  # the gap closes with a blow: 6e-4 of a loud response, 1.5e-3 at 2.5e-4
    gap_m: float

    def start(self, drive: Drive) -> None:
        self._load = suspension_static_load(drive.vehicle)
        self._k, self._c = drive.suspension_stiffness, drive.suspension_damping
        self._decay = np.exp(-self._k / self._c * drive.step_s)
        self._strut = np.zeros(4)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        rest = -self._load / self._k
        free = rest + (self._strut - rest) * self._decay
        self._strut = np.clip(free, compression, compression + self.gap_m)
        carried = self._k * self._strut + self._c * rate
        own = np.where(self._strut == free, -self._load, carried)
        return force + own - self._k * compression - self._c * rate


@dataclass
class MountBushing(Effect):
    """A spring and damper (Kelvin-Voigt) in series with the strut.

    With u the mount's compression: k_m u + c_m u' = k (x - u) + c (x' - u').
    """

    id = "mount-bushing"
    stiffness_N_m: float
    damping_N_s_m: float

    def start(self, drive: Drive) -> None:
        self._k, self._c = drive.suspension_stiffness, drive.suspension_damping
        self._half_step = drive.step_s / 2.0
        self._give, self._give_rate = np.zeros(4), np.zeros(4)

    def suspension(self, force: Array, compression: Array, rate: Array) -> Array:
        direct = self._k * compression + self._c * rate  # the strut's force on a rigid mount
        of_mount = self.stiffness(self._give)
        damping, stiffness = self._c + self.damping_N_s_m, self._k + of_mount
        # trapezoidal rule, which is linear in the unknown u'
        predicted = self._give + self._half_step * self._give_rate
        self._give_rate = (direct - stiffness * predicted) / (damping + stiffness * self._half_step)
        self._give = predicted + self._half_step * self._give_rate
        own = of_mount * self._give + self.damping_N_s_m * self._give_rate
        return force + own - direct

    def stiffness(self, give: Array) -> Array:
        """The mount's, N/m, at such a give (4,)."""
        return np.full(4, self.stiffness_N_m)


@dataclass
class AntiRollBar(Effect):
    """A spring between left and right travel: the left wheel carries k (x_left - x_right) more."""

    id = "anti-roll-bar"
    stiffness_front_N_m: float = 0.0
    stiffness_rear_N_m: float = 0.0

    def build(self, car: Car) -> None:
        for axle, left, stiffness in (
            ("front", 1, self.stiffness_front_N_m),
            ("rear", 3, self.stiffness_rear_N_m),
        ):
            difference = dict(car.lengths[f"S{left}"])
            for joint, coefficient in car.lengths[f"S{left + 1}"].items():
                difference[joint] = difference.get(joint, 0.0) - coefficient
            car.add_length(f"anti-roll {axle}", difference, stiffness)


@dataclass
class CornerAsymmetry(Effect):
    """One corner's spring and damper differ from the vehicle's by the given fractions."""

    id = "corner-asymmetry"
    corner: float  # 1..4
    stiffness_change: float = 0.0
    damping_change: float = 0.0

    def build(self, car: Car) -> None:
        strut = car.spec.tendon(f"S{int(self.corner)}")
        strut.stiffness = strut.stiffness * (1.0 + self.stiffness_change)
        strut.damping = strut.damping * (1.0 + self.damping_change)
