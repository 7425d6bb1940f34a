"""What a run does to its vehicle and driver: comfort, suspension travel, tyre loads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import nan

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Channel
from wheelhop.fit.bench import RUNS_AWAY
from wheelhop.predict.case import SAMPLE_RATE_HZ, Case, stands
from wheelhop.predict.comfort import comfort, weighted
from wheelhop.simulate import Model
from wheelhop.simulate.motion import Shown, tyre_forces, watching
from wheelhop.vehicle import System, axle_name, motions, place_of, static_tyre_load, wheels

Array = NDArray[np.float64]
NYQUIST_HZ = SAMPLE_RATE_HZ / 2
"""What a logger of 100 samples a second can show; the weighting goes on to 80 Hz and more."""


@dataclass(frozen=True)
class Ride:
    """One run. Units are in the names, which are also the columns of a sweep.

    `comfort_wk_rms_m_s2` and `comfort_vdv_m_s1_75` are after ISO 2631-1, Wk, vertical, over the
    whole band: of the driver, if there is a seat in the model, else of the body where he sits
    (without [driver]: at its centre of mass);
    `comfort_wk_rms_below_50_hz_m_s2` is what a logger of 100 Hz would find. Travel is that of both
    struts of an axle about the static position. `dynamic_load_…` is the dynamic load coefficient of
    an axle's tyres, r.m.s. over static load; `tyre_load_least` the least load any tyre bears over
    its static one: below 0 the wheel would have left the ground, and only a model with
    tyre-lift-off lets it. `roll_rms_rad` is that of the body. What a vehicle does not have, rear
    wheels or roll, is NaN.
    """

    comfort_wk_rms_m_s2: float
    comfort_wk_rms_below_50_hz_m_s2: float
    comfort_vdv_m_s1_75: float
    travel_front_rms_m: float
    travel_front_peak_m: float
    travel_rear_rms_m: float
    travel_rear_peak_m: float
    dynamic_load_front: float
    dynamic_load_rear: float
    tyre_load_least: float
    roll_rms_rad: float


def ride(case: Case, number: int) -> Ride:
    """Simulate a run, without sensors, and look at it. Raises CampaignError if it runs away."""
    (found,) = Rider(case, number).rides([{}])
    if found is None:
        raise case.runs_away(number)
    return found


class Rider:
    """One run of a case, prepared for many rides on the same ground. Each runs up for as long as
    the case's own vehicle needs, or `run_up_s`."""

    def __init__(self, case: Case, number: int, run_up_s: float = 0.0) -> None:
        self._case = case
        self._simulator, self._model = case.prepared(number, run_up_s)

    @RUNS_AWAY
    def rides(self, changes: Sequence[Mapping[str, float]]) -> list[Ride | None]:
        """What the run does where numbers of the model are others, by their dotted names; None
        where the vehicle does not stay in its place."""
        models = [self._model.with_values(change) for change in changes]
        systems = [model.system(self._case.channels, "road") for model in models]
        holds = [i for i, system in enumerate(systems) if stands(system)]
        shown = self._simulator.shown([(models[i], watched(models[i], systems[i])) for i in holds])
        found: list[Ride | None] = [None] * len(models)
        for i, one in zip(holds, shown, strict=True):
            if np.isfinite(one.values).all():
                found[i] = _ride(models[i].values, one)
        return found


def watched(model: Model, system: System) -> System:
    """The mechanism with outputs that show what a `Ride` is made of: the acceleration the driver
    feels, and as readings the travel of the struts, the tyres' forces and the body's roll."""
    count = len(wheels(model.values))
    n = len(system.mass)
    travel = np.zeros((count, system.reading_width))
    travel[:, :n] = system.output[:count] - system.output[count:]  # body points, then axles
    roll = np.zeros((1, system.reading_width))
    if "roll" in system.coordinates:
        roll[0, system.coordinates.index("roll")] = 1.0
    return watching(
        system, driver_output(model)[None, :], np.vstack([travel, tyre_forces(system), roll])
    )


def _ride(values: Mapping[str, float], shown: Shown) -> Ride:
    rate_hz = 1.0 / float(shown.time_s[1] - shown.time_s[0])
    rolling, recorded = wheels(values), shown.recorded
    count = len(rolling)
    felt, seen = shown.values[:, 0], shown.values[recorded]
    travel, force, roll = np.split(seen[:, 1:], [count, 2 * count], axis=1)
    load = force / np.array([static_tyre_load(values, corner) for corner in rolling])
    whole = comfort(weighted(felt, rate_hz)[recorded], rate_hz)
    cut = comfort(weighted(felt, rate_hz, NYQUIST_HZ)[recorded], rate_hz)
    front, rear = (
        [j for j, i in enumerate(rolling) if axle_name(i) == end] for end in ("front", "rear")
    )
    return Ride(
        whole.rms_m_s2,
        cut.rms_m_s2,
        whole.vdv_m_s1_75,
        _rms(travel[:, front]),
        _peak(travel[:, front]),
        _rms(travel[:, rear]),
        _peak(travel[:, rear]),
        _rms(load[:, front]),
        _rms(load[:, rear]),
        float(1.0 + load.min()),
        _rms(roll) if "roll" in motions(values) else nan,
    )


def driver_output(model: Model) -> Array:
    """What the driver feels, as a row over the coordinates: himself on a seat, or where he sits."""
    place = place_of(model.values, "driver")
    channel = Channel("driver", "body-xy", place.x_m, place.y_m)
    system = model.system([channel], "road")
    if "driver" not in system.coordinates:
        return np.asarray(system.output[0])
    return np.asarray(np.eye(len(system.mass))[system.coordinates.index("driver")])


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else nan


def _peak(values: Array) -> float:
    return float(np.abs(values).max()) if values.size else nan
