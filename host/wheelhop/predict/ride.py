"""What a run does to its vehicle and driver: comfort, suspension travel, tyre loads."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Channel
from wheelhop.predict.case import SAMPLE_RATE_HZ, Case
from wheelhop.predict.comfort import comfort, weighted
from wheelhop.simulate import Model
from wheelhop.vehicle import axle_name, place_of, static_tyre_load, wheels

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
    tyre-lift-off lets it. What a vehicle without rear wheels does not have is NaN.
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


def ride(case: Case, number: int) -> Ride:
    """Simulate a run, without sensors, and look at it. Raises CampaignError if it runs away."""
    motion, values = case.motion(number), case.vehicle.values
    rate_hz = 1.0 / float(motion.time_s[1] - motion.time_s[0])
    felt = motion.acceleration @ driver_output(case.nominal)
    # Outputs are the body points of all wheels, then their axles.
    rolling, outputs = wheels(values), case.system.output
    bodies, hubs = outputs[: len(rolling)], outputs[len(rolling) :]
    travel = (motion.displacement @ (bodies - hubs).T)[motion.recorded]
    static = np.array([static_tyre_load(values, corner) for corner in rolling])
    load = motion.tyre_force[motion.recorded] / static
    whole = comfort(weighted(felt, rate_hz)[motion.recorded], rate_hz)
    cut = comfort(weighted(felt, rate_hz, NYQUIST_HZ)[motion.recorded], rate_hz)
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
