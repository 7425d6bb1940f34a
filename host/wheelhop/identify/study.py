"""Parameter studies: one number of suspension or wheel varied, the body as identified (figures
2.15-2.20 and 5.24 of the thesis)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.quarter_car import Struts, Wheels, compliance, on_wheels
from wheelhop.identify.statespace import StateSpace, of_fractions
from wheelhop.identify.steps import DampedSinusoids

Array = NDArray[np.float64]

QUANTITIES = ("stiffness", "damping", "unsprung-mass", "tyre")
VARIED = tuple(f"{end}{what}" for end in ("front-", "rear-", "") for what in QUANTITIES)
"""What a study may vary: of front, rear or both suspensions and wheels."""


@dataclass(frozen=True, eq=False)
class Car:
    """An identified body, N to m, on suspensions and wheels; `identified_on` are the suspensions
    held in `body`, if they are others."""

    body: StateSpace
    struts: Struts
    wheels: Wheels
    identified_on: Struts | None = None

    def ground_to_body(self, varied: str | None = None, factor: float = 1.0) -> StateSpace:
        """G(s), one number of `VARIED` times `factor`. Raises CampaignError for another name."""
        struts, wheels = self.struts, self.wheels
        if varied is not None:
            struts, wheels = _changed(struts, wheels, varied, factor)
        return on_wheels(self.body, self.identified_on or self.struts, struts, wheels)


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
    """The identified body on the suspensions and wheels of vehicle.toml.

    Raises CampaignError if not all four axle and body points were recorded.
    """
    if model.inputs != (0, 1, 2, 3) or model.outputs != (0, 1, 2, 3):
        raise CampaignError("a study needs a transfer matrix of all four axle and body points")
    struts, wheels = _struts(values), _wheels(values)
    if model.suspensions is None:
        return Car(compliance(of_fractions(model.sections, model.theta), struts), struts, wheels)
    ratio, front_s, rear_s = model.suspensions.value
    front = struts.front_N_m
    fitted = Struts(front, ratio * front, front_s * front, rear_s * ratio * front)
    return Car(of_fractions(model.sections, model.theta / front), fitted, wheels)


def car_of_steps(fitted: DampedSinusoids, values: Mapping[str, float]) -> Car:
    """The body that answered steps of force at its four points, on the suspensions of vehicle.toml
    as it was then, and its wheels.

    Raises CampaignError for fewer points, or responses that do not begin at rest.
    """
    if len(fitted.residues) != 16:
        raise CampaignError("a study needs the responses of four points to forces at all four")
    body = fitted.transfer(4, 4)
    if np.abs(body.d).max() > 1e-9 * np.abs(body.static()).max():
        raise CampaignError("a study needs step responses that begin at rest: leave out --no-rigid")
    at_rest = replace(body, d=np.zeros((4, 4)))
    return Car(at_rest, _struts(values), _wheels(values))


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


@dataclass(frozen=True, eq=False)
class Variant:
    """One curve of a study: G from the ground under one wheel to the body above it."""

    factor: float
    system: StateSpace

    @property
    def static(self) -> float:
        """Height of the body over that of the ground, everything at rest."""
        return float(self.system.static()[0, 0])

    def step(self, time_s: Array) -> Array:
        """Response (len(time_s),) to the ground stepping up by 1 m."""
        return self.system.step(time_s)[:, 0, 0]

    def wheel_hop_hz(self) -> float:
        """Frequency of the fastest pole that oscillates with ζ < 0.5."""
        poles = self.system.poles()
        rings = poles[(poles.imag > 0) & (-poles.real < 0.5 * np.abs(poles))]
        return float(np.abs(rings).max() / (2 * np.pi)) if len(rings) else float("nan")


def study(car: Car, varied: str, factors: Sequence[float], corner: int = 0) -> list[Variant]:
    """One variant for each factor; `corner` 0..3 is the wheel whose ground moves.

    Raises CampaignError for a number that cannot be varied, or a body that does not stay stable.
    """
    out = []
    for factor in factors:
        system = car.ground_to_body(varied, factor).part(corner, corner)
        if (system.poles().real >= 0).any():
            raise CampaignError(
                f"with {varied} × {factor:g} the identified body is unstable: the runs do not fix"
                " it well enough for that change; take a lower order or a smaller change"
            )
        out.append(Variant(factor, system))
    return out
