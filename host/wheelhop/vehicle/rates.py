"""From rig to wheel: what strut and damper do at the wheel they do not sit at.

A wheel that rises by z shortens the strut by s(z). Its motion ratio is R = ds/dz. A strut of force
F(s) holds the wheel with F R; the derivative of that is the wheel rate

    k_w = k R² + F₀ dR/dz,

F₀ the force at ride height, and a damper c is worth c_w = c R² (Kanchwala, table 4.1 and section
4.1.1, without the second term; J. Dixon, Suspension Geometry and Computation, Wiley 2009, ch. 8).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np

from wheelhop.campaign.curves import FEWEST, FORCE, LENGTH, SPEED, read_curve, read_names
from wheelhop.campaign.types import CampaignError
from wheelhop.vehicle.curves import Array, Slope, slope_of

LEAST_RATIO, LARGEST_RATIO = 0.1, 3.0
"""A motion ratio beyond these is none: the inverse of one perhaps, or in other units."""
TURNS = 0.02
"""A rig that goes back by this share of its stroke makes a loop, and shows friction."""


@dataclass(frozen=True, eq=False)
class Linkage:
    """How a wheel moves its strut: `ratio`, R at ride height, and `growth`, dR/dz there, 1/m;
    `travel_m` (n,) of the wheel, up, and `curve` (n,), R there, both empty for a number."""

    ratio: Slope
    growth: float
    travel_m: Array
    curve: Array


@dataclass(frozen=True, eq=False)
class Strut:
    """A strut on the rig: compressions (n,), m, and forces (n,), N, pushing; `stiffness` N/m, the
    force at ride height, N, and half the height of the loop, N."""

    compression_m: Array
    force_N: Array
    ride_m: float
    stiffness: Slope
    ride_force_N: float
    friction_N: float


@dataclass(frozen=True, eq=False)
class Damper:
    """A damper's chart: velocities (n,), m/s, of compression, and forces (n,), N; `damping`
    N s/m, and its means in compression and in rebound; the force at rest, N."""

    velocity_m_s: Array
    force_N: Array
    damping: Slope
    compression_N_s_m: float
    rebound_N_s_m: float
    rest_force_N: float


@dataclass(frozen=True, eq=False)
class WheelRates:
    """Strut, damper and linkage, and what they are worth at the wheel, each with one standard
    deviation."""

    strut: Strut
    damper: Damper
    linkage: Linkage

    @property
    def stiffness_N_m(self) -> float:
        """The wheel rate."""
        ratio = self.linkage.ratio.value
        return self.strut.stiffness.value * ratio**2 + self.from_linkage_N_m

    @property
    def from_linkage_N_m(self) -> float:
        """What of the wheel rate is the linkage's: F₀ dR/dz."""
        return self.strut.ride_force_N * self.linkage.growth

    @property
    def stiffness_uncertainty_N_m(self) -> float:
        """Of the wheel rate."""
        return _at_wheel(self.strut.stiffness, self.linkage.ratio)

    @property
    def damping_N_s_m(self) -> float:
        """The wheel's damping."""
        return self.damper.damping.value * self.linkage.ratio.value**2

    @property
    def damping_uncertainty_N_s_m(self) -> float:
        """Of the wheel's damping."""
        return _at_wheel(self.damper.damping, self.linkage.ratio)

    @property
    def load_N(self) -> float:
        """What the strut carries of the body at the wheel, at ride height."""
        return self.strut.ride_force_N * self.linkage.ratio.value


def wheel_rates(
    strut: str | Path,
    damper: str | Path,
    motion_ratio: str | Path | float,
    *,
    ride_m: float | None = None,
    travel_m: float | None = None,
) -> WheelRates:
    """Wheel rate and damping from a strut on the rig, a damper's chart and the linkage.

    Parameters
    ----------
    strut
        CSV of `displacement` (mm, m), compression, and `force` (N, kN), pushing: points or loops.
    damper
        CSV of `velocity` (mm_s, m_s) and `force` (N, kN), positive in compression.
    motion_ratio
        A number, strut over wheel; or CSV of `wheel_travel` (mm, m), up, 0 at ride height, and
        `strut_travel` (mm, m), compression, or `motion_ratio`.
    ride_m
        The strut's displacement at ride height; by default the middle of what was measured.
    travel_m
        So far up and down from ride height one number has to do; by default, as far as the files
        go.

    Returns
    -------
    WheelRates
        The curves, and stiffness (N/m) and damping (N s/m) at strut and wheel.

    Raises
    ------
    CampaignError
        A file cannot be read or is not what it should be, or too little of it is within the travel.
    """
    given = Path(motion_ratio) if isinstance(motion_ratio, str) else motion_ratio
    linkage = _linkage(given, travel_m)
    reach = None if travel_m is None else travel_m * linkage.ratio.value
    return WheelRates(_strut(Path(strut), ride_m, reach), _damper(Path(damper)), linkage)


