"""Where a force can act, and how each such place moved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import RigRun
from wheelhop.diagnose.probe import FitProbe
from wheelhop.fit import Workshop
from wheelhop.simulate import Model
from wheelhop.vehicle import CORNERS, Motion, axle_name, is_component, strut_at, tyre, wheels
from wheelhop.vehicle.assembly import Row

Array = NDArray[np.float64]
CORNER_NAMES = ("front left", "front right", "rear left", "rear right")

Kind = Literal["strut", "tyre"]


@dataclass(frozen=True)
class Where:
    """A place: the struts or tyres of these corners, which share one law; on a rig the component,
    corner 0."""

    name: str
    kind: Kind
    corners: tuple[int, ...]

    def rows(self, vehicle: Mapping[str, float]) -> list[Row]:
        """The extensions along which the force acts."""
        if self.kind == "tyre":
            return [tyre(i) for i in self.corners]
        return [strut_at(vehicle, i).row for i in self.corners]

    def linear(self, vehicle: Mapping[str, float]) -> tuple[float, float]:
        """Stiffness, N/m, and damping, N s/m, that are there."""
        if self.kind == "tyre":
            return vehicle[f"wheel.{axle_name(self.corners[0])}.tyre_stiffness_N_m"], 0.0
        strut = strut_at(vehicle, self.corners[0])
        return strut.stiffness_N_m, strut.damping_N_s_m

    @property
    def linear_keys(self) -> tuple[str, ...]:
        """The numbers that are this place's stiffness and damping, and no other place's."""
        if self.name != "component":
            return ()
        return "component.stiffness_N_m", "component.damping_N_s_m"

    def load_N(self, vehicle: Mapping[str, float]) -> float:
        """The load that is usual for one part of the place."""
        return strut_at(vehicle, self.corners[0]).usual.load_N


@dataclass(frozen=True, eq=False)
class Moved:
    """How a place moved in the runs fitted: extension (T,), m, and rate (T,), m/s, one stretch
    after the other; `stretches` holds the length of each, and `inputs` what else was recorded."""

    extension: Array
    rate: Array
    stretches: tuple[int, ...]
    inputs: Mapping[str, Array] = field(default_factory=dict)


def places(vehicle: Mapping[str, float]) -> list[Where]:
    """Every place where a force can act, the simplest statement first."""
    if is_component(vehicle):
        return [Where("component", "strut", (0,))]
    every = wheels(vehicle)
    groups = {"all": every}
    if len(every) == len(CORNERS):
        groups |= {"front": every[:2], "rear": every[2:]}
    both: tuple[Kind, ...] = ("strut", "tyre")
    together = [Where(f"{which} {kind}s", kind, groups[which]) for kind in both for which in groups]
    if len(every) == 1:
        return together
    return [*together, *(_alone(corner) for corner in every)]


def of_axle(where: Where, vehicle: Mapping[str, float]) -> Where:
    """The place on the same axle, or axles, whose motion a law's knots follow."""
    if where.name == "component":
        return where
    axles = {axle_name(corner) for corner in where.corners}
    same = tuple(corner for corner in wheels(vehicle) if axle_name(corner) in axles)
    return Where(where.name, where.kind, same)


def parts_of(where: Where) -> list[Where]:
    """Struts of which each is known by itself, to first order; else the place as it is."""
    if where.kind == "tyre" or len(where.corners) != 2:
        return [where]
    return [_alone(corner) for corner in where.corners]


def _alone(corner: int) -> Where:
    return Where(f"{CORNER_NAMES[corner]} strut", "strut", (corner,))


def motion_of(workshop: Workshop, model: Model, where: Where) -> Moved | None:
    """How the place moved; None where nothing tells."""
    benches = workshop.of_role("fit")
    ways: list[tuple[Array, Array]] = []
    probe = FitProbe(workshop, model, benches)
    for bench in benches:
        run = bench.run
        if isinstance(run, RigRun):
            x, v, _ = Motion(workshop.campaign, run).at(run.time_s)  # type: ignore[arg-type]
            ways.append((x, v))
        elif where.kind == "strut":
            travel = probe.travel(run.id)
            for corner in where.corners:
                if axle_name(corner) in travel:
                    ends = travel[axle_name(corner)]
                    x = ends[:, min(corner % 2, ends.shape[1] - 1)]
                    ways.append((x, np.gradient(x, run.time_s)))
    if not ways:
        return None
    runs = [bench.run for bench in benches if isinstance(bench.run, RigRun)]
    names = runs[0].inputs if runs else ()
    inputs = {name: np.concatenate([run.inputs[name] for run in runs]) for name in names}
    return replace(_joined(ways), inputs=inputs)


def _joined(ways: Sequence[tuple[Array, Array]]) -> Moved:
    x, v = (np.concatenate(part) for part in zip(*ways, strict=True))
    return Moved(x, v, tuple(len(one) for one, _ in ways))
