"""A model that waits to be integrated, with others of its make."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Channel
from wheelhop.simulate.frequency import ForceResponse
from wheelhop.simulate.model import Model
from wheelhop.vehicle import System

Array = NDArray[np.float64]

OFFSET = "offset_"
"""How the numbers begin that say at what extension struts rest in a run."""

PATH_KEYS = (
    *("geometry.wheelbase_m", "geometry.track_width_m"),
    *(f"wheel.{axle}.{size}_m" for axle in ("front", "rear") for size in ("radius", "width")),
)
"""The vehicle's numbers on which the wheels' path depends."""

MOVING_PLACES = ("track", "speed", "wheel", "sensor")
"""Where effects change the prescribed motion; faults of sensors do where axles are measured."""


@dataclass(eq=False)
class Job:
    """A model to be integrated, with the motion of the ground: accelerations are wanted so many per
    sample; and what applied forces do to it, once that was asked for."""

    model: Model
    system: System
    height: Array
    rate: Array
    stride: int
    per_sample: int
    key: object  #: all of the model that moves the vehicle
    mover: object  #: what the motion of the ground follows from
    acceleration: Array | None = None
    response: ForceResponse | None = None

    @property
    def make(self) -> tuple[object, ...]:
        """What models that are integrated side by side have in common."""
        s = self.system
        shapes = *s.output.shape, s.reads, s.force.shape[1], len(s.upright)
        return self.stride, self.per_sample, *shapes, s.port_law, s.laws

    @property
    def base(self) -> tuple[object, ...]:
        """What models have in common that differ in nothing but applied forces."""
        return id(self.system), self.mover, self.per_sample


def without_sensors(model: Model, run_id: str, channels: Iterable[Channel]) -> object:
    """All of the model that moves the vehicle in a run."""
    sensors = tuple(f"{e.id}." for e in model.effects if e.place == "sensor")
    still = calibrations(model, channels)
    values = {k: v for k, v in model.values.items() if not k.startswith(sensors) and k not in still}
    own = {k: v for k, v in model.runs.get(run_id, {}).items() if not k.startswith(sensors)}
    effects = [e for e in model.effects if e.place != "sensor"]
    return values, own, effects, heights_of(model, run_id)


def moved_by(model: Model, run_id: str, measured: Sequence[Channel]) -> list[object]:
    """What of a model the prescribed motion of a run follows from. Axles, or struts, that are
    `measured` move as they did, whatever the vehicle."""
    upstream = [e for e in model.effects if e.place in MOVING_PLACES]
    theta = [(e, *model.theta(e, run_id).items()) for e in upstream]
    if measured:
        own = model.runs.get(run_id, {}).items()
        rest = [item for item in own if item[0].startswith(OFFSET)]
        return [*calibrations(model, measured).items(), *rest, *theta]
    path = [model.values.get(key, 0.0) for key in PATH_KEYS]
    placed = [item for item in model.runs.get(run_id, {}).items() if "." not in item[0]]
    return [*path, *placed, heights_of(model, run_id), *theta]


def calibrations(model: Model, channels: Iterable[Channel]) -> dict[str, float]:
    """By how much gains and corners of sensors are not what they are believed to be."""
    names = [f"{c.key}.{what}" for c in channels for what in ("gain", "corner")]
    return {name: model.values[name] for name in names if name in model.values}


def heights_of(model: Model, run_id: str) -> bytes:
    """The heights of a run, to be compared."""
    return model.heights[run_id].tobytes() if run_id in model.heights else b""