def _linkage(given: Path | float, travel_m: float | None) -> Linkage:
    if not isinstance(given, Path):
        _check_ratio(given, f"motion ratio {given:g}")
        return Linkage(Slope(float(given), 0.0, 0.0), 0.0, np.zeros(0), np.zeros(0))
    measured = "motion_ratio" not in read_names(given)
    kind = {"strut_travel": LENGTH} if measured else {"motion_ratio": {"": 1.0}}
    columns = read_curve(given, {"wheel_travel": LENGTH, **kind})
    z, y = columns["wheel_travel"], columns[next(iter(kind))]
    keep = np.ones(len(z), bool) if travel_m is None else np.abs(z) <= travel_m * (1 + 1e-9)
    _check_range(given, z[keep], "wheel_travel", 0.0)
    order = np.argsort(z[keep])
    z, y = z[keep][order], y[keep][order]
    degree = 3 if measured else 2
    size = float(np.abs(z).max())
    fitted = np.polynomial.Polynomial.fit(z, y, degree, domain=[-size, size])
    ratio = fitted.deriv() if measured else fitted
    curve = ratio(z)
    powers = np.vander(z / size, degree + 1, increasing=True)
    sigma = np.sqrt(((y - fitted(z)) ** 2).sum() / max(len(z) - degree - 1, 1))
    place, unit = (1, size) if measured else (0, 1.0)
    scatter = sigma * np.sqrt(np.linalg.pinv(powers.T @ powers)[place, place]) / unit
    value = float(ratio(0.0))
    bend = float(np.sqrt(np.mean((curve - value) ** 2)))
    for number in (float(curve.min()), float(curve.max()), value):
        _check_ratio(number, f"{given}: a motion ratio of {number:.3g}")
    return Linkage(Slope(value, float(scatter), bend), float(ratio.deriv()(0.0)), z, curve)


def _strut(file: Path, ride_m: float | None, reach_m: float | None) -> Strut:
    columns = read_curve(file, {"displacement": LENGTH, "force": FORCE})
    x, force = columns["displacement"], columns["force"]
    ride = float(x.min() + x.max()) / 2 if ride_m is None else ride_m
    keep = np.ones(len(x), bool) if reach_m is None else np.abs(x - ride) <= reach_m * (1 + 1e-9)
    _check_range(file, x[keep], "displacement", ride)
    way = _direction(x)[keep]
    loops = np.abs(way.mean()) < 1.0 - TURNS
    x, force = x[keep], force[keep]
    stiffness, line = slope_of(x - ride, force, way if loops else None)
    if stiffness.value <= 0.0:
        raise CampaignError(
            f"{file}: the force falls as the strut is compressed: displacement is compression and"
            " force pushes, both positive"
        )
    friction = float(line[2]) if loops else 0.0
    return Strut(x, force, ride, stiffness, float(line[0]), max(friction, 0.0))


def _direction(x: Array) -> Array:
    """+1 where the rig compresses, −1 where it extends; it turns where it goes back by 2 % of its
    stroke."""
    least = TURNS * float(np.ptp(x))
    away = np.flatnonzero(np.abs(x - x[0]) > least)
    sign = float(np.sign(x[away[0]] - x[0])) if len(away) else 1.0
    way, first, turn = np.empty(len(x)), 0, 0
    for i in range(len(x)):
        if sign * (x[i] - x[turn]) >= 0.0:
            turn = i
        elif sign * (x[turn] - x[i]) > least:
            way[first : turn + 1] = sign
            first, turn, sign = turn + 1, i, -sign
    way[first:] = sign
    return way


def _damper(file: Path) -> Damper:
    columns = read_curve(file, {"velocity": SPEED, "force": FORCE})
    v, force = columns["velocity"], columns["force"]
    if not (v.min() < 0.0 < v.max()):
        raise CampaignError(
            f"{file}: velocities go from {v.min():g} to {v.max():g} m/s: give compression, above 0,"
            " and rebound, below 0"
        )
    damping, line = slope_of(v, force)
    if damping.value <= 0.0:
        raise CampaignError(
            f"{file}: the force falls with velocity: both are positive in compression"
        )
    rest = float(line[0])
    means = [
        float((force[side] - rest) @ v[side] / (v[side] @ v[side])) for side in (v > 0.0, v < 0.0)
    ]
    return Damper(v, force, damping, means[0], means[1], rest)


def _check_range(file: Path, x: Array, what: str, ride: float) -> None:
    if len(x) < FEWEST or not x.min() < ride < x.max():
        raise CampaignError(
            f"{file}: {what}: {len(x)} points are within the travel, and ride height at"
            f" {1e3 * ride:g} mm has to lie among them: look at ride height, travel and units"
        )


def _check_ratio(ratio: float, where: str) -> None:
    if not (isfinite(ratio) and LEAST_RATIO <= ratio <= LARGEST_RATIO):
        raise CampaignError(
            f"{where}: must be the strut's travel over the wheel's, {LEAST_RATIO:g} to"
            f" {LARGEST_RATIO:g}; are both in the same unit, and up and compression positive?"
        )


def _at_wheel(strut: Slope, ratio: Slope) -> float:
    """Of x R²: the two are independent."""
    square = ratio.value**2
    return float(
        np.hypot(square * strut.uncertainty, 2 * strut.value * ratio.value * ratio.uncertainty)
    )
