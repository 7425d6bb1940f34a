"""Parameter studies: one number of suspension or wheel varied, the body as identified (figures
2.15-2.20 and 5.24 of the thesis)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.campaign import CampaignError
from wheelhop.identify.legs import Legs, closed
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.quarter_car import (
    Bushings,
    Part,
    Struts,
    Wheels,
    compliance,
    free_motion,
    legs,
    rigid_inertia,
)
from wheelhop.identify.statespace import StateSpace, of_fractions
from wheelhop.identify.steps import DampedSinusoids
from wheelhop.identify.structure import VERTICAL
from wheelhop.vehicle import (
    CORNERS,
    axle_name,
    body_inertia,
    corner_position,
    kinetic_shares,
    wheels,
)

Array = NDArray[np.float64]

BUSHING = "bushing"
QUANTITIES = ("stiffness", "damping", "unsprung-mass", "tyre", BUSHING)
VARIED = tuple(f"{end}{what}" for end in ("front-", "rear-", "") for what in QUANTITIES)
"""What a study may vary: of front, rear or both suspensions and wheels."""
HALVES: Mapping[str, tuple[int, int]] = {
    "left": (0, 2),
    "right": (1, 3),
    "front": (0, 1),
    "rear": (2, 3),
}
"""Corners of a half car: of a side it heaves and pitches, of an axle it heaves and rolls."""


@dataclass(frozen=True)
class WheelHop:
    """A mode in which the wheels move: natural frequency |λ|/2π, Hz, and damping ratio −Re λ/|λ|,
    below 1."""

    frequency_hz: float
    damping_ratio: float


@dataclass(frozen=True, eq=False)
class Car:
    """An identified body, N to m, on suspensions and wheels.

    `sprung_kg` (4, 4) is the body's inertia at its four points (`rigid_inertia`): by it modes of
    the body and of the wheels are told apart. `identified_on` are the suspensions held in `body`,
    if they are others.
    """

    body: StateSpace
    struts: Struts
    wheels: Wheels
    sprung_kg: Array
    identified_on: Struts | None = None
    bushings: Bushings | None = None
    part: Part | None = None

    def varied(self, varied: str, factor: float) -> Car:
        """This car with one number of `VARIED` times `factor`. Raises CampaignError for another
        name."""
        if varied.endswith(BUSHING):
            return replace(self, bushings=_scaled(self.bushings, varied, factor))
        struts, wheels = _changed(self.struts, self.wheels, varied, factor)
        return replace(self, struts=struts, wheels=wheels, identified_on=self._held)

    def ground_to_body(self) -> StateSpace:
        """G(s), from the ground under the wheels to the body (4, 4)."""
        return closed(self.body, self._legs)

    def half_car(self, which: str) -> StateSpace:
        """The generalized half car (thesis 2.12): from the ground under two wheels to the body
        above them (2, 2), the other two wheels standing on the ground; `which` is a name of
        `HALVES`."""
        return self.ground_to_body().block(HALVES[which])

    def wheel_hops(self, end: str) -> tuple[WheelHop, ...]:
        """Modes of the wheels at one end, "front" or "rear", that oscillate, by frequency.

        Their shape tells them: wheels have more of the kinetic energy than the body has, and
        those at this end more than those at the other. None is left where damping is so strong
        that the wheels creep back.
        """
        pole, shape = free_motion(self.body, self._legs)
        unsprung = self._legs.mass_kg
        unsprung = unsprung[unsprung[:, 0] > 0.0]
        mass = linalg.block_diag(self.sprung_kg, np.diag(unsprung.ravel()))
        share = kinetic_shares(shape, mass)[:, 4:]
        share = share.reshape(len(pole), len(unsprung), 4).sum(axis=1)
        front, rear = share[:, :2].sum(axis=1), share[:, 2:].sum(axis=1)
        here, there = (front, rear) if end == "front" else (rear, front)
        hops = sorted(pole[(front + rear > 0.5) & (here > there)].tolist(), key=abs)
        return tuple(WheelHop(abs(one) / (2 * np.pi), -one.real / abs(one)) for one in hops)

    @property
    def _held(self) -> Struts:
        return self.identified_on or self.struts

    @property
    def _legs(self) -> Legs:
        return legs(self._held, self.struts, self.wheels, self.bushings, self.part)


def _scaled(bushings: Bushings | None, varied: str, factor: float) -> Bushings:
    if varied not in VARIED or bushings is None:
        raise CampaignError(
            f'a study of "{varied}" needs a bushing in line with the struts, and a name of'
            f" {', '.join(name for name in VARIED if name.endswith(BUSHING))}: --bushing FILE.toml"
        )
    front, rear = bushings.factor
    here = (
        front if varied.startswith("rear") else front * factor,
        rear if varied.startswith("front") else rear * factor,
    )
    return replace(bushings, factor=here)


def _changed(struts: Struts, wheels: Wheels, varied: str, factor: float) -> tuple[Struts, Wheels]:
    if varied not in VARIED:
        raise CampaignError(f'a study cannot vary "{varied}"; it can vary {", ".join(VARIED)}')
    what = varied.removeprefix("front-").removeprefix("rear-")
    ends = [end for end in ("front", "rear") if varied in (what, f"{end}-{what}")]
    if what in ("stiffness", "damping"):
        unit = "N_m" if what == "stiffness" else "N_s_m"
        keys = [f"{end}_{unit}" for end in ends]
        return replace(struts, **{key: factor * getattr(struts, key) for key in keys}), wheels
    key = "mass_kg" if what == "unsprung-mass" else "stiffness_N_m"
    front, rear = (
        value * (factor if end in ends else 1.0)
        for end, value in zip(("front", "rear"), getattr(wheels, key), strict=True)
    )
    return struts, replace(wheels, **{key: (front, rear)})


def car_of(model: TransferMatrix, values: Mapping[str, float]) -> Car:
    """The identified body on the suspensions and wheels of vehicle.toml; axles do not move fore and
    aft in it.

    Raises CampaignError if not all four axle and body points were recorded.
    """
    theta = model.theta[:, :VERTICAL]
    if model.inputs[:VERTICAL] != (0, 1, 2, 3) or model.outputs != (0, 1, 2, 3):
        raise CampaignError("a study needs a transfer matrix of all four axle and body points")
    struts, wheels, sprung = _struts(values), _wheels(values), _sprung(values)
    if model.suspensions is None:
        body = compliance(of_fractions(model.sections, theta), struts)
        return Car(body, struts, wheels, sprung)
    ratio, front_s, rear_s = model.suspensions.value
    front = struts.front_N_m
    fitted = Struts(front, ratio * front, front_s * front, rear_s * ratio * front)
    return Car(of_fractions(model.sections, theta / front), fitted, wheels, sprung)


def car_of_steps(fitted: DampedSinusoids, values: Mapping[str, float]) -> Car:
    """The body that answered steps of force at its four points, on the suspensions of vehicle.toml
    as it was then, and its wheels.

    Raises CampaignError for fewer points, responses that do not begin at rest, or a vehicle that is
    no full car.
    """
    if len(fitted.residues) != 16:
        raise CampaignError("a study needs the responses of four points to forces at all four")
    sprung = _sprung(values)
    body = fitted.transfer(4, 4)
    if np.abs(body.d).max() > 1e-9 * np.abs(body.static()).max():
        raise CampaignError("a study needs step responses that begin at rest: leave out --no-rigid")
    at_rest = replace(body, d=np.zeros((4, 4)))
    return Car(at_rest, _struts(values), _wheels(values), sprung)


def _struts(values: Mapping[str, float]) -> Struts:
    return Struts(
        *(values[f"suspension.{end}.stiffness_N_m"] for end in ("front", "rear")),
        *(values[f"suspension.{end}.damping_N_s_m"] for end in ("front", "rear")),
    )


def _wheels(values: Mapping[str, float]) -> Wheels:
    return Wheels(
        *(
            (values[f"wheel.front.{key}"], values[f"wheel.rear.{key}"])
            for key in ("unsprung_mass_kg", "tyre_stiffness_N_m", "tyre_damping_N_s_m")
        )
    )


def _sprung(values: Mapping[str, float]) -> Array:
    if wheels(values) != CORNERS:
        raise CampaignError("a study needs a full car: leave `model` out of vehicle.toml")
    positions = np.array([corner_position(values, corner) for corner in CORNERS])
    return rigid_inertia(positions, body_inertia(values))


@dataclass(frozen=True, eq=False)
class Variant:
    """One curve of a study: G from the ground under one wheel to the body above it, and the wheel
    hops of that wheel's axle."""

    factor: float
    system: StateSpace
    wheel_hops: tuple[WheelHop, ...]

    @property
    def static(self) -> float:
        """Height of the body over that of the ground, everything at rest."""
        return float(self.system.static()[0, 0])

    def step(self, time_s: Array) -> Array:
        """Response (len(time_s),) to the ground stepping up by 1 m."""
        return self.system.step(time_s)[:, 0, 0]


def study(car: Car, varied: str, factors: Sequence[float], corner: int = 0) -> list[Variant]:
    """One variant for each factor; `corner` 0..3 is the wheel whose ground moves.

    Raises CampaignError for a number that cannot be varied, or a body that does not stay stable.
    """
    out = []
    for factor in factors:
        changed = car.varied(varied, factor)
        system = changed.ground_to_body().part(corner, corner)
        check_stable(system, f"{varied} × {factor:g}")
        out.append(Variant(factor, system, changed.wheel_hops(axle_name(corner))))
    return out


def check_stable(system: StateSpace, changed: str) -> None:
    """Raise CampaignError for a car that does not stay in its place with what was `changed`."""
    if (system.poles().real >= 0).any():
        raise CampaignError(
            f"with {changed} the identified body is unstable: the runs do not fix it well enough"
            " for that change; take a lower order or a smaller change"
        )
